#include "scene/ray_grid.h"

#include <numeric>
#include <utility>

#include "core/parallel.h"

namespace halflight {

namespace {

constexpr uint32_t cells_along_longest = 48;
constexpr size_t most_references = 20'000'000;  // of triangles by cells
constexpr size_t most_triangles = 4'000'000;    // of larger scenes every n-th is taken
constexpr size_t pieces = 4;                    // that triangles are visited in
constexpr uint32_t crowded = 96;                // triangles that make a cell solid

/// Cells a triangle's box meets.
struct CellRange {
  UVec3 low, high;  // inclusive
  size_t count() const {
    const UVec3 n = high - low + 1u;
    return static_cast<size_t>(n.x) * n.y * n.z;
  }
};

UVec3 clamp_cell(Vec3 p, UVec3 size) { return UVec3(glm::clamp(glm::floor(p), Vec3(0), Vec3(size) - 1.0f)); }

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
  stride_ = static_cast<uint32_t>(scene.triangles.size() / most_triangles) + 1;
  choose_size(scene);
  fill(scene);
}

std::array<Vec3, 3> RayGrid::grid_triangle(uint32_t triangle) const {
  const UVec3 t = scene_->triangles[triangle];
  return {to_grid(scene_->vertices[t.x].position), to_grid(scene_->vertices[t.y].position),
          to_grid(scene_->vertices[t.z].position)};
}

/// Calls `visit(piece, triangle)` for the triangles that are taken: pieces run in parallel, each in order,
/// and are the same for any number of threads.
template <class Visit>
void RayGrid::for_each_piece(const Scene& scene, const Visit& visit) const {
  const size_t taken = (scene.triangles.size() + stride_ - 1) / stride_;
  parallel_for(0, pieces, 1, [&](size_t first, size_t last) {
    for (size_t piece = first; piece < last; ++piece)
      for (size_t i = taken * piece / pieces; i < taken * (piece + 1) / pieces; ++i)
        visit(piece, static_cast<uint32_t>(i * stride_));
  });
}

void RayGrid::choose_size(const Scene& scene) {
  const Vec3 extent = scene.bounds.extent();
  const float longest = max_component(extent);
  for (uint32_t along = cells_along_longest;; along /= 2) {
    cell_ = longest > 0 ? longest / static_cast<float>(along) : 1;
    size_ = glm::clamp(UVec3(glm::ceil(extent / cell_)), UVec3(1), UVec3(along));
    if (along == 1) return;
    std::array<size_t, pieces> counts{};
    for_each_piece(scene, [&](size_t piece, uint32_t i) {
      counts[piece] += cell_range(grid_triangle(i), size_).count();
    });
    const size_t references = std::accumulate(counts.begin(), counts.end(), size_t{0});
    if (references <= most_references) return;
  }
}

/// Calls `visit(cell, normal)` for each cell a triangle may meet; the normal is in grid units, twice the
/// area.
template <class Visit>
void RayGrid::for_each_cell(uint32_t triangle, const Visit& visit) const {
  const std::array<Vec3, 3> p = grid_triangle(triangle);
  const CellRange range = cell_range(p, size_);
  const Vec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
  if (range.low == range.high) {
    visit(index(range.low), normal);
    return;
  }
  const float offset = glm::dot(normal, p[0]);
  UVec3 c;
  for (c.z = range.low.z; c.z <= range.high.z; ++c.z) {
    for (c.y = range.low.y; c.y <= range.high.y; ++c.y) {
      for (c.x = range.low.x; c.x <= range.high.x; ++c.x) {
        if (plane_meets_cell(normal, offset, Vec3(c) + 0.5f)) visit(index(c), normal);
      }
    }
  }
}

void RayGrid::fill(const Scene& scene) {
  const size_t cells = static_cast<size_t>(size_.x) * size_.y * size_.z;
  // Counts first, then places: both visit the same cells.
  struct Piece {
    std::vector<uint32_t> next;
    std::vector<Vec3> normal_sum;
  };
  std::array<Piece, pieces> all;
  for (Piece& piece : all) piece = {std::vector<uint32_t>(cells, 0), std::vector<Vec3>(cells, Vec3(0))};
  for_each_piece(scene, [&](size_t piece, uint32_t triangle) {
    for_each_cell(triangle, [&](size_t cell, Vec3 normal) {
      ++all[piece].next[cell];
      all[piece].normal_sum[cell] += normal;
    });
  });
  begin_.assign(cells + 1, 0);
  normal_sum_.assign(cells, Vec3(0));
  uint32_t sum = 0;
  for (size_t cell = 0; cell < cells; ++cell) {
    begin_[cell] = sum;
    for (Piece& piece : all) {
      sum += std::exchange(piece.next[cell], sum);
      normal_sum_[cell] += piece.normal_sum[cell];
    }
  }
  begin_[cells] = sum;
  triangles_.resize(sum);
  for_each_piece(scene, [&](size_t piece, uint32_t triangle) {
    for_each_cell(triangle, [&](size_t cell, Vec3) { triangles_[all[piece].next[cell]++] = triangle; });
  });
}

RayGrid::Hit RayGrid::cast_in_cell(size_t cell, Vec3 origin, Vec3 direction, float entry, float exit) const {
  Hit hit;
  const uint32_t begin = begin_[cell], end = begin_[cell + 1];
  if (end - begin > crowded) return {std::max(entry, 0.0f), glm::dot(normal_sum_[cell], direction) < 0};
  for (uint32_t i = begin; i < end; ++i) {
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
