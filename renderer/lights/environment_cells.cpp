#include "lights/environment_cells.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <queue>

#include "core/parallel.h"

namespace halflight {

namespace {

// A share of a block's light, for each radian that it spans, that stands for what the BRDF and visibility
// vary over it.
constexpr double error_of_angle = 0.25;

/// Sums over the texels of a block.
struct Sums {
  double light = 0, square = 0, solid_angle = 0;  ///< ∫ Y, ∫ Y², ∫ 1, over directions

  Sums& operator+=(const Sums& o) {
    light += o.light, square += o.square, solid_angle += o.solid_angle;
    return *this;
  }
};

/// Sums of all blocks of a level, row by row.
struct Level {
  int columns = 0, rows = 0;
  std::vector<Sums> sums;

  Level(int fine_columns, int fine_rows)
      : columns((fine_columns + 1) / 2),
        rows((fine_rows + 1) / 2),
        sums(static_cast<size_t>(columns) * static_cast<size_t>(rows)) {}
  const Sums& at(int x, int y) const { return sums[static_cast<size_t>(y * columns + x)]; }
  Sums& at(int x, int y) { return sums[static_cast<size_t>(y * columns + x)]; }
};

/// Levels 1, of blocks of 2×2 texels, to the one block that holds all; radiances in units of `unit`.
std::vector<Level> pyramid(const Environment& environment, float unit) {
  const ImageRgb& map = environment.map;
  std::vector<Level> levels{Level(map.width, map.height)};
  parallel_for(0, static_cast<size_t>(levels[0].rows), 8, [&](size_t begin, size_t end) {
    const int last = std::min(2 * static_cast<int>(end), map.height);
    for (int y = 2 * static_cast<int>(begin); y < last; ++y) {
      const double omega = texel_solid_angle(environment, y);
      for (int x = 0; x < map.width; ++x) {
        const double value = luminance(map.at(x, y) / unit);
        levels[0].at(x / 2, y / 2) += {value * omega, value * value * omega, omega};
      }
    }
  });
  while (levels.back().columns > 1 || levels.back().rows > 1) {
    const Level& fine = levels.back();
    Level coarse(fine.columns, fine.rows);
    for (int y = 0; y < fine.rows; ++y)
      for (int x = 0; x < fine.columns; ++x) coarse.at(x / 2, y / 2) += fine.at(x, y);
    levels.push_back(std::move(coarse));
  }
  return levels;
}

double split_gain(const Sums& s) {
  const double spread = std::sqrt(std::max(0.0, s.solid_angle * s.square - s.light * s.light));
  return spread + error_of_angle * s.light * std::sqrt(s.solid_angle);
}

}  // namespace

EnvironmentCells::EnvironmentCells(const Environment& environment, uint32_t count) {
  if (!environment.present() || count == 0) return;
  const ImageRgb& map = environment.map;
  width_ = map.width, height_ = map.height;
  float brightest = 0;
  for (const Vec3& texel : map.pixels) brightest = std::max(brightest, max_component(texel));
  const std::vector<Level> levels = pyramid(environment, brightest > 0 ? brightest : 1.0f);
  const auto sums_of = [&](const Block& b) {
    const Level& level = levels[static_cast<size_t>(b.level) - 1];
    const int x = b.x >> b.level, y = b.y >> b.level;
    return x < level.columns && y < level.rows ? level.at(x, y) : Sums{};
  };

  std::priority_queue<std::pair<double, uint32_t>> open;
  uint32_t leaves = 1;
  const auto add = [&](const Block& block) {
    nodes_.push_back({block});
    if (block.level > 0) open.push({split_gain(sums_of(block)), static_cast<uint32_t>(nodes_.size() - 1)});
  };
  add({0, 0, static_cast<int>(levels.size())});
  while (!open.empty() && leaves + 3 <= count && open.top().first > 0) {
    const uint32_t index = open.top().second;
    open.pop();
    const Block b = nodes_[index].block;
    nodes_[index].children = static_cast<int32_t>(nodes_.size());
    const int level = b.level - 1, side = 1 << level;
    for (int child = 0; child < 4; ++child) add({b.x + child % 2 * side, b.y + child / 2 * side, level});
    leaves += 3;
  }
  for (Node& node : nodes_) {
    const Block& b = node.block;
    if (node.children >= 0 || b.x >= width_ || b.y >= height_) continue;
    node.cell = static_cast<uint32_t>(cells_.size());
    Vec3d light(0);
    double solid_angle = 0;
    for (int y = b.y; y < std::min(b.y + (1 << b.level), height_); ++y) {
      const double omega = texel_solid_angle(environment, y);
      for (int x = b.x; x < std::min(b.x + (1 << b.level), width_); ++x)
        light += Vec3d(map.at(x, y)) * omega, solid_angle += omega;
    }
    cells_.push_back({b, Vec3(light / solid_angle), static_cast<float>(solid_angle)});
  }
  make_entries();
}

Vec3 EnvironmentCells::draw(const Environment& environment, uint32_t cell, Vec2 u) const {
  const Block& b = cells_[cell].block;
  const float right = static_cast<float>(std::min(b.x + (1 << b.level), width_)),
              low = static_cast<float>(std::min(b.y + (1 << b.level), height_));
  const double z_top = std::cos(static_cast<double>(pi) * b.y / height_),
               z_low = std::cos(static_cast<double>(pi) * static_cast<double>(low) / height_);
  // Near the poles 1 − cos θ loses its digits in float.
  const double z = std::clamp(z_top + (z_low - z_top) * static_cast<double>(u.y), -1.0, 1.0);
  const float v = static_cast<float>(std::acos(z) / static_cast<double>(pi));
  const float across = static_cast<float>(b.x) + (right - static_cast<float>(b.x)) * u.x;
  // Rounding may carry a draw over the block's edge, where the look-up would find another texel.
  const float top_edge = static_cast<float>(b.y) / static_cast<float>(height_);
  const float safe_v =
      std::clamp(v, std::nextafter(top_edge, 2.0f), std::nextafter(low / static_cast<float>(height_), 0.0f));
  return environment_direction(environment, {across / static_cast<float>(width_), safe_v});
}

/// A few thousand, so that most look-ups read an entry and a node or two.
void EnvironmentCells::make_entries() {
  constexpr int most_columns = 64;
  while (width_ >> entry_level_ > most_columns || height_ >> entry_level_ > most_columns) ++entry_level_;
  const auto blocks = [&](int size) { return ((size - 1) >> entry_level_) + 1; };
  entry_columns_ = blocks(width_);
  entries_.resize(static_cast<size_t>(entry_columns_) * static_cast<size_t>(blocks(height_)));
  for (size_t i = 0; i < entries_.size(); ++i) {
    const glm::ivec2 texel(static_cast<int>(i) % entry_columns_ << entry_level_,
                           static_cast<int>(i) / entry_columns_ << entry_level_);
    uint32_t node = 0;
    while (nodes_[node].children >= 0 && nodes_[node].block.level > entry_level_)
      node = child_at(nodes_[node], texel);
    entries_[i] = node;
  }
}

uint32_t EnvironmentCells::cell_of(glm::ivec2 texel) const {
  uint32_t node =
      entries_[static_cast<size_t>(texel.y >> entry_level_) * static_cast<size_t>(entry_columns_) +
               static_cast<size_t>(texel.x >> entry_level_)];
  while (nodes_[node].children >= 0) node = child_at(nodes_[node], texel);
  return nodes_[node].cell;
}

}  // namespace halflight
