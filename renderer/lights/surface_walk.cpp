#include "lights/surface_walk.h"

#include <algorithm>

namespace halflight {

namespace {

/// One number a distinct place, so that vertices split for their normals or uvs still meet.
std::vector<uint32_t> weld_vertices(const Scene& scene) {
  const size_t count = scene.vertices.size();
  std::vector<uint32_t> order(count), place(count);
  for (uint32_t i = 0; i < count; ++i) order[i] = i;
  const auto less = [&](uint32_t a, uint32_t b) {
    const Vec3 &p = scene.vertices[a].position, &q = scene.vertices[b].position;
    return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z < q.z;
  };
  std::sort(order.begin(), order.end(), less);
  for (size_t i = 0; i < count; ++i)
    place[order[i]] = i > 0 && !less(order[i - 1], order[i]) ? place[order[i - 1]] : order[i];
  return place;
}

struct Edge {
  uint32_t low, high, triangle;
  int opposite;
};

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

TriangleNeighbours::TriangleNeighbours(const Scene& scene)
    : across_(scene.triangles.size(), {none, none, none}) {
  const std::vector<uint32_t> place = weld_vertices(scene);
  std::vector<Edge> edges;
  edges.reserve(3 * scene.triangles.size());
  for (uint32_t i = 0; i < scene.triangles.size(); ++i) {
    for (int corner = 0; corner < 3; ++corner) {
      const uint32_t a = place[scene.triangles[i][(corner + 1) % 3]],
                     b = place[scene.triangles[i][(corner + 2) % 3]];
      if (a != b) edges.push_back({std::min(a, b), std::max(a, b), i, corner});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) {
    return a.low != b.low ? a.low < b.low : a.high != b.high ? a.high < b.high : a.triangle < b.triangle;
  });
  for (size_t i = 0; i < edges.size();) {
    size_t end = i + 1;
    while (end < edges.size() && edges[end].low == edges[i].low && edges[end].high == edges[i].high) ++end;
    if (end - i == 2) {
      across_[edges[i].triangle][static_cast<size_t>(edges[i].opposite)] = edges[i + 1].triangle;
      across_[edges[i + 1].triangle][static_cast<size_t>(edges[i + 1].opposite)] = edges[i].triangle;
    }
    i = end;
  }
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
    if (next == TriangleNeighbours::none) return stop;

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
