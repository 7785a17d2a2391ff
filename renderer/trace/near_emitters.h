// Light of emitters that are near beside their size: a point drawn on them by area weighs like 1/r², without
// bound. Where one can be that near, a ray by the cosine shares the estimate under the balance heuristic
// (Veach & Guibas 1995).
#pragma once

#include "core/random.h"
#include "trace/light_sampling.h"
#include "trace/ray_scene.h"

namespace halflight {

/// Weight of one of `draws` points of the emitters seen at `distance` with density `pdf` per solid angle,
/// beside the ray of `near_emission`. 1 beyond EmitterSampler::near_distance.
inline float weight_beside_near_ray(const EmitterSampler& emitters, float draws, float pdf, float distance,
                                    float cos_theta) {
  if (!(distance < emitters.near_distance())) return 1;
  const float by_points = draws * pdf;
  return by_points / (by_points + cos_theta / pi);
}

/// Irradiance at x on the side of `normal` (geometric, unit) that one ray by the cosine finds on emitters
/// nearer than EmitterSampler::near_distance, weighed beside `draws` points drawn on them. No ray where none
/// can be so near.
Vec3 near_emission(const RayScene&, const EmitterSampler&, Vec3 x, Vec3 normal, float draws, RandomStream&,
                   uint32_t alpha_seed, RayCounters&);

}  // namespace halflight
