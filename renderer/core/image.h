// Images in memory: rows from the top, channels interleaved.
#pragma once

#include <cstdint>
#include <vector>

#include "core/math.h"

namespace halflight {

/// Linear RGB radiance.
struct ImageRgb {
  int width = 0, height = 0;
  std::vector<Vec3> pixels;

  ImageRgb() = default;
  ImageRgb(int w, int h, Vec3 fill = Vec3(0)) : width(w), height(h), pixels(static_cast<size_t>(w) * h, fill) {}
  Vec3& at(int x, int y) { return pixels[static_cast<size_t>(y) * width + x]; }
  const Vec3& at(int x, int y) const { return pixels[static_cast<size_t>(y) * width + x]; }
};

/// Four 8-bit channels, as files store them; whether RGB is sRGB-encoded is the user's knowledge.
struct ImageRgba8 {
  int width = 0, height = 0;
  std::vector<uint8_t> bytes;  ///< 4 · width · height
};

}  // namespace halflight
