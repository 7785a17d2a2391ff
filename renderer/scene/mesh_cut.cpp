#include <map>
#include <tuple>

#include "core/parallel.h"
#include "scene/implicit_mesh.h"

namespace halflight {

namespace {

Vec3 gradient_at(const Field& field, Vec3 p, float step) {
  Vec3 g;
  for (int a = 0; a < 3; ++a) {
    Vec3 offset(0);
    offset[a] = step;
    g[a] = (field(p + offset) - field(p - offset)) / (2 * step);
  }
  return g;
}

/// The point of the surface near `p`: Newton's steps along the gradient, which is taken once.
Vec3 surface_point(const Field& field, Vec3 p, float step) {
  float value = field(p);
  Vec3 g;
  for (int a = 0; a < 3; ++a) {
    Vec3 beside = p;
    beside[a] += step;
    g[a] = (field(beside) - value) / step;
  }
  const float slope = glm::dot(g, g);
  for (int i = 0; i < 3 && slope > 0; ++i) {
    const Vec3 next = p - g * (value / slope);
    const float there = field(next);
    if (!(std::abs(there) < std::abs(value))) break;
    p = next, value = there;
  }
  return p;
}

bool comes_before(Vec3 a, Vec3 b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); }

/// The vertex between two where `side` passes through 0, moved onto the surface; the same for both orders of
/// the two.
Vertex crossing(const Field& field, const Field& side, const Vertex& one, const Vertex& other) {
  const bool in_order = comes_before(one.position, other.position);
  const Vertex &a = in_order ? one : other, &b = in_order ? other : one;
  const float step = 1e-2f * glm::length(b.position - a.position);
  const auto on_surface = [&](float t) {
    return surface_point(field, glm::mix(a.position, b.position, t), step);
  };
  // False position; the end that stays counts half from then on (the Illinois rule).
  float low = 0, high = 1, at_low = side(a.position), at_high = side(b.position), t = 0.5f;
  const float near_enough = 1e-5f * glm::length(b.position - a.position);
  int kept = 0;
  for (int i = 0; i < 12; ++i) {
    t = glm::mix(low, high, glm::clamp(at_low / (at_low - at_high), 0.02f, 0.98f));
    const float here = side(on_surface(t));
    if (std::abs(here) < near_enough) break;
    const bool is_low = (here < 0) == (at_low < 0);
    (is_low ? low : high) = t;
    (is_low ? at_low : at_high) = here;
    if (kept == (is_low ? 1 : -1)) (is_low ? at_high : at_low) *= 0.5f;
    kept = is_low ? 1 : -1;
  }
  Vertex v = a;
  v.position = on_surface(t);
  v.uv[0] = glm::mix(a.uv[0], b.uv[0], t);
  const Vec3 g = gradient_at(field, v.position, step);
  v.normal = glm::dot(g, g) > 0 ? glm::normalize(g) : glm::normalize(a.normal + b.normal);
  return v;
}

/// One half in the making: which of the joint vertices it has, and where.
struct Half {
  Mesh mesh;
  std::vector<uint32_t> place;

  uint32_t vertex(const std::vector<Vertex>& all, uint32_t v) {
    if (place.size() < all.size()) place.resize(all.size(), ~0u);
    if (place[v] == ~0u) {
      place[v] = static_cast<uint32_t>(mesh.vertices.size());
      mesh.vertices.push_back(all[v]);
    }
    return place[v];
  }

  void add(const std::vector<Vertex>& all, uint32_t a, uint32_t b, uint32_t c) {
    // Thin triangles stay: without them the next cut would part their neighbours.
    const Vec3 p = all[a].position;
    if (!(glm::length(glm::cross(all[b].position - p, all[c].position - p)) > 0)) return;
    mesh.triangles.push_back({vertex(all, a), vertex(all, b), vertex(all, c)});
  }
};

}  // namespace

void settle(Mesh& mesh, const Field& field) {
  Aabb bounds;
  for (const Vertex& v : mesh.vertices) bounds.extend(v.position);
  const float step = 2e-4f * bounds.diagonal();
  parallel_for(0, mesh.vertices.size(), 256, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      Vertex& v = mesh.vertices[i];
      v.position = surface_point(field, v.position, step);
      const Vec3 g = gradient_at(field, v.position, step);
      if (glm::dot(g, v.normal) > 0) v.normal = glm::normalize(g);
    }
  });
}

CutMesh cut_mesh(const Mesh& mesh, const Field& field, const Field& side) {
  std::vector<Vertex> all = mesh.vertices;
  std::vector<char> inside;
  for (const Vertex& v : all) inside.push_back(side(v.position) < 0);
  std::map<std::pair<uint32_t, uint32_t>, uint32_t> crossings;
  const auto between = [&](uint32_t a, uint32_t b) {
    const auto [at, is_new] = crossings.emplace(std::minmax(a, b), static_cast<uint32_t>(all.size()));
    if (is_new) all.push_back(crossing(field, side, all[at->first.first], all[at->first.second]));
    return at->second;
  };
  Half halves[2];
  for (const UVec3 t : mesh.triangles) {
    const int count = inside[t.x] + inside[t.y] + inside[t.z];
    if (count == 0 || count == 3) {
      halves[count == 0].add(all, t.x, t.y, t.z);
      continue;
    }
    // The corner that is alone on its side comes first.
    const char alone = count == 1;
    const int k = inside[t.x] == alone ? 0 : inside[t.y] == alone ? 1 : 2;
    const uint32_t a = t[k], b = t[(k + 1) % 3], c = t[(k + 2) % 3], ab = between(a, b), ac = between(a, c);
    halves[count != 1].add(all, a, ab, ac);
    halves[count == 1].add(all, ab, b, c);
    halves[count == 1].add(all, ab, c, ac);
  }
  return {std::move(halves[0].mesh), std::move(halves[1].mesh)};
}

float superellipsoid_distance(Vec3 p, Vec3 centre, Vec3 radii, Vec2 exponents) {
  const float e = exponents.x, f = exponents.y;
  const Vec3 q = glm::abs(p - centre) / radii;
  // The plan's norm of (x, z), then that of it and y; both are homogeneous, so that q(1 − 1/q)/|∇q| is a
  // distance.
  const Vec2 plan_powers(std::pow(q.x, e - 1), std::pow(q.z, e - 1));
  const float plan = std::pow(plan_powers.x * q.x + plan_powers.y * q.z, 1 / e);
  const float scaled = std::pow(std::pow(plan, f) + std::pow(q.y, f), 1 / f);
  if (!(scaled > 0.05f)) return -0.9f * std::min({radii.x, radii.y, radii.z});
  const float plan_slope = std::pow(plan / scaled, f - 1);
  Vec3 slope(0, std::pow(q.y / scaled, f - 1), 0);
  if (plan > 0) {
    slope.x = plan_slope * plan_powers.x / std::pow(plan, e - 1);
    slope.z = plan_slope * plan_powers.y / std::pow(plan, e - 1);
  }
  return (scaled - 1) / glm::length(slope / radii);
}

}  // namespace halflight
