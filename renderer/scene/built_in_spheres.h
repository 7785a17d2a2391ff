// Spheres of modified Phong under an environment: the scenes of Křivánek's write-up on combining BRDF and
// environment samples.
#pragma once

#include "scene/scene.h"

namespace halflight {

/// One unit sphere (16,128 faces, exact normals) of modified Phong with ρ_d = 0.2, ρ_s = 0.7 and the given
/// exponent, alone under `environment`: convex, so nothing stands in its light.
Scene make_phong_sphere(float exponent, const Environment& environment);

}  // namespace halflight
