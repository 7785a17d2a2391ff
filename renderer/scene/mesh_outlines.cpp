// The shapes of mesh_builder.h that come from outlines: prisms over polygons and frames.
#include "core/errors.h"
#include "scene/mesh_builder.h"

namespace halflight {

namespace {

float cross2(Vec2 a, Vec2 b) { return a.x * b.y - a.y * b.x; }

bool in_triangle(Vec2 p, Vec2 a, Vec2 b, Vec2 c) {
  return cross2(b - a, p - a) >= 0 && cross2(c - b, p - b) >= 0 && cross2(a - c, p - c) >= 0;
}

/// Triangles over a simple counter-clockwise polygon by cutting ears.
std::vector<UVec3> triangulate(std::span<const Vec2> outline) {
  std::vector<uint32_t> left(outline.size());
  for (uint32_t i = 0; i < left.size(); ++i) left[i] = i;
  std::vector<UVec3> triangles;
  const auto is_ear = [&](size_t i) {
    const uint32_t a = left[(i + left.size() - 1) % left.size()], b = left[i],
                   c = left[(i + 1) % left.size()];
    if (cross2(outline[b] - outline[a], outline[c] - outline[b]) <= 0) return false;
    return std::none_of(left.begin(), left.end(), [&](uint32_t p) {
      return p != a && p != b && p != c && in_triangle(outline[p], outline[a], outline[b], outline[c]);
    });
  };
  while (left.size() >= 3) {
    size_t ear = 0;
    while (ear < left.size() && !is_ear(ear)) ++ear;
    if (ear == left.size()) break;  // only collinear points are left
    triangles.push_back(
        {left[(ear + left.size() - 1) % left.size()], left[ear], left[(ear + 1) % left.size()]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(ear));
  }
  return triangles;
}

}  // namespace

Mesh extrude_mesh(std::span<const Vec2> outline, float depth) {
  Mesh mesh;
  const auto count = static_cast<uint32_t>(outline.size());
  float along = 0;
  for (uint32_t i = 0; i < count; ++i) {
    const Vec2 a = outline[i], b = outline[(i + 1) % count];
    const float length = glm::length(b - a);
    const uint32_t first = add_vertex(mesh, {a, depth}, {along, depth});
    add_vertex(mesh, {a, 0}, {along, 0});
    add_vertex(mesh, {b, 0}, {along + length, 0});
    add_vertex(mesh, {b, depth}, {along + length, depth});
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangles.push_back({first, first + 2, first + 3});
    along += length;
  }
  const std::vector<UVec3> cap = triangulate(outline);
  for (int end = 0; end < 2; ++end) {
    const auto first = static_cast<uint32_t>(mesh.vertices.size());
    for (const Vec2 p : outline) add_vertex(mesh, {p, end == 0 ? 0 : depth}, p);
    for (const UVec3 t : cap) mesh.triangles.push_back(UVec3(first) + (end == 0 ? UVec3(t.x, t.z, t.y) : t));
  }
  smooth_normals(mesh, 0.6f);
  return mesh;
}

Mesh frame_mesh(Vec2 opening, std::span<const Vec2> profile) {
  Mesh mesh;
  const Vec2 half = 0.5f * opening;
  const Vec2 corners[4] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
  for (int side = 0; side < 4; ++side)
    for (size_t k = 0; k + 1 < profile.size(); ++k) {
      const auto point = [&](Vec2 corner, Vec2 p) { return Vec3(corner * (half + Vec2(p.x)), p.y); };
      const Vec2 from = corners[side], to = corners[(side + 1) % 4];
      const float length = glm::length((to - from) * half);
      const uint32_t first = add_vertex(mesh, point(from, profile[k]), {0, profile[k].x});
      add_vertex(mesh, point(from, profile[k + 1]), {0, profile[k + 1].x});
      add_vertex(mesh, point(to, profile[k + 1]), {length, profile[k + 1].x});
      add_vertex(mesh, point(to, profile[k]), {length, profile[k].x});
      mesh.triangles.push_back({first, first + 1, first + 2});
      mesh.triangles.push_back({first, first + 2, first + 3});
    }
  smooth_normals(mesh, 0.6f);
  return mesh;
}

}  // namespace halflight
