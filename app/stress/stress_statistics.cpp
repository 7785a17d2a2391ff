#include "stress/stress_statistics.h"

#include <algorithm>
#include <cmath>

#include "report/statistics.h"

namespace halflight {

std::vector<double> Marks::of(const ImageRgb& image) {
  const bool tiled = image.width >= 2 * tile_columns && image.height >= 2 * tile_rows;
  std::vector<double> marks(channels + (tiled ? tile_columns * tile_rows : 0));
  std::vector<double> counts(marks.size());
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      const Vec3d value(image.at(x, y));
      for (int c = 0; c < channels; ++c) marks[c] += value[c], ++counts[c];
      if (!tiled) continue;
      const size_t tile =
          channels + y * tile_rows / image.height * tile_columns + x * tile_columns / image.width;
      marks[tile] += (value.x + value.y + value.z) / 3, ++counts[tile];
    }
  for (size_t i = 0; i < marks.size(); ++i) marks[i] /= counts[i];
  return marks;
}

void MarkStatistics::add(const std::vector<double>& marks) {
  mean.resize(marks.size());
  squares.resize(marks.size());
  ++runs;
  for (size_t i = 0; i < marks.size(); ++i) {
    const double before = marks[i] - mean[i];
    mean[i] += before / runs;
    squares[i] += before * (marks[i] - mean[i]);
  }
}

double MarkStatistics::variance_of_mean(size_t mark) const {
  return runs > 1 ? squares[mark] / (runs - 1) / runs : 0;
}

namespace {

/// |z| that a standard normal exceeds with probability `level`, two-sided.
double two_sided_z(double level) {
  double low = 0, high = 40;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (2 * normal_cdf(-middle) > level ? low : high) = middle;
  }
  return high;
}

/// The same of Student's t, by Wallace's transform (1959, "Bounds on Normal Approximations to Student's and
/// the Chi-Square Distributions"), good to a few per mille from five degrees up.
double two_sided_t(double level, double degrees) {
  const double z = two_sided_z(level) * (8 * degrees + 3) / (8 * degrees + 1);
  return std::sqrt(degrees * std::expm1(z * z / degrees));
}

/// Level of each of `tests` tests for all to stand at `level` (Šidák 1967).
double sidak_level(double level, size_t tests) {
  return -std::expm1(std::log1p(-level) / static_cast<double>(tests));
}

/// Degrees of freedom of a difference of two means (Welch 1947; Satterthwaite 1946).
double welch_degrees(double variance_a, double runs_a, double variance_b, double runs_b) {
  const auto share = [](double variance, double runs) {
    return runs > 1 ? variance * variance / (runs - 1) : 0;
  };
  const double sum = share(variance_a, runs_a) + share(variance_b, runs_b);
  return sum > 0 ? (variance_a + variance_b) * (variance_a + variance_b) / sum : 1e6;
}

}  // namespace

MeanTest test_means(const MarkStatistics& found, const MarkStatistics& truth, double tolerance) {
  MeanTest test;
  const double level = sidak_level(stress_level, found.mean.size());
  double whole = 0;
  for (int c = 0; c < Marks::channels; ++c) whole += truth.mean[c] / Marks::channels;
  for (size_t i = 0; i < found.mean.size(); ++i) {
    // Scaled before it is squared: radiances reach 1e30.
    const double scale = whole > 0 ? 1 / whole : 1;
    const double a = found.variance_of_mean(i) * scale * scale, b = truth.variance_of_mean(i) * scale * scale;
    const double difference = (found.mean[i] - truth.mean[i]) * scale;
    const double slack = tolerance * std::max(truth.mean[i] * scale, 1.0);
    const double deviation = std::sqrt(a + b);
    const double bound = two_sided_t(level, welch_degrees(a, found.runs, b, truth.runs));
    const double z = deviation > 0 ? difference / deviation : 0;
    const double beyond = std::max(0.0, std::abs(difference) - slack);
    const double worst = beyond == 0 ? 0 : deviation > 0 ? beyond / (bound * deviation) : 1e9;
    if (i < Marks::channels) {
      test.interval = std::max(test.interval, bound * deviation);
      if (std::abs(z) > std::abs(test.z)) test.z = z;
    }
    if (std::abs(z) > test.worst_z) test.worst_z = std::abs(z), test.bound = bound;
    if (worst > test.worst) test.worst = worst, test.direction = difference;
  }
  return test;
}

}  // namespace halflight
