#include "lights/surface_walk.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <utility>

#include "core/parallel.h"
#include "core/random.h"
#include "lights/point_grid.h"

namespace halflight {

namespace {

constexpr size_t grain = 8192;

/// One number a distinct place, so that vertices split for their normals or uvs still meet.
std::vector<uint32_t> weld_vertices(const Scene& scene) {
  constexpr uint32_t free_slot = 0xffffffffu;
  const size_t slots = std::bit_ceil(2 * scene.vertices.size() + 1);
  std::vector<uint32_t> table(slots, free_slot), place(scene.vertices.size());
  const auto same_place = [&](uint32_t a, uint32_t b) {
    return scene.vertices[a].position == scene.vertices[b].position;
  };
  parallel_for(0, scene.vertices.size(), grain, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const auto vertex = static_cast<uint32_t>(i);
      const Vec3 p = scene.vertices[i].position + 0.0f;  // −0 and 0 are one place
      const uint64_t hash =
          hash_combine(std::bit_cast<uint32_t>(p.x) | uint64_t{std::bit_cast<uint32_t>(p.y)} << 32,
                       std::bit_cast<uint32_t>(p.z));
      for (size_t slot = hash & (slots - 1);; slot = (slot + 1) & (slots - 1)) {
        uint32_t there = free_slot;
        if (std::atomic_ref(table[slot]).compare_exchange_strong(there, vertex, std::memory_order_relaxed))
          there = vertex;
        place[i] = there;
        if (there == vertex || same_place(there, vertex)) break;
      }
    }
  });
  return place;
}

std::array<Vec3, 3> corners(const Scene& scene, uint32_t triangle) {
  const UVec3 t = scene.triangles[triangle];
  return {scene.vertices[t.x].position, scene.vertices[t.y].position, scene.vertices[t.z].position};
}

/// Barycentric weights of all three corners of the projection of `p` onto the triangle's plane.
Vec3 barycentric(const std::array<Vec3, 3>& c, Vec3 p) {
  const Vec3 e1 = c[1] - c[0], e2 = c[2] - c[0], d = p - c[0];
  const float a = glm::dot(e1, e1), b = glm::dot(e1, e2), e = glm::dot(e2, e2);
  const float u = glm::dot(d, e1), v = glm::dot(d, e2), determinant = a * e - b * b;
  if (!(determinant > 0)) return {1, 0, 0};
  const float w1 = (e * u - b * v) / determinant, w2 = (a * v - b * u) / determinant;
  return {1 - w1 - w2, w1, w2};
}

SurfacePoint clamped(uint32_t triangle, Vec3 weights) {
  weights = glm::max(weights, Vec3(0));
  const float sum = weights.x + weights.y + weights.z;
  return {triangle, Vec2(weights.y, weights.z) / sum};
}

/// Turns what is left of the way about the shared edge into the neighbour's plane.
Vec3 unfold(Vec3 way, Vec3 edge, Vec3 from_corner, Vec3 into_corner, Vec3 on_edge) {
  const Vec3 along = glm::normalize(edge);
  const auto across = [&](Vec3 corner) {
    const Vec3 d = corner - on_edge;
    return d - along * glm::dot(d, along);
  };
  const Vec3 outward = -across(from_corner), inward = across(into_corner);
  const float outward_length = glm::length(outward), inward_length = glm::length(inward);
  if (!(outward_length > 0) || !(inward_length > 0)) return Vec3(0);
  return along * glm::dot(way, along) + inward * (glm::dot(way, outward) / (outward_length * inward_length));
}

}  // namespace

TriangleNeighbours::TriangleNeighbours(const Scene& scene, std::span<const uint32_t> triangles)
    : scene_(&scene), place_(weld_vertices(scene)), first_(scene.vertices.size() + 1, 0) {
  const auto for_corners = [&](const auto& visit) {
    parallel_for(0, triangles.size(), grain, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i)
        for (int corner = 0; corner < 3; ++corner)
          visit(place_[scene.triangles[triangles[i]][corner]], triangles[i]);
    });
  };
  const auto count_up = [](uint32_t& count) {
    return std::atomic_ref(count).fetch_add(1, std::memory_order_relaxed);
  };
  for_corners([&](uint32_t place, uint32_t) { count_up(first_[place]); });
  uint32_t sum = 0;
  for (uint32_t& first : first_) sum += std::exchange(first, sum);
  triangles_.resize(sum);
  for_corners([&](uint32_t place, uint32_t triangle) { triangles_[count_up(first_[place])] = triangle; });
  // Each has been counted up to the next one's beginning.
  for (size_t i = first_.size(); i-- > 1;) first_[i] = first_[i - 1];
  if (!first_.empty()) first_[0] = 0;
}

uint32_t TriangleNeighbours::across(uint32_t triangle, int edge) const {
  const UVec3 own = scene_->triangles[triangle];
  uint32_t a = place_[own[(edge + 1) % 3]], b = place_[own[(edge + 2) % 3]];
  if (a == b) return none;
  if (first_[b + 1] - first_[b] < first_[a + 1] - first_[a]) std::swap(a, b);
  uint32_t found = none;
  for (uint32_t i = first_[a]; i < first_[a + 1]; ++i) {
    const uint32_t other = triangles_[i];
    if (other == triangle) continue;
    const UVec3 t = scene_->triangles[other];
    if (place_[t.x] != b && place_[t.y] != b && place_[t.z] != b) continue;
    if (found != none && found != other) return none;
    found = other;
  }
  return found;
}

bool TriangleNeighbours::folds(uint32_t triangle, int edge) const {
  const uint32_t other = across(triangle, edge);
  if (other == none) return true;
  const Vec3 normal = triangle_cross(*scene_, triangle), normal_other = triangle_cross(*scene_, other);
  return glm::dot(normal, normal_other) < facing_together * glm::length(normal) * glm::length(normal_other);
}

SurfacePoint walk_surface(const Scene& scene, const TriangleNeighbours& neighbours, SurfacePoint start,
                          Vec3 way) {
  constexpr int most_crossings = 32;
  SurfacePoint at = start;
  for (int crossing = 0; crossing < most_crossings; ++crossing) {
    const std::array<Vec3, 3> c = corners(scene, at.triangle);
    const Vec3 from(1 - at.barycentric.x - at.barycentric.y, at.barycentric.x, at.barycentric.y);
    const Vec3 position = from.x * c[0] + from.y * c[1] + from.z * c[2];
    const Vec3 to = barycentric(c, position + way);
    if (to.x >= 0 && to.y >= 0 && to.z >= 0) return clamped(at.triangle, to);

    // The edge that is crossed first: its corner's weight reaches 0 soonest.
    int edge = 0;
    float share = 2;
    for (int i = 0; i < 3; ++i) {
      if (to[i] >= 0) continue;
      const float t = std::max(from[i], 0.0f) / std::max(from[i] - to[i], 1e-30f);
      if (t < share) share = t, edge = i;
    }
    share = std::clamp(share, 0.0f, 1.0f);
    Vec3 border = glm::mix(from, to, share);
    border[edge] = 0;
    const SurfacePoint stop = clamped(at.triangle, border);
    const uint32_t next = neighbours.across(at.triangle, edge);
    if (next == TriangleNeighbours::none) return clamped(at.triangle, glm::mix(from, border, 0.9f));

    const Vec3 on_edge = surface_position(scene, stop);
    const std::array<Vec3, 3> n = corners(scene, next);
    int into = 0;
    while (into < 3 && neighbours.across(next, into) != at.triangle) ++into;
    if (into == 3) return stop;
    way = unfold(way * (1 - share), c[(edge + 2) % 3] - c[(edge + 1) % 3], c[edge], n[into], on_edge);
    at = clamped(next, barycentric(n, on_edge));
  }
  return at;
}

}  // namespace halflight
