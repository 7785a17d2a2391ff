// What the extreme scenes are built of. Lengths are the scene's; +y is up.
#pragma once

#include <vector>

#include "scene/mesh_builder.h"

namespace halflight {

/// Reflects evenly in all directions.
Material matte(Vec3 reflectance);
Material glowing(Vec3 radiance);
Material phong(Vec3 diffuse, Vec3 specular, float exponent);

/// A rectangle from a corner along two edges, its front towards a × b.
void add_sheet(Scene&, Vec3 corner, Vec3 a, Vec3 b, uint32_t material);

/// A map of 32 × 16 texels of one radiance.
Environment even_sky(Vec3 radiance);
/// A dim sky of 64 × 32 texels with some of them suns: place in the map and radiance.
struct Sun {
  int x, y;
  Vec3 radiance;
};
Environment sky_with_suns(Vec3 sky, const std::vector<Sun>&);

/// A floor of 2 × 2 of the material that is tried, material 0; a wall behind it that returns light, a lamp
/// above, a card that casts shadows, a sky with a soft sun. Nothing is nearer to anything than 0.1, so that
/// 1/r² stays tame.
Scene studio(const Material& floor);

/// The floor alone, of material 0, under a sky.
Scene open_floor(const Material& floor, const Environment& sky);

/// A point light; `intensity` in candela.
PunctualLight point_light(Vec3 position, Vec3 intensity);

/// Everything `factor` times as far from the origin; the picture stays.
Scene scaled_lengths(Scene, float factor);
/// All that sends light `factor` times as strong.
Scene scaled_radiance(Scene, float factor);
/// Moved as a whole.
Scene moved(Scene, Vec3 by);

}  // namespace halflight
