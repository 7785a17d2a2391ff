// Distances between a picture and its reference.
#pragma once

#include <string_view>
#include <vector>

#include "core/image.h"

namespace halflight {

struct ErrorMetrics {
  double relmse = 0;          ///< mean((x−r)²/(r² + (0.01 mean r)²)) over pixels and channels
  double relmse_trimmed = 0;  ///< without the worst 0.1 % of pixels
  double rmse = 0;
  double smape = 0;  ///< mean(|x−r|/(|x|+|r|)), 0 where both are 0
  double flip = 0;   ///< mean LDR-FLIP (Andersson et al. 2020) after exposure and sRGB, 67 pixels a degree
};

/// Both images must have the same size. `exposure_ev` is applied before FLIP only. Where a pixel is not
/// finite its error is infinite (1 in SMAPE), and FLIP sees it black: a picture with NaNs keeps no bound on
/// relMSE or RMSE.
ErrorMetrics measure_error(const ImageRgb& image, const ImageRgb& reference, float exposure_ev = 0);

/// As `measure_error` but for FLIP, which takes far longer than all the others and stays 0.
ErrorMetrics measure_radiance_error(const ImageRgb& image, const ImageRgb& reference);

/// One FLIP value a pixel, in [0, 1].
std::vector<float> flip_map(const ImageRgb& image, const ImageRgb& reference, float exposure_ev = 0);

}  // namespace halflight
