#include "trace/ray_gbuffer.h"

#include "core/parallel.h"
#include "lights/virtual_light.h"
#include "trace/counted_loop.h"

namespace halflight {

namespace {

GBufferTexel trace_pixel(const RayScene& rays, const CameraRay& ray, uint32_t alpha_seed,
                         RayCounters& counters) {
  const Scene& scene = rays.scene();
  RayHit hit;
  if (rays.intersect(ray.origin, ray.direction, 0, infinity, alpha_seed, hit, counters))
    return shade_surface(scene, hit.point, -ray.direction);
  GBufferTexel texel;
  texel.wo = -ray.direction;
  texel.emission = environment_radiance(scene.environment, ray.direction);
  return texel;
}

}  // namespace

void trace_gbuffer(const RayScene& rays, const Camera& camera, Vec2 jitter, uint32_t alpha_seed,
                   GBuffer& gbuffer, RayCounters& counters) {
  counters += counted_parallel_for(gbuffer.height, 4, [&](size_t begin, size_t end, RayCounters& local) {
    for (size_t y = begin; y < end; ++y) {
      for (int x = 0; x < gbuffer.width; ++x) {
        const Vec2 pixel = Vec2(x + 0.5f, y + 0.5f) + jitter;
        gbuffer.texels[y * gbuffer.width + x] =
            trace_pixel(rays, camera_ray(camera, pixel, gbuffer.width, gbuffer.height), alpha_seed, local);
      }
    }
  });
}

void add_punctual_by_rays(const RayScene& rays, const GBuffer& gbuffer, uint32_t alpha_seed,
                          std::vector<Vec3>& radiance, RayCounters& counters) {
  const Scene& scene = rays.scene();
  constexpr size_t pixels_a_batch = 256;
  counters += counted_parallel_for(
      gbuffer.texels.size(), pixels_a_batch, [&](size_t begin, size_t end, RayCounters& local) {
        std::vector<ShadowRay> batch;
        std::vector<Vec3> carried;
        std::vector<size_t> pixel;
        for (const PunctualLight& light : scene.lights) {
          batch.clear(), carried.clear(), pixel.clear();
          for (size_t i = begin; i < end; ++i) {
            const GBufferTexel& texel = gbuffer.texels[i];
            if (!texel.hit() || texel.brdf.black()) continue;
            const LightConnection connection = connect_punctual(light, scene, texel.position);
            const float cos_theta = glm::dot(texel.shading_normal, connection.wi);
            if (cos_theta <= 0 || glm::dot(texel.geometric_normal, connection.wi) <= 0) continue;
            const Vec3 value = texel.throughput *
                               evaluate(texel.brdf, texel.basis(), texel.wo, connection.wi) *
                               connection.irradiance * cos_theta;
            if (max_component(value) <= 0) continue;
            batch.push_back(shadow_ray(scene, texel.position, texel.geometric_normal, connection.wi,
                                       connection.distance));
            carried.push_back(value);
            pixel.push_back(i);
          }
          rays.occluded(batch, alpha_seed, local);
          for (size_t i = 0; i < batch.size(); ++i)
            if (!batch[i].blocked()) radiance[pixel[i]] += carried[i];
        }
      });
}

}  // namespace halflight
