// Distant light as a latitude-longitude map: image centre −z, right of it +x, top +y.
#pragma once

#include <string>

#include "core/image.h"
#include "core/math.h"

namespace halflight {

/// Radiance from every direction. The map is piecewise constant: look-up, integral and density all see one
/// value a texel.
struct Environment {
  std::string name;
  ImageRgb map;           ///< latitude-longitude; other layouts are resampled to it when read
  float rotation = 0;     ///< radians about +y, counter-clockwise seen from above
  float strength = 1;     ///< multiplies the radiance
  size_t bad_texels = 0;  ///< not finite, which became 0, or with negative channels, which became 0

  bool present() const { return !map.pixels.empty(); }
};

/// Point of the unit square (x right, y down from the top) of a unit direction, rotation included.
Vec2 environment_uv(const Environment&, Vec3 direction);

/// Unit direction of a point of the unit square; the inverse of `environment_uv`.
Vec3 environment_direction(const Environment&, Vec2 uv);

/// Column and row of the texel at a point of the unit square, and of the one that a unit direction falls in,
/// rotation included. There must be a map.
glm::ivec2 environment_texel(const Environment&, Vec2 uv);
glm::ivec2 environment_texel(const Environment&, Vec3 direction);

/// Radiance arriving from `direction`, strength included; 0 when there is no map.
Vec3 environment_radiance(const Environment&, Vec3 direction);
/// The same by texel.
inline Vec3 environment_radiance(const Environment& environment, glm::ivec2 texel) {
  return environment.map.at(texel.x, texel.y) * environment.strength;
}

/// Solid angle of one texel of row `y`: (cos θ_top − cos θ_bottom) · 2π / width.
float texel_solid_angle(const Environment&, int y);

/// How an environment image is laid out.
enum class EnvironmentLayout { automatic, latlong, angular };

/// Makes an environment of an image: square images are Debevec's angular map, others latitude-longitude,
/// unless told. Texels with a NaN or an infinity, and negative channels of others, become 0; those texels are
/// counted. Channels above 1e30 become 1e30.
Environment make_environment(ImageRgb image, std::string name,
                             EnvironmentLayout layout = EnvironmentLayout::automatic);

/// The built-in sky of a scene that has no light at all.
Environment built_in_sky();

}  // namespace halflight
