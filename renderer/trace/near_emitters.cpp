#include "trace/near_emitters.h"

#include "core/warp.h"

namespace halflight {

Vec3 near_emission(const RayScene& rays, const EmitterSampler& emitters, Vec3 x, Vec3 normal, float draws,
                   RandomStream& random, uint32_t alpha_seed, RayCounters& counters) {
  if (!emitters.may_be_near(x)) return Vec3(0);
  const Scene& scene = rays.scene();
  const Vec3 local = cosine_hemisphere(random.next2());
  const Vec3 wi = glm::normalize(basis_around(normal).to_world(local));
  const RayOrigin origin(scene, x, normal);
  RayHit hit;
  if (!rays.intersect(origin.front, wi, 0, emitters.near_distance(), alpha_seed, hit, counters))
    return Vec3(0);
  const float density = emitters.density(hit.point.triangle);
  if (!(density > 0)) return Vec3(0);
  const Vec3 cross = triangle_cross(scene, hit.point.triangle);
  const float cos_light = -glm::dot(cross, wi) / std::max(glm::length(cross), 1e-37f);
  const Vec3 radiance = surface_emission(scene, hit.point, cos_light > 0 ? 1 : -1);
  const float pdf = area_to_solid_angle(density, hit.distance, std::abs(cos_light));
  const float by_cosine = std::max(local.z, 1e-20f) / pi;
  return radiance * (pi * by_cosine / (by_cosine + draws * pdf));
}

}  // namespace halflight
