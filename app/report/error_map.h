// Signed error maps: blue where a picture is too dark, red where it is too bright.
#pragma once

#include <string>

#include "core/image.h"

namespace halflight {

/// (x − r)/√(r² + (0.01 mean r)²) of the luminance, one number a pixel: what relMSE squares.
std::vector<float> signed_error(const ImageRgb& image, const ImageRgb& reference);

/// A round number (1, 2 or 5 times a power of ten) that 95 % of the values' magnitudes stay below; 1 where
/// all are 0.
double error_scale(const std::vector<std::vector<float>>& maps);

/// Pale at 0, blue at −scale and below, red at +scale and above.
ImageRgba8 error_picture(const std::vector<float>& map, int width, int height, double scale);

/// The same colours as a CSS gradient from −scale to +scale.
std::string error_gradient();

}  // namespace halflight
