// Moving a point over the surface of a mesh: across an edge the way goes on in the neighbouring triangle's
// plane.
#pragma once

#include <array>
#include <vector>

#include "scene/scene.h"
#include "scene/shading.h"

namespace halflight {

/// Which triangle lies across each edge; edge i is opposite corner i. Corners at the same place count as one.
class TriangleNeighbours {
 public:
  explicit TriangleNeighbours(const Scene&);

  /// Triangle across edge `edge`, or `none` at a border and where more than two meet.
  uint32_t across(uint32_t triangle, int edge) const { return across_[triangle][static_cast<size_t>(edge)]; }
  static constexpr uint32_t none = 0xffffffffu;

 private:
  std::vector<std::array<uint32_t, 3>> across_;
};

/// The point reached by going `displacement` (its part in the triangle's plane) from `start`; stops at
/// borders.
SurfacePoint walk_surface(const Scene&, const TriangleNeighbours&, SurfacePoint start, Vec3 displacement);

}  // namespace halflight
