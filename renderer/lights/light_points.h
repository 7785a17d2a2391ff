// Where the members of S lie: points spread over surfaces, emitters and the sphere of directions. Positions
// depend on geometry and seed only; their radiance is found each time a light changes.
#pragma once

#include <vector>

#include "lights/virtual_light.h"
#include "scene/scene.h"
#include "scene/shading.h"

namespace halflight {

struct LightPointSettings {
  uint32_t count =
      32768;  ///< |S|: surface points, environment points and emitter points each take up to this share
  uint64_t seed = 0;
  int repulsion_steps = 4;  ///< 0: independent stratified points, which have a known density
};

/// A point of the scene's surface that returns light on both sides.
struct BouncePoint {
  Vec3 position;
  float area;   ///< A_i: the scene's area that returns light, shared out
  Vec3 normal;  ///< unit geometric normal, front side
  SurfacePoint surface;
  Vec3 albedo;  ///< `bounce_albedo` × coverage, there or averaged over the point's cell
};

/// Points spread evenly over all surfaces that return light: one in each of `count` strata of equal area,
/// then pushed apart (Wang & Åkerlund §4; Turk 1991). Pushed points carry the area nearest to them and its
/// mean albedo, for their density is not quite even; points left where they were drawn carry equal areas and
/// their own albedo.
std::vector<BouncePoint> spread_surface_points(const Scene&, const LightPointSettings&);

/// Points on emissive triangles in proportion to power, at least one each, and Σ A_i of a triangle is its
/// area; one light a side that emits. A quarter of `count` points in all, more where the minimum asks for it;
/// only with more triangles than `count` some are left out, and those chosen by power stand for them on
/// average.
std::vector<VirtualLight> emitter_points(const Scene&, const LightPointSettings&);

/// Directions towards the environment, each standing for a cell; L_i is the cell's average, so Σ L_i Ω_i = ∫
/// L, and Σ Ω_i = 4π. Two errors are traded: cells of an even set (a spherical Fibonacci set, turned at
/// random) bound the angle by which light is moved, however dim it is; but a texel brighter than two mean
/// cells would be smeared over its own. So up to half of the points, as many as there are such texels, are
/// single texels (where they are smaller than a cell), and there that angle is half a texel, and the even set
/// shares out the rest. A cell's direction is its centre of power. With `repulsion_steps` 0: independent
/// directions by power, for which the sum has the integral as its mean.
std::vector<VirtualLight> environment_points(const Environment&, const LightPointSettings&);

/// One light a punctual light of the scene. Directional ones lie at infinity: they join the distant lights,
/// each as a direction with a small solid angle Ω and L = E⊥/Ω.
std::vector<VirtualLight> punctual_points(const Scene&);

/// Two lights a bounce point, front then back; radiance = albedo / π · irradiance[2·i + side].
std::vector<VirtualLight> bounce_lights(const std::vector<BouncePoint>&, const std::vector<Vec3>& irradiance);

}  // namespace halflight
