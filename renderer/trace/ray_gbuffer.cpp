#include "trace/ray_gbuffer.h"

#include <array>

#include "core/parallel.h"
#include "lights/virtual_light.h"
#include "trace/counted_loop.h"

namespace halflight {

ClosestRay closest_ray(const CameraRay& ray) {
  return {{ray.origin.x, ray.origin.y, ray.origin.z, 0, ray.direction.x, ray.direction.y, ray.direction.z, 0,
           infinity}};
}

void trace_texels(const RayScene& rays, std::span<ClosestRay> batch, uint32_t alpha_seed,
                  std::span<GBufferTexel> texels, RayCounters& counters) {
  const Scene& scene = rays.scene();
  rays.intersect(batch, true, alpha_seed, counters);
  for (size_t i = 0; i < batch.size(); ++i) {
    const ClosestRay& ray = batch[i];
    const Vec3 direction(ray.ray.direction_x, ray.ray.direction_y, ray.ray.direction_z);
    if (ray.met()) {
      texels[i] = shade_surface(scene, rays.hit_of(ray).point, -direction);
      continue;
    }
    texels[i] = GBufferTexel{};
    texels[i].wo = -direction;
    texels[i].emission = environment_radiance(scene.environment, direction);
  }
}

void trace_gbuffer(const RayScene& rays, const Camera& camera, Vec2 jitter, uint32_t alpha_seed,
                   GBuffer& gbuffer, RayCounters& counters) {
  // Rows of blocks: rays of a few neighbouring pixels are traced together.
  constexpr int side = 8;
  const CameraRays camera_rays(camera, gbuffer.width, gbuffer.height);
  const auto columns = static_cast<size_t>((gbuffer.width + side - 1) / side),
             rows = static_cast<size_t>((gbuffer.height + side - 1) / side);
  counters += counted_parallel_for(columns * rows, 16, [&](size_t begin, size_t end, RayCounters& local) {
    std::array<ClosestRay, side * side> batch;
    std::array<GBufferTexel, side * side> texels;
    for (size_t block = begin; block < end; ++block) {
      const int left = static_cast<int>(block % columns) * side,
                top = static_cast<int>(block / columns) * side;
      const int right = std::min(left + side, gbuffer.width), bottom = std::min(top + side, gbuffer.height);
      size_t count = 0;
      for (int y = top; y < bottom; ++y)
        for (int x = left; x < right; ++x)
          batch[count++] = closest_ray(camera_rays.through(Vec2(x + 0.5f, y + 0.5f) + jitter));
      trace_texels(rays, std::span(batch).first(count), alpha_seed, std::span(texels).first(count), local);
      count = 0;
      for (int y = top; y < bottom; ++y)
        for (int x = left; x < right; ++x)
          gbuffer.texels[static_cast<size_t>(y) * gbuffer.width + x] = texels[count++];
    }
  });
}

void add_punctual_by_rays(const RayScene& rays, std::span<const GBufferTexel> texels, uint32_t alpha_seed,
                          std::span<Vec3> radiance, RayCounters& counters) {
  const Scene& scene = rays.scene();
  thread_local std::vector<ShadowRay> batch;
  thread_local std::vector<Vec3> carried;
  thread_local std::vector<size_t> place;
  for (const PunctualLight& light : scene.lights) {
    batch.clear(), carried.clear(), place.clear();
    for (size_t i = 0; i < texels.size(); ++i) {
      const GBufferTexel& texel = texels[i];
      if (!texel.hit() || texel.brdf.black()) continue;
      const LightConnection connection = connect_punctual(light, scene, texel.position);
      const float cos_theta = glm::dot(texel.shading_normal, connection.wi);
      if (cos_theta <= 0 || glm::dot(texel.geometric_normal, connection.wi) <= 0) continue;
      const Vec3 value = texel.throughput * evaluate(texel.brdf, texel.basis(), texel.wo, connection.wi) *
                         connection.irradiance * cos_theta;
      if (max_component(value) <= 0) continue;
      batch.push_back(
          shadow_ray(scene, texel.position, texel.geometric_normal, connection.wi, connection.distance));
      carried.push_back(value);
      place.push_back(i);
    }
    rays.occluded(batch, alpha_seed, counters);
    for (size_t i = 0; i < batch.size(); ++i)
      if (!batch[i].blocked()) radiance[place[i]] += carried[i];
  }
}

void add_punctual_by_rays(const RayScene& rays, const GBuffer& gbuffer, uint32_t alpha_seed,
                          std::vector<Vec3>& radiance, RayCounters& counters) {
  constexpr size_t pixels_a_batch = 256;
  const std::span<const GBufferTexel> texels(gbuffer.texels);
  const std::span<Vec3> pixels(radiance);
  counters +=
      counted_parallel_for(texels.size(), pixels_a_batch, [&](size_t begin, size_t end, RayCounters& local) {
        add_punctual_by_rays(rays, texels.subspan(begin, end - begin), alpha_seed,
                             pixels.subspan(begin, end - begin), local);
      });
}

}  // namespace halflight
