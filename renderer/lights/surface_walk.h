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
/// Refers to the scene: what lies across is looked up when asked for, since points visit few of many
/// triangles.
class TriangleNeighbours {
 public:
  /// Of `triangles` only: to their points the surface ends where the others begin.
  TriangleNeighbours(const Scene&, std::span<const uint32_t> triangles);

  /// Triangle across edge `edge`, or `none` at a border and where more than two meet.
  uint32_t across(uint32_t triangle, int edge) const;
  static constexpr uint32_t none = 0xffffffffu;

  /// Whether the surface ends at the edge or turns by more than 60° there.
  bool folds(uint32_t triangle, int edge) const;

 private:
  const Scene* scene_;
  // The order within a place's list, and which vertex stands for a place, depend on threads; what `across`
  // finds does not.
  std::vector<uint32_t> place_;      ///< of each vertex: a vertex that stands for its place
  std::vector<uint32_t> first_;      ///< by place: where its triangles begin; one more at the end
  std::vector<uint32_t> triangles_;  ///< those that have a corner there
};

/// The point reached by going `displacement` (its part in the triangle's plane) from `start`. At a border it
/// stops a little before the edge: a light exactly in the corner of a room would see what lies behind it.
SurfacePoint walk_surface(const Scene&, const TriangleNeighbours&, SurfacePoint start, Vec3 displacement);

}  // namespace halflight
