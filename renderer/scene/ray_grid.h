// A coarse grid over a scene's triangles: a few ten thousand rays before there is a proper acceleration
// structure.
#pragma once

#include <array>
#include <vector>

#include "core/math.h"
#include "scene/scene.h"

namespace halflight {

/// Cubic cells over the scene's bounds, 48 along the longest side, or half as many, and half again, where
/// triangles would lie in very many. Cells that hold very many triangles count as solid blocks and of huge
/// scenes only a part is taken, so that neither building nor casting can take long.
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
  bool empty(UVec3 c) const { return kinds_[index(c)] == CellKind::empty; }

 private:
  enum class CellKind : uint8_t { empty, triangles, solid };
  struct Reference {
    uint32_t cell, triangle;
  };
  /// What a part of the triangles meets.
  struct Piece {
    std::vector<Reference> references;
    std::vector<Vec3> normal_sum;  ///< per cell, as below
  };
  static constexpr size_t pieces = 4;

  size_t index(UVec3 c) const { return c.x + size_.x * (c.y + static_cast<size_t>(size_.y) * c.z); }
  size_t cells() const { return static_cast<size_t>(size_.x) * size_.y * size_.z; }
  Vec3 to_grid(Vec3 p) const { return (p - low_) * cells_per_unit_; }
  std::array<Vec3, 3> grid_triangle(uint32_t triangle) const;
  size_t find_cells_of(uint32_t triangle, Piece&) const;
  bool find_cells(bool done, std::array<Piece, pieces>&) const;
  void fill(const std::array<Piece, pieces>&);
  Hit cast_in_cell(size_t cell_index, Vec3 origin, Vec3 direction, float entry, float exit) const;

  const Scene* scene_;
  Vec3 low_{0};
  float cell_ = 1, cells_per_unit_ = 1;
  UVec3 size_{1};
  std::vector<CellKind> kinds_;
  std::vector<uint32_t> begin_, triangles_;  ///< per cell a range of triangles, none for solid ones
  std::vector<Vec3> normal_sum_;  ///< of a cell's triangles, area-weighted: the facing of solid cells
};

}  // namespace halflight
