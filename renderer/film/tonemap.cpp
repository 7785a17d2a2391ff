#include "film/tonemap.h"

#include <cmath>

#include "core/errors.h"
#include "core/parallel.h"

namespace halflight {

namespace {

Vec3 clip(Vec3 c) { return glm::clamp(c, 0.0f, 1.0f); }

/// Far above white for every curve, and small enough that its powers are numbers.
Vec3 bounded(Vec3 c) { return glm::clamp(c, 0.0f, 1e12f); }

/// Reinhard et al. 2002, eq. 3, on luminance; colours keep their hue.
Vec3 reinhard(Vec3 color) {
  const Vec3 c = bounded(color);
  return clip(c / (1 + luminance(c)));
}

/// Rational fit of the ACES reference transform (Narkowicz 2015).
Vec3 filmic(Vec3 c) {
  const Vec3 x = bounded(c) * 0.6f;
  return clip((x * (2.51f * x + 0.03f)) / (x * (2.43f * x + 0.59f) + 0.14f));
}

/// Luminance in stops about middle grey (0.18), eight below to eight above: blue, green, yellow, red, white.
Vec3 false_color(Vec3 c) {
  static constexpr Vec3 scale[] = {{0.02f, 0.01f, 0.08f}, {0.05f, 0.08f, 0.45f}, {0.02f, 0.30f, 0.55f},
                                   {0.05f, 0.45f, 0.25f}, {0.30f, 0.60f, 0.06f}, {0.80f, 0.65f, 0.03f},
                                   {0.85f, 0.25f, 0.02f}, {0.65f, 0.02f, 0.05f}, {1.0f, 0.90f, 0.90f}};
  constexpr int last = std::size(scale) - 1;
  const float l = luminance(bounded(c));
  if (!(l > 0)) return scale[0];
  const float stops = std::log2(l / 0.18f), place = std::clamp((stops + 8) / 16 * last, 0.0f, float(last));
  const int i = std::min(static_cast<int>(place), last - 1);
  return glm::mix(scale[i], scale[i + 1], place - static_cast<float>(i));
}

constexpr ToneMap maps[] = {
    {"linear", "Linear, clipped", clip},
    {"reinhard", "Reinhard", reinhard},
    {"filmic", "Filmic", filmic},
    {"falsecolor", "False colour, stops", false_color},
};

}  // namespace

std::span<const ToneMap> tone_maps() { return maps; }

const ToneMap& find_tone_map(std::string_view id) {
  std::vector<std::string> valid;
  for (const ToneMap& map : maps) {
    if (map.id == id) return map;
    valid.emplace_back(map.id);
  }
  throw unknown_name("tone map", id, valid);
}

float srgb_encode(float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

float srgb_decode(float encoded) {
  return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

ImageRgba8 display_image(const ImageRgb& radiance, float ev, const ToneMap& tone_map) {
  ImageRgba8 image{radiance.width, radiance.height, {}};
  image.bytes.resize(radiance.pixels.size() * 4);
  const float exposure = std::exp2(ev);
  parallel_for(0, radiance.pixels.size(), 8192, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Vec3 color = tone_map.map(radiance.pixels[i] * exposure);
      for (int c = 0; c < 3; ++c) {
        const float value = color[c] > 0 ? srgb_encode(std::min(color[c], 1.0f)) : 0.0f;  // NaN shows black
        image.bytes[4 * i + c] = static_cast<uint8_t>(value * 255 + 0.5f);
      }
      image.bytes[4 * i + 3] = 255;
    }
  });
  return image;
}

}  // namespace halflight
