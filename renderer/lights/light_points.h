// Where the members of S lie: points spread over surfaces, emitters and the sphere of directions. Positions depend on
// geometry and seed only; their radiance is found each time a light changes.
#pragma once

#include <vector>

#include "lights/virtual_light.h"
#include "scene/scene.h"
#include "scene/shading.h"

namespace halflight {

struct LightPointSettings {
  uint32_t count = 32768;  ///< |S|: surface points, environment points and emitter points each take up to this share
  uint64_t seed = 0;
  int repulsion_steps = 4;  ///< 0: independent stratified points, which have a known density
};

/// A point of the scene's surface that returns light on both sides.
struct BouncePoint {
  Vec3 position;
  float area;            ///< A_i: the scene's area shared out
  Vec3 normal;           ///< unit geometric normal, front side
  SurfacePoint surface;
  Vec3 albedo;           ///< `bounce_albedo` there
};

/// Points spread evenly over all surfaces: random by area, then pushed apart (Wang & Åkerlund §4; Turk 1991).
std::vector<BouncePoint> spread_surface_points(const Scene&, const LightPointSettings&);

/// Points on emissive triangles in proportion to power, at least one each; one light a side that emits.
std::vector<VirtualLight> emitter_points(const Scene&, const LightPointSettings&);

/// Directions towards the environment, each standing for a cell; L_i is the cell's average, so Σ L_i Ω_i = ∫ L.
std::vector<VirtualLight> environment_points(const Environment&, const LightPointSettings&);

/// One light a punctual light of the scene.
std::vector<VirtualLight> punctual_points(const Scene&);

/// Two lights a bounce point, front then back; radiance = albedo / π · irradiance[2·i + side].
std::vector<VirtualLight> bounce_lights(const std::vector<BouncePoint>&, const std::vector<Vec3>& irradiance);

}  // namespace halflight
