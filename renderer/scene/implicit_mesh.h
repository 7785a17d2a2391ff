// Meshes of surfaces given as the zeros of a field, for the built-in scenes' sculptures.
#pragma once

#include "scene/mesh_builder.h"

namespace halflight {

/// A signed distance or a lower bound of one: negative inside, changing by at most 1 a unit of length (a
/// little more does no harm).
using Field = std::function<float(Vec3)>;

/// The surface `field` = 0 within `box` by surface nets (Gibson 1998) on cubes of side `cell`: a vertex a
/// cube that the surface passes, at the mean of its crossings with the cube's edges; normals are the field's
/// gradient. Fronts look outside; closed where the surface does not leave the box. Calls the field on several
/// threads at once.
Mesh implicit_mesh(const Field& field, const Aabb& box, float cell);

/// Moves the vertices onto the surface `field` = 0, from which `implicit_mesh` leaves them by a small part of
/// a cell, and makes their normals anew.
void settle(Mesh&, const Field& field);

/// A mesh in two: where `side` is negative and where it is not.
struct CutMesh {
  Mesh inside, outside;
};

/// Cuts a settled mesh of the surface `field` = 0 along the curve `side` = 0 on it, through the triangles:
/// new vertices lie on both, with the field's gradient as normal. What is between two crossings of one edge
/// is not seen. Leaves out triangles without area.
CutMesh cut_mesh(const Mesh&, const Field& field, const Field& side);

/// Distance to a superellipsoid about `centre`, to first order: (|x/a|^e + |z/c|^e)^(f/e) + |y/b|^f = 1 with
/// (e, f) = `exponents`, which exceed 1; (2, 2) is an ellipsoid.
float superellipsoid_distance(Vec3 p, Vec3 centre, Vec3 radii, Vec2 exponents);

/// Distance to an ellipsoid with its axes along the coordinates', to first order (exact on the surface).
inline float ellipsoid_distance(Vec3 p, Vec3 centre, Vec3 radii) {
  const Vec3 q = (p - centre) / radii;
  const float scaled = glm::length(q), slope = glm::length(q / radii);
  const float least = std::min(radii.x, std::min(radii.y, radii.z));
  return slope > 0 ? scaled * (scaled - 1) / slope : -least;
}

/// Distance to a straight rod with round ends, of radius `ra` at a and `rb` at b.
inline float rod_distance(Vec3 p, Vec3 a, Vec3 b, float ra, float rb) {
  const Vec3 axis = b - a;
  const float t = glm::clamp(glm::dot(p - a, axis) / glm::dot(axis, axis), 0.0f, 1.0f);
  return glm::length(p - a - t * axis) - glm::mix(ra, rb, t);
}

/// The lesser of two distances, rounded where they differ by less than `width`: a union with a fillet.
inline float blend_union(float a, float b, float width) {
  const float overlap = width - std::abs(a - b);
  return std::min(a, b) - (overlap > 0 ? 0.25f * overlap * overlap / width : 0.0f);
}

}  // namespace halflight
