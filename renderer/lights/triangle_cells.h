// Strata on triangles: each a piece of a large triangle, or a run of small ones. One point uniform in each,
// and from a point back to its stratum in constant time (ESTIMATORS: "Continuous mode").
#pragma once

#include <span>
#include <vector>

#include "core/math.h"
#include "core/vector_bytes.h"
#include "scene/scene.h"
#include "scene/shading.h"

namespace halflight {

class TriangleCells {
 public:
  static constexpr uint32_t none = 0xffffffffu;

  TriangleCells() = default;
  /// About `count` cells over `triangles`, which hold about equal shares of `weights` (areas or powers, one a
  /// triangle, > 0) each. A triangle of k² shares is cut into k² congruent pieces; neighbours in the list of
  /// less than a share join into one cell, where each is drawn in proportion to its weight.
  TriangleCells(const Scene&, std::span<const uint32_t> triangles, std::span<const double> weights,
                uint32_t count);

  uint32_t size() const { return cells_.empty() ? 0 : static_cast<uint32_t>(cells_.size() - 1); }

  /// A point of the cell; `choose` says which triangle of a run, `u` where on it. All uniform in [0, 1).
  SurfacePoint draw(uint32_t cell, float choose, Vec2 u) const;
  /// The cell that holds a point; `none` on a triangle that was not listed.
  uint32_t cell_of(SurfacePoint) const;
  /// 1 over the density per area with which `draw` finds points of the triangle in their cell: the piece's
  /// area, or what the run as a whole makes of the triangle's. 0 where it was not listed.
  float measure(uint32_t triangle) const;
  size_t held_bytes() const { return vector_bytes(entries_, entry_, cells_); }

 private:
  struct Entry {
    uint32_t triangle;
    uint32_t first_cell;
    uint32_t pieces;  ///< along an edge; 1 for members of runs
    float measure;
    float run_end;  ///< running share of its run up to this triangle's end; 1 at the last
  };

  void end_run(std::span<const double> run, double run_weight);

  std::vector<Entry> entries_;
  std::vector<uint32_t> entry_;  ///< of each triangle of the scene, or `none`
  std::vector<uint32_t> cells_;  ///< first entry of each cell, and one past the last
};

}  // namespace halflight
