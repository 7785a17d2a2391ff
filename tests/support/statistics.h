// Statistics that several tests share.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace halflight {

/// Upper tail of the standard normal distribution.
inline double normal_tail(double z) { return 0.5 * std::erfc(z / std::sqrt(2.0)); }

/// Probability that χ² with `freedom` degrees exceeds `value` (Wilson & Hilferty 1931), good from a few
/// degrees up.
inline double chi_square_tail(double value, double freedom) {
  const double spread = 2.0 / (9.0 * freedom);
  return normal_tail((std::cbrt(value / freedom) - (1 - spread)) / std::sqrt(spread));
}

/// The normal deviate with the same tails as Student's t of `freedom` degrees (Wallace 1959).
inline double normal_of_student(double t, double freedom) {
  const double size =
      (8 * freedom + 1) / (8 * freedom + 3) * std::sqrt(freedom * std::log1p(t * t / freedom));
  return std::copysign(size, t);
}

/// p-value of observed counts against expected ones; cells expecting fewer than 5 are pooled.
inline double chi_square_p(const std::vector<double>& observed, const std::vector<double>& expected) {
  double statistic = 0, pooled_observed = 0, pooled_expected = 0;
  size_t cells = 0;
  for (size_t i = 0; i < observed.size(); ++i) {
    if (expected[i] < 5) {
      pooled_observed += observed[i], pooled_expected += expected[i];
      continue;
    }
    statistic += (observed[i] - expected[i]) * (observed[i] - expected[i]) / expected[i];
    ++cells;
  }
  if (pooled_expected >= 5) {
    statistic += (pooled_observed - pooled_expected) * (pooled_observed - pooled_expected) / pooled_expected;
    ++cells;
  } else if (pooled_expected == 0 && pooled_observed > 0) {
    return 0;  // drew what cannot be drawn
  }
  return cells > 1 ? chi_square_tail(statistic, static_cast<double>(cells - 1)) : 1.0;
}

/// Level at which each of `tests` independent tests must stand for all to stand at `level` (Šidák 1967).
inline double sidak_level(double level, size_t tests) {
  return 1 - std::pow(1 - level, 1.0 / static_cast<double>(tests));
}

/// |z| that a standard normal exceeds with probability `level`, two-sided; by bisection.
inline double two_sided_bound(double level) {
  double low = 0, high = 40;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (2 * normal_tail(middle) > level ? low : high) = middle;
  }
  return high;
}

}  // namespace halflight
