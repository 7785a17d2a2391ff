#include "lights/surface_walk.h"

#include <algorithm>
#include <bit>

#include "core/random.h"
#include "lights/point_grid.h"

namespace halflight {

namespace {

/// One number a distinct place, so that vertices split for their normals or uvs still meet.
std::vector<uint32_t> weld_vertices(const Scene& scene) {
  constexpr uint32_t free_slot = 0xffffffffu;
  const size_t slots = std::bit_ceil(2 * scene.vertices.size() + 1);
  std::vector<uint32_t> table(slots, free_slot), place(scene.vertices.size());
  for (uint32_t i = 0; i < scene.vertices.size(); ++i) {
    const Vec3 p = scene.vertices[i].position + 0.0f;  // −0 and 0 are one place
    const uint64_t hash =
        hash_combine(std::bit_cast<uint32_t>(p.x) | uint64_t{std::bit_cast<uint32_t>(p.y)} << 32,
                     std::bit_cast<uint32_t>(p.z));
    size_t slot = hash & (slots - 1);
    while (table[slot] != free_slot && scene.vertices[table[slot]].position != p)
      slot = (slot + 1) & (slots - 1);
    if (table[slot] == free_slot) table[slot] = i;
    place[i] = table[slot];
  }
  return place;
}

/// An edge of a triangle, kept with the lower of its two vertices.
struct Edge {
  uint32_t high, triangle;
  int opposite;
};

/// The edges of all triangles, those of vertex v at [first[v], first[v + 1]).
struct EdgeLists {
  std::vector<uint32_t> first;
  std::vector<Edge> edges;
};

EdgeLists edges_by_vertex(const Scene& scene, std::span<const uint32_t> triangles) {
  const std::vector<uint32_t> place = weld_vertices(scene);
  EdgeLists lists;
  lists.first.assign(scene.vertices.size() + 1, 0);
  const auto for_edges = [&](auto&& visit) {
    for (const uint32_t i : triangles) {
      for (int corner = 0; corner < 3; ++corner) {
        const uint32_t a = place[scene.triangles[i][(corner + 1) % 3]],
                       b = place[scene.triangles[i][(corner + 2) % 3]];
        if (a != b) visit(std::min(a, b), Edge{std::max(a, b), i, corner});
      }
    }
  };
  for_edges([&](uint32_t low, const Edge&) { ++lists.first[low + 1]; });
  for (size_t i = 0; i + 1 < lists.first.size(); ++i) lists.first[i + 1] += lists.first[i];
  lists.edges.resize(lists.first.back());
  std::vector<uint32_t> next(lists.first.begin(), lists.first.end() - 1);
  for_edges([&](uint32_t low, const Edge& edge) { lists.edges[next[low]++] = edge; });
  return lists;
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
    : across_(scene.triangles.size(), {none, none, none}), folds_(scene.triangles.size(), 0b111) {
  EdgeLists lists = edges_by_vertex(scene, triangles);
  for (size_t vertex = 0; vertex + 1 < lists.first.size(); ++vertex) {
    const auto begin = lists.edges.begin() + lists.first[vertex],
               end = lists.edges.begin() + lists.first[vertex + 1];
    std::sort(begin, end, [](const Edge& a, const Edge& b) {
      return a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
    });
    for (auto edge = begin; edge != end;) {
      const auto other_end = std::find_if(edge, end, [&](const Edge& e) { return e.high != edge->high; });
      if (other_end - edge == 2)
        join(scene, edge[0].triangle, edge[0].opposite, edge[1].triangle, edge[1].opposite);
      edge = other_end;
    }
  }
}

void TriangleNeighbours::join(const Scene& scene, uint32_t a, int edge_a, uint32_t b, int edge_b) {
  across_[a][static_cast<size_t>(edge_a)] = b;
  across_[b][static_cast<size_t>(edge_b)] = a;
  const Vec3 normal_a = triangle_cross(scene, a), normal_b = triangle_cross(scene, b);
  const float lengths = glm::length(normal_a) * glm::length(normal_b);
  if (glm::dot(normal_a, normal_b) < facing_together * lengths) return;
  folds_[a] &= static_cast<uint8_t>(~(1u << edge_a));
  folds_[b] &= static_cast<uint8_t>(~(1u << edge_b));
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
