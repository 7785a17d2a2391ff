// A coarse grid over a scene's triangles: a few ten thousand rays before there is a proper acceleration
// structure.
#pragma once

#include <array>
#include <vector>

#include "core/math.h"
#include "scene/scene.h"

namespace halflight {

/// Cubic cells over the scene's bounds, a fixed number along the longest side. Cells that hold very many
/// triangles count as solid blocks and of huge scenes only a part is taken, so that neither building nor
/// casting can take long.
class RayGrid {
 public:
  explicit RayGrid(const Scene&);

  struct Hit {
    float distance = infinity;  ///< infinity: the ray leaves the bounds
    bool front = false;         ///< the side the winding calls the front
    bool found() const { return distance < infinity; }
  };

  /// First surface along a unit direction, in world units.
  Hit cast(Vec3 origin, Vec3 direction) const;

  UVec3 size() const { return size_; }
  float cell() const { return cell_; }
  Vec3 cell_centre(UVec3 c) const { return low_ + cell_ * (Vec3(c) + 0.5f); }
  bool empty(UVec3 c) const { return begin_[index(c)] == begin_[index(c) + 1]; }

 private:
  size_t index(UVec3 c) const { return c.x + size_.x * (c.y + static_cast<size_t>(size_.y) * c.z); }
  Vec3 to_grid(Vec3 p) const { return (p - low_) / cell_; }
  std::array<Vec3, 3> grid_triangle(uint32_t triangle) const;
  template <class Visit>
  void for_each_piece(const Scene&, const Visit&) const;
  template <class Visit>
  void for_each_cell(uint32_t triangle, const Visit&) const;
  void choose_size(const Scene&);
  void fill(const Scene&);
  Hit cast_in_cell(size_t cell_index, Vec3 origin, Vec3 direction, float entry, float exit) const;

  const Scene* scene_;
  Vec3 low_{0};
  float cell_ = 1;
  UVec3 size_{1};
  uint32_t stride_ = 1;                      ///< every stride-th triangle is in the grid
  std::vector<uint32_t> begin_, triangles_;  ///< per cell a range of triangles
  std::vector<Vec3> normal_sum_;  ///< of a cell's triangles, area-weighted: the facing of solid cells
};

}  // namespace halflight
