// Light that rays find, for techniques that follow them into the scene instead of summing over S: what a ray
// meets (emission, the environment, light that a surface returns), and the density with which light samples
// would have drawn the same.
#pragma once

#include "lights/surface_strata.h"
#include "techniques/technique.h"
#include "trace/near_emitters.h"

namespace halflight {

/// What light is drawn from. Made once for a scene and read by all threads; refers to the scene.
struct LightSources {
  const Scene& scene;
  EnvironmentSampler environment;
  EmitterSampler emitters;
  PunctualSampler punctual;
  SurfaceStrata surfaces;     ///< empty unless one bounce is asked for
  float surface_density = 0;  ///< per area, of a point of `surfaces`

  /// With `kinds.surfaces` all lights are needed, for they light the surfaces.
  LightSources(const Scene&, const LightKinds& kinds);
};

/// Radiance that comes along a ray straight from a light, and the density per solid angle with which that
/// kind's light samples draw the ray.
struct MetLight {
  Vec3 radiance;
  float pdf;
};

/// A ray that left the scene.
MetLight met_environment(const LightSources&, Vec3 wi);
/// The emission of what a ray met.
MetLight met_emission(const LightSources&, const RayHit&, Vec3 wi);

/// A surface point that returns one-bounce light to whoever sees it.
struct BouncePlace {
  SurfacePoint surface;
  Vec3 position;
  Vec3 normal;      ///< unit, geometric, on the side that is seen
  float cos_light;  ///< cosine towards the viewer
  bool front;       ///< the side that is seen is the winding's

  /// Density per solid angle at which points drawn evenly by area lie there, seen from `distance`.
  float pdf(const LightSources& lights, float distance) const {
    return area_to_solid_angle(lights.surface_density, distance, cos_light);
  }
};

/// The point as a ray of direction `wi` sees it. Nothing where the triangle has no area.
std::optional<BouncePlace> bounce_place(const Scene&, SurfacePoint, Vec3 wi);

/// Albedo / π there: what turns irradiance into the radiance that is returned. Coverage is not in it.
Vec3 bounce_reflection(const Scene&, const BouncePlace&);

/// Estimates the irradiance at a bounce place afresh: one draw of each kind of light. Calls `add(ray,
/// irradiance)` for each; the sum over the rays that arrive, and `near_emission` beside one draw, has the
/// irradiance as its mean.
inline constexpr size_t most_irradiance_rays = 3;

template <class Add>
void draw_irradiance(const LightSources& lights, const BouncePlace& place, RandomStream& random, Add&& add) {
  const RayOrigin origin(lights.scene, place.position, place.normal);
  const auto add_sample = [&](const IncidentSample& sample, bool emitter = false) {
    const float cos_theta = glm::dot(place.normal, sample.wi);
    if (!(cos_theta > 0)) return;
    const float weight =
        emitter ? weight_beside_near_ray(lights.emitters, 1, sample.pdf, sample.distance, cos_theta) : 1.0f;
    const Vec3 irradiance = sample.radiance_over_pdf * (cos_theta * weight);
    if (max_component(irradiance) > 0) add(shadow_ray(origin, sample.wi, sample.distance), irradiance);
  };
  if (!lights.environment.empty()) add_sample(lights.environment.sample(random.next2()));
  if (!lights.emitters.empty()) {
    const float choose = random.next();
    if (const auto sample = lights.emitters.sample(place.position, choose, random.next2()))
      add_sample(*sample, true);
  }
  if (!lights.punctual.empty())
    if (const auto sample = lights.punctual.sample(place.position, place.normal, random)) add_sample(*sample);
}

}  // namespace halflight
