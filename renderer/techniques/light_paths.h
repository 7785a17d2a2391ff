// Paths from the lights into the scene, with a virtual light where each meets a surface (Keller 1997,
// "Instant Radiosity"; Pharr's note on Wald et al. 2002).
#pragma once

#include "lights/virtual_light.h"
#include "techniques/traced_light.h"

namespace halflight {

struct LightPathSettings {
  uint32_t paths = 64;  ///< of one set
  uint32_t sets = 4;
  uint64_t seed = 0;
  uint32_t alpha_seed = 0;
};

/// Sets of virtual lights, each a whole estimate of the light that surfaces return, after any number of
/// bounces.
///
/// A path's light is chosen by power, environments and directional lights as a disc of parallel rays over the
/// scene's bounding sphere. Each surface met returns what arrives as a Lambertian one of its `bounce_albedo`,
/// on the side that was met; the path goes on along the BRDF with the luminance of its reflectance as
/// probability. `radiance` of a light is the path's weight · albedo / π over the number of paths,
/// `measure` 1. The same for any number of threads.
std::vector<std::vector<VirtualLight>> trace_light_paths(const LightSources&, const RayScene&,
                                                         const LightPathSettings&, RayCounters&);

}  // namespace halflight
