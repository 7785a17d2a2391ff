// The G-buffer by rays, and lighting of surface points by rays.
#pragma once

#include <span>
#include <vector>

#include "core/errors.h"
#include "lights/light_points.h"
#include "scene/camera.h"
#include "scene/gbuffer.h"
#include "trace/light_sampling.h"
#include "trace/ray_scene.h"

namespace halflight {

/// Fills the G-buffer through pixel centres moved by `jitter` (in pixels, each in [−½, ½)).
void trace_gbuffer(const RayScene&, const Camera&, Vec2 jitter, uint32_t alpha_seed, GBuffer&, RayCounters&);

/// What neighbouring rays of a camera see, on one thread. `rays` is overwritten.
void trace_texels(const RayScene&, std::span<ClosestRay> rays, uint32_t alpha_seed,
                  std::span<GBufferTexel> texels, RayCounters&);
/// A camera's ray as `trace_texels` takes it.
ClosestRay closest_ray(const CameraRay&);

/// Which light reaches the bounce points.
struct PointLighting {
  bool punctual = true, environment = true, emitters = true;
  int samples = 16;  ///< shadow rays a point for environment and emitters together
  uint64_t seed = 0;
  uint32_t alpha_seed = 0;
};

/// Shadow rays for each of `points` points where 32,768 of them would get `samples`: more points share as many rays, at
/// least one each. The noise of a sum over all points hangs on the rays in all.
int lighting_samples(int samples, size_t points);

/// Irradiance on both sides of each point (2·i front, 2·i + 1 back) from punctual lights (one ray each),
/// environment and emitters (sampled by power; unbiased).
std::vector<Vec3> irradiance_by_rays(const RayScene&, const std::vector<BouncePoint>&, const PointLighting&,
                                     RayCounters&);

/// The same from samplers that stand already; an empty one is left out.
std::vector<Vec3> irradiance_by_rays(const RayScene&, const EnvironmentSampler&, const EmitterSampler&,
                                     const std::vector<BouncePoint>&, const PointLighting&, RayCounters&);

/// D_punctual at each pixel by one shadow ray a light: f · cos θ · E, added to `radiance` (one a pixel).
void add_punctual_by_rays(const RayScene&, const GBuffer&, uint32_t alpha_seed, std::vector<Vec3>& radiance,
                          RayCounters&);
/// The same for some texels, on one thread.
void add_punctual_by_rays(const RayScene&, std::span<const GBufferTexel>, uint32_t alpha_seed,
                          std::span<Vec3> radiance, RayCounters&);

/// Light a scene needs to be seen: with none at all, a lamp at the ceiling where the camera stands enclosed
/// (few rays escape), else the built-in sky. Notes what it added in the facts and as a message. The rays must be those
/// of the scene.
void complete_lights(Scene&, const RayScene&, Messages&);

}  // namespace halflight
