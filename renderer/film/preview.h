// What to show while the first round of a picture goes through subsets of its pixels.
#pragma once

#include <vector>

#include "core/image.h"
#include "film/film.h"
#include "scene/gbuffer.h"

namespace halflight {

/// The film; pixels without a sample are interpolated from the finest lattice (every 4th or 2nd pixel in x
/// and y) that has samples, over like surfaces: light is divided by the albedo there, smoothed, and
/// multiplied by the albedo here, and what is known of each pixel (`base`: emission seen and direct light of
/// other stages) comes on top. Textures, edges and shadows of that light are sharp at once. Without a
/// G-buffer of the film's size, or a base: `Film::preview`.
ImageRgb preview_picture(const Film&, const GBuffer&, const std::vector<Vec3>& base);

/// Bilinear, pixel centres kept in place; the edge goes on beyond it.
ImageRgb resized(const ImageRgb&, int width, int height);

}  // namespace halflight
