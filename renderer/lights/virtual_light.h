// S: every kind of light as point lights, and what one of them does to a point.
#pragma once

#include <cstdint>
#include <vector>

#include "core/math.h"
#include "scene/scene.h"

namespace halflight {

enum class LightKind : uint32_t { environment, emitter, surface, punctual };
inline constexpr int light_kind_count = 4;

/// One member of S; 48 bytes. In Wang & Åkerlund's notation: x_i, A_i (or Ω_i), n_i, L_i.
struct VirtualLight {
  Vec3 position;  ///< at infinity: unit direction towards the light
  float measure;  ///< A_i of a surface or emitter point, Ω_i at infinity, 1 for punctual lights
  Vec3 normal;    ///< unit; emitting side. Punctual: the way the light travels
  LightKind kind;
  Vec3 radiance;    ///< L_i; punctual: intensity (cd) or, directional, E⊥ (lux)
  uint32_t source;  ///< surface: 2·point + side; emitter: triangle; environment: texel or cell; punctual:
                    ///< Scene::lights index

  bool at_infinity() const { return kind == LightKind::environment; }
};

/// Φ_i: luminance of L_i times its measure.
inline float light_power(const VirtualLight& light) { return luminance(light.radiance) * light.measure; }

/// Whether the geometry term is the bounded one of the discrete sum or the exact one of the integral.
enum class GeometryTerm { bounded, exact };

/// Light from one member of S at x before visibility: f · cos θ · irradiance is its contribution.
struct LightConnection {
  Vec3 wi;          ///< unit, towards the light
  float distance;   ///< infinity for distant lights
  Vec3 irradiance;  ///< L_i · Ω_i(x), per unit of cos θ at x; 0 where the light faces away
};

/// Solid angle under which a patch of `area` with cosine `cos_light` is seen from distance² `r2`. Bounded
/// form: A c/(r² + A c/2π), smooth, at most a hemisphere (ESTIMATORS.md, "Analytic product over the cut").
inline float patch_solid_angle(float area, float cos_light, float r2, GeometryTerm term) {
  const float projected = area * std::max(cos_light, 0.0f);
  if (projected <= 0) return 0;
  return projected / (r2 + (term == GeometryTerm::bounded ? projected * (0.5f / pi) : 0.0f));
}

LightConnection connect(const VirtualLight&, const Scene&, Vec3 x, GeometryTerm);

/// Intensity of a punctual light towards the unit direction `travel` (from the light), cones and picture
/// included; directional lights: their E⊥.
Vec3 punctual_intensity(const PunctualLight&, const Scene&, Vec3 travel);

/// Irradiance a punctual light gives at x per unit of cosine, and the direction to it.
LightConnection connect_punctual(const PunctualLight&, const Scene&, Vec3 x);

}  // namespace halflight
