// Strata of the sphere of directions: square blocks of texels, small where the environment is bright or
// varies. One direction uniform in each, and from a direction back to its block.
#pragma once

#include <vector>

#include "core/math.h"
#include "core/vector_bytes.h"
#include "scene/environment.h"

namespace halflight {

class EnvironmentCells {
 public:
  EnvironmentCells() = default;
  /// At most `count` blocks, from splitting whichever would be missed most: the root mean square of what a
  /// point uniform in it would err by, and a share of its light for the angle that it spans. A single texel
  /// is split no further. Keeps no reference; the map's texels, not its rotation or strength, decide.
  EnvironmentCells(const Environment&, uint32_t count);

  uint32_t size() const { return static_cast<uint32_t>(cells_.size()); }
  /// Uniform by solid angle, as the environment stands now. `u` in [0, 1)².
  Vec3 draw(const Environment&, uint32_t cell, Vec2 u) const;
  uint32_t cell_of(const Environment& environment, Vec3 direction) const {
    return cell_of(environment_texel(environment, direction));
  }
  uint32_t cell_of(glm::ivec2 texel) const;
  float solid_angle(uint32_t cell) const { return cells_[cell].solid_angle; }
  size_t held_bytes() const { return vector_bytes(nodes_, cells_, entries_); }
  /// Mean over the cell of the map, in units of its strength.
  Vec3 mean_radiance(uint32_t cell) const { return cells_[cell].mean; }

 private:
  struct Block {
    int x, y, level;  ///< texels [x, x + 2^level) × [y, y + 2^level), as far as the map goes
  };
  struct Node {
    Block block;
    int32_t children = -1;  ///< four of them in a row; −1: a cell
    uint32_t cell = 0;
  };
  struct Cell {
    Block block;
    Vec3 mean;
    float solid_angle;
  };

  void make_entries();
  /// The child of a node that holds a texel of its block.
  static uint32_t child_at(const Node& node, glm::ivec2 texel) {
    const int bit = node.block.level - 1;
    return static_cast<uint32_t>(node.children + (texel.x >> bit & 1) + 2 * (texel.y >> bit & 1));
  }

  std::vector<Node> nodes_;
  std::vector<Cell> cells_;
  int width_ = 0, height_ = 0;
  /// Where to enter the tree for each block of 2^entry_level_ texels: row by row, entry_columns_ to a row.
  std::vector<uint32_t> entries_;
  int entry_level_ = 0, entry_columns_ = 0;
};

}  // namespace halflight
