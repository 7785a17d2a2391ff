// Small procedural textures of the built-in scenes; all repeat seamlessly unless they say otherwise,
// sRGB-encoded.
#pragma once

#include "core/image.h"
#include "core/math.h"

namespace halflight {

/// Floor boards running along v: `boards` across, each a shade of its own, staggered ends, dark joints.
ImageRgba8 board_texture(int size, int boards, Vec3 light, Vec3 dark, uint32_t seed);

/// Grain of one piece of wood running along v.
ImageRgba8 grain_texture(int size, Vec3 light, Vec3 dark, uint32_t seed);

/// Plain weave of `threads` threads, to be multiplied with a colour: near white.
ImageRgba8 weave_texture(int size, int threads, float contrast, uint32_t seed);

/// A whole woven rug, twice as long (v) as wide: borders, medallions and small motifs. Does not repeat.
ImageRgba8 rug_texture(int width, int height, Vec3 ground, Vec3 figure, Vec3 accent, uint32_t seed);

/// An abstract landscape in bands, under a disk of `sun` colour. Does not repeat.
ImageRgba8 landscape_texture(int size, Vec3 sky, Vec3 land, Vec3 sun, uint32_t seed);

/// Leaves on a stem, in the manner of a botanical plate. Does not repeat.
ImageRgba8 botanical_texture(int size, Vec3 paper, Vec3 leaf, uint32_t seed);

/// Veined marble tiles, light and dark in turn, `tiles` (even) across, with thin joints.
ImageRgba8 checker_texture(int size, int tiles, Vec3 light, Vec3 dark, uint32_t seed);

/// A linear picture, clamped to [0, 1], as a texture.
ImageRgba8 encoded(const ImageRgb&);

}  // namespace halflight
