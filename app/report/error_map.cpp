#include "report/error_map.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace halflight {

namespace {

/// Evenly spaced from −1 to 1, sRGB, lightness falling the same way to both sides.
constexpr std::array<std::array<float, 3>, 9> stops{{{8, 40, 100},
                                                     {33, 102, 172},
                                                     {90, 160, 205},
                                                     {178, 212, 230},
                                                     {247, 247, 247},
                                                     {250, 205, 180},
                                                     {230, 140, 105},
                                                     {190, 50, 50},
                                                     {100, 5, 30}}};

}  // namespace

std::vector<float> signed_error(const ImageRgb& image, const ImageRgb& reference) {
  double mean = 0;
  for (const Vec3& r : reference.pixels)
    if (is_finite(r)) mean += luminance(r);
  mean /= static_cast<double>(std::max<size_t>(reference.pixels.size(), 1));
  const double floor2 = 1e-4 * mean * mean;
  std::vector<float> map(image.pixels.size(), 0.0f);
  for (size_t i = 0; i < map.size(); ++i) {
    const double x = luminance(image.pixels[i]), r = luminance(reference.pixels[i]);
    const double scale = std::sqrt(r * r + floor2);
    const double error = scale > 0 ? (x - r) / scale : 0;
    map[i] = std::isfinite(error) ? static_cast<float>(error) : 0;
  }
  return map;
}

double error_scale(const std::vector<std::vector<float>>& maps) {
  std::vector<float> sizes;
  for (const auto& map : maps)
    for (const float value : map) sizes.push_back(std::abs(value));
  if (sizes.empty()) return 1;
  const auto place = sizes.begin() + static_cast<ptrdiff_t>(0.95 * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), place, sizes.end());
  const double value = *place;
  if (!(value > 0)) return 1;
  const double decade = std::pow(10, std::floor(std::log10(value)));
  for (const double step : {1, 2, 5})
    if (value <= step * decade) return step * decade;
  return 10 * decade;
}

ImageRgba8 error_picture(const std::vector<float>& map, int width, int height, double scale) {
  ImageRgba8 image{width, height, std::vector<uint8_t>(4 * map.size(), 255)};
  for (size_t i = 0; i < map.size(); ++i) {
    const double place = (std::clamp(map[i] / scale, -1.0, 1.0) + 1) / 2 * (stops.size() - 1);
    const size_t below = std::min(static_cast<size_t>(place), stops.size() - 2);
    const double f = place - static_cast<double>(below);
    for (size_t c = 0; c < 3; ++c)
      image.bytes[4 * i + c] =
          static_cast<uint8_t>(std::lround(stops[below][c] + f * (stops[below + 1][c] - stops[below][c])));
  }
  return image;
}

std::string error_gradient() {
  std::string text = "linear-gradient(to right";
  for (const auto& stop : stops)
    text += fmt::format(", rgb({:.0f} {:.0f} {:.0f})", stop[0], stop[1], stop[2]);
  return text + ")";
}

}  // namespace halflight
