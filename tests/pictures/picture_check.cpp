// Facts about a picture that a test can hold: picture_check IMAGE WxH LIT-PERCENT [EV]
// Fails unless the picture has that size, only finite values that are not negative, and at least that share
// of its pixels well above black: more than a hundredth of the mean luminance, or, with EV, of white as displayed.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <string>

#include "scene/image_files.h"

using namespace halflight;

namespace {

int check(const std::string& file, const std::string& size, double lit_percent, const char* ev) {
  const ImageRgb image = read_image(file, LoadLimits{});
  if (fmt::format("{}x{}", image.width, image.height) != size) {
    std::printf("%s: is %dx%d, expected %s\n", file.c_str(), image.width, image.height, size.c_str());
    return 1;
  }
  double sum = 0;
  for (const Vec3& pixel : image.pixels) {
    if (!is_finite(pixel) || glm::any(glm::lessThan(pixel, Vec3(0)))) {
      std::printf("%s: a pixel is (%g, %g, %g)\n", file.c_str(), pixel.x, pixel.y, pixel.z);
      return 1;
    }
    sum += luminance(pixel);
  }
  const double mean = sum / static_cast<double>(image.pixels.size());
  const double threshold = 0.01 * (ev ? std::exp2(-std::atof(ev)) : mean);
  size_t lit = 0;
  for (const Vec3& pixel : image.pixels) lit += luminance(pixel) > threshold;
  const double percent = 100.0 * static_cast<double>(lit) / static_cast<double>(image.pixels.size());
  std::printf("%s: mean luminance %g, %.1f %% lit\n", file.c_str(), mean, percent);
  return mean > 0 && percent >= lit_percent ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4 && argc != 5) return 2;
  try {
    return check(argv[1], argv[2], std::atof(argv[3]), argc == 5 ? argv[4] : nullptr);
  } catch (const std::exception& error) {
    std::printf("%s\n", error.what());
    return 1;
  }
}
