#include <cmath>

#include "core/parallel.h"
#include "core/random.h"
#include "lights/virtual_light.h"
#include "trace/counted_loop.h"
#include "trace/near_emitters.h"
#include "trace/ray_gbuffer.h"

namespace halflight {

namespace {

/// Shadow rays of a few points with the irradiance each carries and the slot it goes to.
struct PendingRays {
  std::vector<ShadowRay> rays;
  std::vector<Vec3> irradiance;
  std::vector<uint32_t> slot;

  /// Light along `wi` that lands on whichever side of the point faces it.
  void add(const Scene& scene, const BouncePoint& point, uint32_t index, Vec3 wi, float distance,
           Vec3 per_cosine) {
    const float cos_theta = glm::dot(point.normal, wi);
    const Vec3 value = per_cosine * std::abs(cos_theta);
    if (!(max_component(value) > 0)) return;
    rays.push_back(shadow_ray(scene, point.position, point.normal, wi, distance));
    irradiance.push_back(value);
    slot.push_back(2 * index + (cos_theta < 0 ? 1 : 0));
  }
};

}  // namespace

int lighting_samples(int samples, size_t points) {
  constexpr size_t fully_lit = 32768;
  if (points <= fully_lit) return samples;
  const double share = static_cast<double>(fully_lit) / static_cast<double>(points);
  return std::min(samples, std::max(1, static_cast<int>(std::lround(samples * share))));
}

std::vector<Vec3> irradiance_by_rays(const RayScene& rays, const std::vector<BouncePoint>& points,
                                     const PointLighting& lighting, RayCounters& counters) {
  const Scene& scene = rays.scene();
  return irradiance_by_rays(rays, EnvironmentSampler(scene.environment, lighting.environment),
                            EmitterSampler(scene, lighting.emitters), points, lighting, counters);
}

std::vector<Vec3> irradiance_by_rays(const RayScene& rays, const EnvironmentSampler& environment,
                                     const EmitterSampler& emitters, const std::vector<BouncePoint>& points,
                                     const PointLighting& lighting, RayCounters& counters) {
  const Scene& scene = rays.scene();
  std::vector<Vec3> result(2 * points.size(), Vec3(0));
  const bool both = !environment.empty() && !emitters.empty();
  const int samples = std::max(lighting.samples, both ? 2 : 1);
  const int environment_samples = environment.empty() ? 0 : both ? samples / 2 : samples;
  const int emitter_samples = emitters.empty() ? 0 : samples - environment_samples;

  constexpr size_t points_a_batch = 64;
  counters +=
      counted_parallel_for(points.size(), points_a_batch, [&](size_t begin, size_t end, RayCounters& local) {
        PendingRays pending;
        std::vector<Vec2> places(static_cast<size_t>(environment_samples));
        std::vector<IncidentSample> incident(places.size());
        for (size_t i = begin; i < end; ++i) {
          const BouncePoint& point = points[i];
          const auto index = static_cast<uint32_t>(i);
          if (lighting.punctual) {
            for (const PunctualLight& light : scene.lights) {
              const LightConnection connection = connect_punctual(light, scene, point.position);
              pending.add(scene, point, index, connection.wi, connection.distance, connection.irradiance);
            }
          }
          RandomStream random(i, 0, hash_combine(lighting.seed, 0x6c69676874ull));
          // Stratified in the coordinate that chooses the emitter or the row of the map.
          for (int s = 0; s < environment_samples; ++s) {
            const float stratum =
                (static_cast<float>(s) + random.next()) / static_cast<float>(environment_samples);
            places[static_cast<size_t>(s)] = {random.next(), std::min(stratum, 0x1.fffffep-1f)};
          }
          environment.sample(places, incident);
          for (const IncidentSample& sample : incident)
            pending.add(scene, point, index, sample.wi, sample.distance,
                        sample.radiance_over_pdf / static_cast<float>(environment_samples));
          for (int s = 0; s < emitter_samples; ++s) {
            const float stratum =
                (static_cast<float>(s) + random.next()) / static_cast<float>(emitter_samples);
            const auto sample =
                emitters.sample(point.position, std::min(stratum, 0x1.fffffep-1f), random.next2());
            if (!sample) continue;
            const float draws = static_cast<float>(emitter_samples);
            const float weight = weight_beside_near_ray(emitters, draws, sample->pdf, sample->distance,
                                                        std::abs(glm::dot(point.normal, sample->wi)));
            pending.add(scene, point, index, sample->wi, sample->distance,
                        sample->radiance_over_pdf * (weight / draws));
          }
          for (int side = 0; emitter_samples > 0 && side < 2; ++side)
            result[2 * i + static_cast<size_t>(side)] +=
                near_emission(rays, emitters, point.position, side == 0 ? point.normal : -point.normal,
                              static_cast<float>(emitter_samples), random, lighting.alpha_seed, local);
        }
        rays.occluded(pending.rays, lighting.alpha_seed, local);
        for (size_t r = 0; r < pending.rays.size(); ++r)
          if (!pending.rays[r].blocked()) result[pending.slot[r]] += pending.irradiance[r];
      });
  return result;
}

}  // namespace halflight
