// The triangles that emit, for the points of S on them and for sampling them by rays.
#pragma once

#include <vector>

#include "scene/scene.h"
#include "scene/shading.h"

namespace halflight {

struct EmissiveTriangle {
  uint32_t triangle;
  float area;
  float power;  ///< area × mean luminance, as a share of all emitters' (they add to one); never 0
};

/// Triangles that light others: emissive, with an area, not unlit.
std::vector<EmissiveTriangle> emissive_triangles(const Scene&);

/// Radiance that leaves the point towards `side` of the geometric normal (+1 front, −1 back) on average over
/// alpha's seeds: emission × coverage.
Vec3 covered_emission(const Scene&, SurfacePoint, int side);

}  // namespace halflight
