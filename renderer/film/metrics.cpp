#include "film/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/errors.h"

namespace halflight {

namespace {

double mean_of(const std::vector<double>& values) {
  return values.empty()
             ? 0
             : std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Mean without the largest 0.1 % (at least one value where there are that many).
double trimmed_mean(std::vector<double> values) {
  const size_t dropped = values.size() / 1000;
  std::nth_element(values.begin(), values.end() - static_cast<ptrdiff_t>(dropped), values.end());
  values.resize(values.size() - dropped);
  return mean_of(values);
}

}  // namespace

ErrorMetrics measure_radiance_error(const ImageRgb& image, const ImageRgb& reference) {
  HALFLIGHT_CHECK(image.width == reference.width && image.height == reference.height);
  const size_t count = image.pixels.size();
  double reference_mean = 0;
  for (const Vec3& r : reference.pixels)
    if (is_finite(r)) reference_mean += (static_cast<double>(r.x) + r.y + r.z) / 3;
  if (count > 0) reference_mean /= static_cast<double>(count);
  const double floor2 = std::pow(0.01 * reference_mean, 2);

  constexpr double endless = std::numeric_limits<double>::infinity();
  std::vector<double> relative(count);
  double squares = 0, symmetric = 0;
  for (size_t i = 0; i < count; ++i) {
    if (!is_finite(image.pixels[i]) || !is_finite(reference.pixels[i])) {
      relative[i] = squares = endless;
      symmetric += 1;
      continue;
    }
    for (int c = 0; c < 3; ++c) {
      const double x = image.pixels[i][c], r = reference.pixels[i][c], square_error = (x - r) * (x - r);
      const double scale = r * r + floor2, sum = std::abs(x) + std::abs(r);
      if (square_error > 0) relative[i] += (scale > 0 ? square_error / scale : 1.0) / 3;
      squares += square_error / 3;
      if (sum > 0) symmetric += std::abs(x - r) / sum / 3;
    }
  }
  ErrorMetrics metrics;
  metrics.relmse = mean_of(relative);
  metrics.relmse_trimmed = trimmed_mean(relative);
  metrics.rmse = count > 0 ? std::sqrt(squares / static_cast<double>(count)) : 0;
  metrics.smape = count > 0 ? symmetric / static_cast<double>(count) : 0;
  return metrics;
}

ErrorMetrics measure_error(const ImageRgb& image, const ImageRgb& reference, float exposure_ev) {
  ErrorMetrics metrics = measure_radiance_error(image, reference);
  const size_t count = image.pixels.size();
  const std::vector<float> flip = flip_map(image, reference, exposure_ev);
  metrics.flip = count > 0 ? std::accumulate(flip.begin(), flip.end(), 0.0) / static_cast<double>(count) : 0;
  return metrics;
}

}  // namespace halflight
