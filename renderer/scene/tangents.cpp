#include "scene/tangents.h"

#include <array>

#include "scene/gltf_geometry.h"

namespace halflight {

namespace {

Vec2 looked_up(const Vertex& vertex, const TextureUse& use) {
  const Vec3 p(vertex.uv[use.uv_set], 1);
  return {glm::dot(use.row_u, p), glm::dot(use.row_v, p)};
}

/// ∂p/∂u of a face as a unit vector; `sign` is glTF's w, 0 where the mapping has no area.
struct FaceTangent {
  Vec3 direction{0};
  float sign = 0;
};

FaceTangent face_tangent(const std::array<const Vertex*, 3>& corner, const TextureUse& use) {
  const Vec3d edge1 = Vec3d(corner[1]->position) - Vec3d(corner[0]->position);
  const Vec3d edge2 = Vec3d(corner[2]->position) - Vec3d(corner[0]->position);
  const glm::dvec2 uv0(looked_up(*corner[0], use));
  const glm::dvec2 d1 = glm::dvec2(looked_up(*corner[1], use)) - uv0,
                   d2 = glm::dvec2(looked_up(*corner[2], use)) - uv0;
  const double area = d1.x * d2.y - d1.y * d2.x;
  FaceTangent face;
  if (!(std::abs(area) > 0)) return face;
  face.direction = unit_or_zero((edge1 * d2.y - edge2 * d1.y) * (area > 0 ? 1.0 : -1.0));
  // v runs down in glTF, so that a mapping which is not mirrored has negative area.
  if (face.direction != Vec3(0)) face.sign = area < 0 ? 1.0f : -1.0f;
  return face;
}

/// Angle of a face at a corner, from the two edges there.
float corner_angle(Vec3d to_next, Vec3d to_previous) {
  const double lengths = glm::length(to_next) * glm::length(to_previous);
  if (!(lengths > 0)) return 0;
  return static_cast<float>(std::acos(std::clamp(glm::dot(to_next, to_previous) / lengths, -1.0, 1.0)));
}

}  // namespace

void make_tangents(std::vector<Vertex>& vertices, std::vector<UVec3>& triangles, const TextureUse& use) {
  // Where both handednesses meet at a vertex, the second one to come gets a copy.
  std::vector<FaceTangent> faces(triangles.size());
  std::vector<float> sign(vertices.size(), 0);
  std::vector<uint32_t> mirrored_copy(vertices.size(), 0);
  for (size_t t = 0; t < triangles.size(); ++t) {
    UVec3& triangle = triangles[t];
    faces[t] = face_tangent({&vertices[triangle.x], &vertices[triangle.y], &vertices[triangle.z]}, use);
    if (faces[t].sign == 0) continue;
    for (int k = 0; k < 3; ++k) {
      const uint32_t v = triangle[k];
      if (sign[v] == 0) sign[v] = faces[t].sign;
      if (sign[v] == faces[t].sign) continue;
      if (mirrored_copy[v] == 0) {
        mirrored_copy[v] = static_cast<uint32_t>(vertices.size());
        vertices.push_back(Vertex(vertices[v]));
        sign.push_back(faces[t].sign);
        mirrored_copy.push_back(0);
      }
      triangle[k] = mirrored_copy[v];
    }
  }

  std::vector<Vec3> sum(vertices.size(), Vec3(0));
  for (size_t t = 0; t < triangles.size(); ++t) {
    if (faces[t].sign == 0) continue;
    for (int k = 0; k < 3; ++k) {
      const uint32_t v = triangles[t][k];
      const Vec3d p(vertices[v].position);
      const float angle = corner_angle(Vec3d(vertices[triangles[t][(k + 1) % 3]].position) - p,
                                       Vec3d(vertices[triangles[t][(k + 2) % 3]].position) - p);
      const Vec3d n(vertices[v].normal), d(faces[t].direction);
      sum[v] += angle * unit_or_zero(d - n * glm::dot(n, d));
    }
  }
  for (size_t v = 0; v < vertices.size(); ++v) {
    const Vec3 tangent = unit_or_zero(Vec3d(sum[v]));
    vertices[v].tangent = tangent == Vec3(0) ? Vec4(0) : Vec4(tangent, sign[v]);
  }
}

}  // namespace halflight
