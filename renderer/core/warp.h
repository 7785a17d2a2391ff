// Maps from the unit square to directions and triangles, each with the density it samples.
#pragma once

#include <optional>

#include "core/math.h"

namespace halflight {

/// Uniform on the unit disk (Shirley & Chiu 1997, concentric map).
inline Vec2 concentric_disk(Vec2 u) {
  const Vec2 p = 2.0f * u - 1.0f;
  if (p.x == 0 && p.y == 0) return {0, 0};
  const bool wide = std::abs(p.x) > std::abs(p.y);
  const float r = wide ? p.x : p.y;
  const float phi = wide ? pi / 4 * (p.y / p.x) : pi / 2 - pi / 4 * (p.x / p.y);
  return {r * std::cos(phi), r * std::sin(phi)};
}

/// Direction about +z with density cos θ / π per solid angle.
inline Vec3 cosine_hemisphere(Vec2 u) {
  const Vec2 d = concentric_disk(u);
  return {d.x, d.y, std::sqrt(std::max(0.0f, 1 - d.x * d.x - d.y * d.y))};
}

/// Direction with density 1/4π per solid angle.
inline Vec3 uniform_sphere(Vec2 u) {
  const float z = 1 - 2 * u.x, r = std::sqrt(std::max(0.0f, 1 - z * z)), phi = 2 * pi * u.y;
  return {r * std::cos(phi), r * std::sin(phi), z};
}

/// Direction about +z with density (n+1)/2π cosⁿ θ per solid angle (modified Phong; Křivánek eq. 6).
inline Vec3 cosine_power_lobe(Vec2 u, float exponent) {
  const float cos_theta = std::pow(1 - u.x, 1 / (exponent + 1));
  // 1 - cos² loses all digits for sharp lobes; expm1 keeps them.
  const float sin2 = -std::expm1(2 / (exponent + 1) * std::log1p(-u.x));
  const float sin_theta = std::sqrt(std::max(0.0f, sin2)), phi = 2 * pi * u.y;
  return {sin_theta * std::cos(phi), sin_theta * std::sin(phi), cos_theta};
}

/// Barycentric weights of vertices 1 and 2, uniform over the triangle's area.
inline Vec2 uniform_triangle(Vec2 u) {
  const float s = std::sqrt(u.x);
  return {s * (1 - u.y), s * u.y};
}

}  // namespace halflight
