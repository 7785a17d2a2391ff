#include "lights/triangle_cells.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/warp.h"

namespace halflight {

namespace {

/// Pieces of a triangle cut into k rows are counted along the rows of vertex 1's weight: row i has k − i
/// upright pieces and k − i − 1 inverted ones between them, and i rows hold 2ki − i² pieces.
uint32_t pieces_before_row(uint32_t k, uint32_t row) { return 2 * k * row - row * row; }

uint32_t piece_of(uint32_t k, Vec2 barycentric) {
  const float scaled_x = std::max(barycentric.x, 0.0f) * static_cast<float>(k),
              scaled_y = std::max(barycentric.y, 0.0f) * static_cast<float>(k);
  const uint32_t row = std::min(static_cast<uint32_t>(scaled_x), k - 1);
  const uint32_t column = std::min(static_cast<uint32_t>(scaled_y), k - 1 - row);
  const float x = scaled_x - static_cast<float>(row), y = scaled_y - static_cast<float>(column);
  const bool inverted = x + y > 1 && column + 1 < k - row;
  return pieces_before_row(k, row) + 2 * column + (inverted ? 1 : 0);
}

Vec2 point_in_piece(uint32_t k, uint32_t piece, Vec2 barycentric) {
  const double rest = static_cast<double>(k) * k - piece;
  uint32_t row = std::min(static_cast<uint32_t>(k - std::sqrt(std::max(rest, 0.0))), k - 1);
  while (row > 0 && pieces_before_row(k, row) > piece) --row;
  while (row + 1 < k && pieces_before_row(k, row + 1) <= piece) ++row;
  const uint32_t in_row = piece - pieces_before_row(k, row), column = in_row / 2;
  const Vec2 corner(static_cast<float>(row), static_cast<float>(column));
  const Vec2 inside = in_row % 2 == 0 ? barycentric : Vec2(1) - barycentric;
  return (corner + inside) / static_cast<float>(k);
}

}  // namespace

TriangleCells::TriangleCells(const Scene& scene, std::span<const uint32_t> triangles,
                             std::span<const double> weights, uint32_t count) {
  const double total = std::accumulate(weights.begin(), weights.end(), 0.0);
  if (!(total > 0) || count == 0) return;
  const double share = total / count;
  entry_.assign(scene.triangles.size(), none);
  std::vector<double> run;  // weights of the run in hand
  double run_weight = 0;
  for (size_t i = 0; i < triangles.size(); ++i) {
    if (!(weights[i] > 0)) continue;
    const double edge = std::round(std::sqrt(weights[i] / share));
    const auto pieces = static_cast<uint32_t>(std::clamp(edge, 1.0, 4096.0));
    if (pieces > 1 || run_weight + weights[i] > share) {
      end_run(run, run_weight);
      run.clear(), run_weight = 0;
    }
    const float area = 0.5f * glm::length(triangle_cross(scene, triangles[i]));
    const auto first_cell = static_cast<uint32_t>(cells_.size());
    entry_[triangles[i]] = static_cast<uint32_t>(entries_.size());
    if (pieces > 1) cells_.resize(cells_.size() + pieces * pieces, static_cast<uint32_t>(entries_.size()));
    entries_.push_back({triangles[i], first_cell, pieces, area / square(static_cast<float>(pieces)), 1});
    if (pieces == 1) run.push_back(weights[i]), run_weight += weights[i];
  }
  end_run(run, run_weight);
  cells_.push_back(static_cast<uint32_t>(entries_.size()));
}

void TriangleCells::end_run(std::span<const double> run, double run_weight) {
  if (run.empty()) return;
  const size_t begin = entries_.size() - run.size();
  double before = 0;
  for (size_t i = 0; i < run.size(); ++i) {
    before += run[i];
    entries_[begin + i].measure = static_cast<float>(entries_[begin + i].measure * (run_weight / run[i]));
    entries_[begin + i].run_end = i + 1 < run.size() ? static_cast<float>(before / run_weight) : 1.0f;
  }
  cells_.push_back(static_cast<uint32_t>(begin));
}

SurfacePoint TriangleCells::draw(uint32_t cell, float choose, Vec2 u) const {
  const Entry* entry = &entries_[cells_[cell]];
  const Vec2 inside = uniform_triangle(u);
  if (entry->pieces > 1)
    return {entry->triangle, point_in_piece(entry->pieces, cell - entry->first_cell, inside)};
  const Entry* end = &entries_[0] + cells_[cell + 1];
  entry = std::partition_point(entry, end - 1, [&](const Entry& e) { return e.run_end <= choose; });
  return {entry->triangle, inside};
}

uint32_t TriangleCells::cell_of(SurfacePoint point) const {
  if (entry_.empty() || entry_[point.triangle] == none) return none;
  const Entry& entry = entries_[entry_[point.triangle]];
  return entry.pieces > 1 ? entry.first_cell + piece_of(entry.pieces, point.barycentric) : entry.first_cell;
}

float TriangleCells::measure(uint32_t triangle) const {
  return entry_.empty() || entry_[triangle] == none ? 0.0f : entries_[entry_[triangle]].measure;
}

}  // namespace halflight
