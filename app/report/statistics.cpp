#include "report/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/random.h"

namespace halflight {

namespace {

constexpr double endless = std::numeric_limits<double>::infinity();
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

bool has_logarithm(double v) { return v > 0 && std::isfinite(v); }

/// Where between two points, from 0 to 1, `at` lies, in logarithms.
double log_fraction(double a, double b, double at) { return std::log(at / a) / std::log(b / a); }

/// Quantile of ascending values, linear between neighbours that are finite.
double quantile(const std::vector<double>& ascending, double p) {
  const double place = p * static_cast<double>(ascending.size() - 1);
  const auto below = static_cast<size_t>(place);
  const size_t above = std::min(below + 1, ascending.size() - 1);
  if (!std::isfinite(ascending[above]))
    return place > static_cast<double>(below) ? ascending[above] : ascending[below];
  return ascending[below] + (place - static_cast<double>(below)) * (ascending[above] - ascending[below]);
}

/// Density of Student's t, without its constant factor.
double student_shape(double t, double degrees) {
  return std::exp(-0.5 * (degrees + 1) * std::log1p(t * t / degrees));
}

/// ∫ of the shape over [0, t] by Simpson's rule.
double student_mass(double t, double degrees) {
  constexpr int steps = 400;
  double sum = student_shape(0, degrees) + student_shape(t, degrees);
  for (int i = 1; i < steps; ++i) sum += (i % 2 ? 4 : 2) * student_shape(t * i / steps, degrees);
  return sum * t / (3 * steps);
}

}  // namespace

double LogLine::at(double x) const { return std::exp(intercept + slope * std::log(x)); }

std::optional<LogLine> fit_log_log(std::span<const double> x, std::span<const double> y) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (size_t i = 0; i < x.size(); ++i) {
    if (!has_logarithm(x[i]) || !has_logarithm(y[i])) continue;
    const double u = std::log(x[i]), v = std::log(y[i]);
    n += 1, sx += u, sy += v, sxx += u * u, sxy += u * v;
  }
  const double spread = n * sxx - sx * sx;
  if (n < 2 || !(spread > 1e-12 * std::max(1.0, n * sxx))) return {};
  LogLine line;
  line.slope = (n * sxy - sx * sy) / spread;
  line.intercept = (sy - line.slope * sx) / n;
  return line;
}

std::optional<double> value_at(const Curve& curve, double x) {
  if (curve.x.empty()) return {};
  if (x <= curve.x.front()) return curve.y.front();
  for (size_t i = 1; i < curve.x.size(); ++i) {
    if (x > curve.x[i]) continue;
    if (!has_logarithm(curve.y[i - 1]) || !has_logarithm(curve.y[i]) || !(curve.x[i] > curve.x[i - 1]))
      return curve.y[i];
    const double f = log_fraction(curve.x[i - 1], curve.x[i], x);
    return curve.y[i - 1] * std::pow(curve.y[i] / curve.y[i - 1], f);
  }
  return curve.y.back();
}

double first_reach(const Curve& curve, double y) {
  // From the end: a curve that rises again has not come down for good.
  size_t i = curve.y.size();
  while (i > 0 && curve.y[i - 1] <= y) --i;
  if (i == curve.y.size()) return endless;
  if (i == 0) return curve.x.front();
  const double above = curve.y[i - 1], below = curve.y[i];
  if (!has_logarithm(below) || !has_logarithm(above)) return curve.x[i];
  return curve.x[i - 1] * std::pow(curve.x[i] / curve.x[i - 1], log_fraction(above, below, y));
}

Curve mean_curve(const RunCurves& curves, std::span<const uint32_t> runs) {
  Curve mean;
  if (runs.empty()) return mean;
  const size_t points = curves.x.front().size();
  mean.x.assign(points, 0), mean.y.assign(points, 0);
  for (const uint32_t run : runs) {
    for (size_t i = 0; i < points; ++i) {
      mean.x[i] += curves.x[run][i] / static_cast<double>(runs.size());
      mean.y[i] += curves.y[run][i] / static_cast<double>(runs.size());
    }
  }
  return mean;
}

double normal_cdf(double z) { return 0.5 * std::erfc(-z / std::sqrt(2.0)); }

double student_t_975(size_t degrees) {
  const double nu = static_cast<double>(degrees);
  // Half of the whole mass is √(πν)/2 · Γ(ν/2)/Γ((ν+1)/2) of the shape; its part below the quantile is 0.95.
  const double half =
      0.5 * std::sqrt(std::acos(-1.0) * nu) * std::exp(std::lgamma(0.5 * nu) - std::lgamma(0.5 * (nu + 1)));
  double low = 1.9, high = 13;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (student_mass(middle, nu) < 0.95 * half ? low : high) = middle;
  }
  return low;
}

Estimate bootstrap(size_t runs, const std::function<double(std::span<const uint32_t>)>& statistic,
                   size_t count) {
  std::vector<uint32_t> chosen(runs);
  std::iota(chosen.begin(), chosen.end(), 0u);
  Estimate estimate{statistic(chosen), unknown, unknown};
  if (runs < least_runs) return estimate;

  std::vector<double> values;
  values.reserve(count);
  for (size_t b = 0; b < count; ++b) {
    RandomStream random(runs, b, 0);
    for (uint32_t& run : chosen)
      run = std::min(static_cast<uint32_t>(random.next() * static_cast<float>(runs)),
                     static_cast<uint32_t>(runs - 1));
    if (const double value = statistic(chosen); !std::isnan(value)) values.push_back(value);
  }
  if (values.empty()) return estimate;
  std::sort(values.begin(), values.end());

  // Hesterberg 2015: the level whose normal quantile is −√(n/(n−1)) t.
  const double n = static_cast<double>(runs);
  const double level = normal_cdf(-std::sqrt(n / (n - 1)) * student_t_975(runs - 1));
  estimate.low = quantile(values, level);
  estimate.high = quantile(values, 1 - level);
  return estimate;
}

}  // namespace halflight
