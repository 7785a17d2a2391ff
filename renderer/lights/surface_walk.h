// Moving a point over the surface of a mesh: across an edge the way goes on in the neighbouring triangle's
// plane.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "scene/scene.h"
#include "scene/shading.h"

namespace halflight {

/// Which triangle lies across each edge; edge i is opposite corner i. Corners at the same place count as one.
class TriangleNeighbours {
 public:
  /// Of `triangles` only: to their points the surface ends where the others begin.
  TriangleNeighbours(const Scene&, std::span<const uint32_t> triangles);

  /// Triangle across edge `edge`, or `none` at a border and where more than two meet.
  uint32_t across(uint32_t triangle, int edge) const { return across_[triangle][static_cast<size_t>(edge)]; }
  static constexpr uint32_t none = 0xffffffffu;

  /// Whether the surface ends at the edge or turns by more than 60° there.
  bool folds(uint32_t triangle, int edge) const { return (folds_[triangle] >> edge & 1) != 0; }

 private:
  void join(const Scene&, uint32_t a, int edge_a, uint32_t b, int edge_b);

  std::vector<std::array<uint32_t, 3>> across_;
  std::vector<uint8_t> folds_;  ///< a bit an edge
};

/// The point reached by going `displacement` (its part in the triangle's plane) from `start`. At a border it
/// stops a little before the edge: a light exactly in the corner of a room would see what lies behind it.
SurfacePoint walk_surface(const Scene&, const TriangleNeighbours&, SurfacePoint start, Vec3 displacement);

}  // namespace halflight
