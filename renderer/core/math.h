// Vectors, boxes and bases used everywhere. Lengths are in the scene's own unit; nothing assumes metres.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <limits>

namespace halflight {

using Vec2 = glm::vec2;
using Vec3 = glm::vec3;
using Vec4 = glm::vec4;
using Vec3d = glm::dvec3;
using UVec3 = glm::uvec3;
using Mat3 = glm::mat3;
using Mat4 = glm::mat4;

inline constexpr float pi = 3.14159265358979323846f;
inline constexpr float infinity = std::numeric_limits<float>::infinity();

template <class Number>
constexpr Number square(Number x) {
  return x * x;
}
inline float max_component(Vec3 v) { return std::max(v.x, std::max(v.y, v.z)); }
inline bool is_finite(Vec3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

/// Relative luminance of linear Rec. 709 primaries (ITU-R BT.709).
inline float luminance(Vec3 rgb) { return 0.2126f * rgb.x + 0.7152f * rgb.y + 0.0722f * rgb.z; }

/// Axis-aligned box; empty until extended.
struct Aabb {
  Vec3 low{infinity};
  Vec3 high{-infinity};

  void extend(Vec3 p) { low = glm::min(low, p), high = glm::max(high, p); }
  void extend(const Aabb& b) { low = glm::min(low, b.low), high = glm::max(high, b.high); }
  bool empty() const { return !(low.x <= high.x && low.y <= high.y && low.z <= high.z); }
  Vec3 centre() const { return 0.5f * low + 0.5f * high; }
  Vec3 extent() const { return empty() ? Vec3(0) : high - low; }
  float diagonal() const { return glm::length(extent()); }
};

/// Right-handed orthonormal basis; `normal` is local +z.
struct Basis {
  Vec3 tangent, bitangent, normal;

  Vec3 to_local(Vec3 v) const { return {glm::dot(v, tangent), glm::dot(v, bitangent), glm::dot(v, normal)}; }
  Vec3 to_world(Vec3 v) const { return v.x * tangent + v.y * bitangent + v.z * normal; }
};

/// Branchless basis about a unit normal (Duff et al. 2017, "Building an Orthonormal Basis, Revisited").
inline Basis basis_around(Vec3 n) {
  const float sign = std::copysign(1.0f, n.z);
  const float a = -1.0f / (sign + n.z);
  const float b = n.x * n.y * a;
  return {{1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
}

/// Basis about unit `normal` whose tangent is `tangent` made orthogonal to it; any basis where that
/// degenerates.
inline Basis basis_along(Vec3 normal, Vec3 tangent) {
  const Vec3 t = tangent - normal * glm::dot(tangent, normal);
  const float length2 = glm::dot(t, t);
  if (!(length2 > 1e-12f * glm::dot(tangent, tangent))) return basis_around(normal);
  const Vec3 unit = t / std::sqrt(length2);
  return {unit, glm::cross(normal, unit), normal};
}

}  // namespace halflight
