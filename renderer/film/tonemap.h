// From radiance to what a screen shows.
#pragma once

#include <span>
#include <string_view>

#include "core/image.h"

namespace halflight {

/// A tone curve: linear, exposed radiance to display-linear [0, 1].
struct ToneMap {
  std::string_view id, title;
  Vec3 (*map)(Vec3);
};

/// linear (clip), reinhard (on luminance), filmic (ACES fit), falsecolor (log luminance in stops).
std::span<const ToneMap> tone_maps();
/// Throws Error (exit code 2) for an unknown id.
const ToneMap& find_tone_map(std::string_view id);

/// sRGB transfer function (IEC 61966-2-1) and its inverse.
float srgb_encode(float linear);
float srgb_decode(float encoded);

/// 8-bit sRGB, four channels, of radiance × 2^ev under the tone map.
ImageRgba8 display_image(const ImageRgb& radiance, float ev, const ToneMap&);

}  // namespace halflight
