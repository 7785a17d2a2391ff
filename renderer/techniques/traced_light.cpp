#include "techniques/traced_light.h"

namespace halflight {

LightSources::LightSources(const Scene& lit_scene, const LightKinds& kinds)
    : scene(lit_scene),
      environment(lit_scene.environment, kinds.environment || kinds.surfaces),
      emitters(lit_scene, kinds.emitters || kinds.surfaces),
      punctual(lit_scene, kinds.punctual || kinds.surfaces) {
  if (!kinds.surfaces) return;
  surfaces = SurfaceStrata(lit_scene);
  if (surfaces.area() > 0) surface_density = static_cast<float>(1 / surfaces.area());
}

MetLight met_environment(const LightSources& lights, Vec3 wi) {
  const EnvironmentSampler::Met met = lights.environment.met(wi);
  return {met.radiance, met.pdf};
}

MetLight met_emission(const LightSources& lights, const RayHit& hit, Vec3 wi) {
  const float density = lights.emitters.density(hit.point.triangle);
  if (!(density > 0)) return {Vec3(0), 0};
  const Vec3 cross = triangle_cross(lights.scene, hit.point.triangle);
  const float cos_light = -glm::dot(cross, wi) / std::max(glm::length(cross), 1e-37f);
  return {surface_emission(lights.scene, hit.point, cos_light > 0 ? 1 : -1),
          area_to_solid_angle(density, hit.distance, std::abs(cos_light))};
}

std::optional<BouncePlace> bounce_place(const Scene& scene, SurfacePoint surface, Vec3 wi) {
  const Vec3 cross = triangle_cross(scene, surface.triangle);
  const float length = glm::length(cross);
  if (!(length > 0)) return std::nullopt;
  Vec3 normal = cross / length;
  const float facing = -glm::dot(normal, wi);
  if (facing < 0) normal = -normal;
  return BouncePlace{surface, surface_position(scene, surface), normal, std::abs(facing), facing >= 0};
}

Vec3 bounce_reflection(const Scene& scene, const BouncePlace& place) {
  return bounce_albedo(surface_brdf(scene, place.surface)) * (1 / pi);
}

}  // namespace halflight
