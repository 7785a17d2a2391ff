#include "scene/ray_grid.h"

#include <atomic>
#include <numeric>

#include "core/parallel.h"

namespace halflight {

namespace {

constexpr uint32_t cells_along_longest = 48;
constexpr size_t most_cells = 20'000'000;     // looked at for all triangles; more make the grid coarser
constexpr size_t most_triangles = 4'000'000;  // of larger scenes every n-th is taken
constexpr uint32_t crowded = 96;              // triangles that make a cell solid

/// Cells a triangle's box meets.
struct CellRange {
  UVec3 low, high;  // inclusive
  size_t count() const {
    const UVec3 n = high - low + 1u;
    return static_cast<size_t>(n.x) * n.y * n.z;
  }
};

/// Of a point in grid units, those outside moved in.
UVec3 clamp_cell(Vec3 p, UVec3 size) { return UVec3(glm::clamp(p, Vec3(0), Vec3(size) - 1.0f)); }

CellRange cell_range(const std::array<Vec3, 3>& p, UVec3 size) {
  return {clamp_cell(glm::min(p[0], glm::min(p[1], p[2])), size),
          clamp_cell(glm::max(p[0], glm::max(p[1], p[2])), size)};
}

/// Whether the plane of a triangle passes through a unit cell, with a margin for rounding.
bool plane_meets_cell(Vec3 normal, float offset, Vec3 cell_centre) {
  return std::abs(glm::dot(normal, cell_centre) - offset) <=
         0.5f * (std::abs(normal.x) + std::abs(normal.y) + std::abs(normal.z)) * 1.001f;
}

/// Möller & Trumbore 1997; distance, or infinity.
float intersect_triangle(const std::array<Vec3, 3>& p, Vec3 origin, Vec3 direction) {
  const Vec3 e1 = p[1] - p[0], e2 = p[2] - p[0];
  const Vec3 s = glm::cross(direction, e2);
  const float determinant = glm::dot(e1, s);
  if (determinant == 0) return infinity;
  const Vec3 t = origin - p[0];
  const float u = glm::dot(t, s) / determinant;
  const Vec3 q = glm::cross(t, e1);
  const float v = glm::dot(direction, q) / determinant;
  if (!(u >= 0 && v >= 0 && u + v <= 1)) return infinity;
  const float distance = glm::dot(e2, q) / determinant;
  return distance > 0 ? distance : infinity;
}

}  // namespace

RayGrid::RayGrid(const Scene& scene) : scene_(&scene) {
  low_ = scene.bounds.empty() ? Vec3(0) : scene.bounds.low;
  const Vec3 extent = scene.bounds.extent();
  const float longest = max_component(extent);
  std::array<Piece, pieces> triangles;
  for (uint32_t along = cells_along_longest;; along /= 2) {
    cell_ = longest > 0 ? longest / static_cast<float>(along) : 1;
    cells_per_unit_ = 1 / cell_;
    size_ = glm::clamp(UVec3(glm::ceil(extent / cell_)), UVec3(1), UVec3(along));
    if (find_cells(along == 1, triangles)) break;
  }
  fill(triangles);
}

std::array<Vec3, 3> RayGrid::grid_triangle(uint32_t triangle) const {
  const UVec3 t = scene_->triangles[triangle];
  return {to_grid(scene_->vertices[t.x].position), to_grid(scene_->vertices[t.y].position),
          to_grid(scene_->vertices[t.z].position)};
}

/// Adds the cells that a triangle may meet; returns how many were looked at.
size_t RayGrid::find_cells_of(uint32_t triangle, Piece& piece) const {
  const std::array<Vec3, 3> p = grid_triangle(triangle);
  const CellRange range = cell_range(p, size_);
  const Vec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
  const auto add = [&](UVec3 c) {
    const auto cell = static_cast<uint32_t>(index(c));
    piece.references.push_back({cell, triangle});
    piece.normal_sum[cell] += normal;
  };
  if (range.low == range.high) return add(range.low), 1;
  const float offset = glm::dot(normal, p[0]);
  UVec3 c;
  for (c.z = range.low.z; c.z <= range.high.z; ++c.z)
    for (c.y = range.low.y; c.y <= range.high.y; ++c.y)
      for (c.x = range.low.x; c.x <= range.high.x; ++c.x)
        if (plane_meets_cell(normal, offset, Vec3(c) + 0.5f)) add(c);
  return range.count();
}

/// The cells of all triangles that are taken, in pieces that run in parallel and are the same for any number
/// of threads. False where that takes too much and need not be `done`.
bool RayGrid::find_cells(bool done, std::array<Piece, pieces>& triangles) const {
  const size_t all = scene_->triangles.size(), stride = all / most_triangles + 1;
  const size_t taken = (all + stride - 1) / stride;
  std::atomic<size_t> looked_at_in_all = 0;
  parallel_for(0, pieces, 1, [&](size_t first, size_t last) {
    for (size_t k = first; k < last; ++k) {
      Piece& piece = triangles[k];
      const size_t begin = taken * k / pieces, end = taken * (k + 1) / pieces;
      piece.references.clear(), piece.references.reserve(end - begin);
      piece.normal_sum.assign(cells(), Vec3(0));
      size_t looked_at = 0;
      for (size_t i = begin; i < end && (done || looked_at <= most_cells); ++i)
        looked_at += find_cells_of(static_cast<uint32_t>(i * stride), piece);
      looked_at_in_all += looked_at;
    }
  });
  return done || looked_at_in_all <= most_cells;
}

void RayGrid::fill(const std::array<Piece, pieces>& triangles) {
  std::vector<uint32_t> next(cells() + 1, 0);
  normal_sum_.assign(cells(), Vec3(0));
  for (const Piece& piece : triangles) {
    for (const Reference& reference : piece.references) ++next[reference.cell];
    for (size_t cell = 0; cell < cells(); ++cell) normal_sum_[cell] += piece.normal_sum[cell];
  }
  // A solid cell's triangles are not listed.
  kinds_.resize(cells());
  for (size_t cell = 0; cell < cells(); ++cell) {
    kinds_[cell] = next[cell] == 0        ? CellKind::empty
                   : next[cell] > crowded ? CellKind::solid
                                          : CellKind::triangles;
    if (kinds_[cell] == CellKind::solid) next[cell] = 0;
  }
  std::exclusive_scan(next.begin(), next.end(), next.begin(), 0u);
  begin_ = next;
  triangles_.resize(begin_.back());
  for (const Piece& piece : triangles)
    for (const Reference& reference : piece.references)
      if (kinds_[reference.cell] == CellKind::triangles)
        triangles_[next[reference.cell]++] = reference.triangle;
}

RayGrid::Hit RayGrid::cast_in_cell(size_t cell, Vec3 origin, Vec3 direction, float entry, float exit) const {
  Hit hit;
  if (kinds_[cell] == CellKind::solid)
    return {std::max(entry, 0.0f), glm::dot(normal_sum_[cell], direction) < 0};
  for (uint32_t i = begin_[cell]; i < begin_[cell + 1]; ++i) {
    const std::array<Vec3, 3> p = grid_triangle(triangles_[i]);
    const float distance = intersect_triangle(p, origin, direction);
    if (distance >= hit.distance || distance > exit + 1e-3f) continue;
    hit = {distance, glm::dot(glm::cross(p[1] - p[0], p[2] - p[0]), direction) < 0};
  }
  return hit;
}

RayGrid::Hit RayGrid::cast(Vec3 world_origin, Vec3 direction) const {
  const Vec3 origin = to_grid(world_origin);
  // Where the ray enters and leaves the grid; tiny components become infinite slopes of the right sign.
  const Vec3 inverse(1 / (direction.x == 0 ? 1e-20f : direction.x),
                     1 / (direction.y == 0 ? 1e-20f : direction.y),
                     1 / (direction.z == 0 ? 1e-20f : direction.z));
  const Vec3 to_low = -origin * inverse, to_high = (Vec3(size_) - origin) * inverse;
  const Vec3 nearer = glm::min(to_low, to_high), farther = glm::max(to_low, to_high);
  float t = std::max(0.0f, max_component(nearer));
  const float leave = std::min(farther.x, std::min(farther.y, farther.z));
  if (!(t <= leave)) return {};

  glm::ivec3 at(clamp_cell(origin + (t + 1e-4f) * direction, size_));
  while (true) {
    Vec3 exits;
    for (int axis = 0; axis < 3; ++axis) {
      const float wall = static_cast<float>(at[axis] + (inverse[axis] > 0 ? 1 : 0));
      exits[axis] = (wall - origin[axis]) * inverse[axis];
    }
    const int axis = exits.x < exits.y ? (exits.x < exits.z ? 0 : 2) : (exits.y < exits.z ? 1 : 2);
    const Hit hit = cast_in_cell(index(UVec3(at)), origin, direction, t, exits[axis]);
    if (hit.found()) return {hit.distance * cell_, hit.front};
    t = exits[axis];
    at[axis] += inverse[axis] > 0 ? 1 : -1;
    if (at[axis] < 0 || at[axis] >= static_cast<int>(size_[axis])) return {};
  }
}

}  // namespace halflight
