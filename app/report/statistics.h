// Statistics of error curves: log-log fits, the place where a curve reaches an error, bootstrap intervals
// over seeds.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace halflight {

/// A straight line in log-log coordinates: ln y = intercept + slope · ln x.
struct LogLine {
  double slope = 0, intercept = 0;
  double at(double x) const;
};

/// Least squares over the points whose x and y are positive and finite; nothing with fewer than two different
/// x.
std::optional<LogLine> fit_log_log(std::span<const double> x, std::span<const double> y);

/// A polyline, x ascending.
struct Curve {
  std::vector<double> x, y;
};

/// y at x, straight in log-log coordinates between neighbours; at the ends the nearest point's y. Nothing for
/// an empty curve.
std::optional<double> value_at(const Curve&, double x);

/// Smallest x from which on the curve has come down to `y`, straight in log-log coordinates between
/// neighbours: the first point's x where that is low enough already, infinity where the curve never comes
/// down to it.
double first_reach(const Curve&, double y);

/// x and y of each run at the same checkpoints: [run][checkpoint].
struct RunCurves {
  std::vector<std::vector<double>> x, y;
  size_t runs() const { return x.size(); }
};

/// Arithmetic means over the chosen runs (an index may occur several times): relMSE is a mean of squares, so
/// its mean over runs estimates the expected one, where a mean of logarithms would flatter the technique with
/// the longer tail.
Curve mean_curve(const RunCurves&, std::span<const uint32_t> runs);

/// A value with a 95 % interval. Infinity stands for "never"; NaN for what cannot be told.
struct Estimate {
  double value, low, high;
  bool known() const { return value == value; }
  /// Whether the interval is there and leaves `x` out.
  bool excludes(double x) const { return low > x || high < x; }
};

/// Even from the lowest to the highest of n runs holds their median with probability 1 − 2^(1−n): 94 % of
/// five.
inline constexpr size_t least_runs = 5;

/// `statistic` of all runs, with its bootstrap interval: runs are drawn with replacement, `count` times, and
/// the percentiles are widened for few runs (Hesterberg 2015, "What Teachers Should Know About the
/// Bootstrap": the expanded percentile interval), where plain ones hold the mean of five normal numbers 85 %
/// of the time. Fewer than `least_runs` runs give no
/// interval: not even the whole range of the resamples would hold the truth 95 % of the time. The same draws
/// for the same number of runs, so that ratios of techniques are of the same resample.
Estimate bootstrap(size_t runs, const std::function<double(std::span<const uint32_t>)>& statistic,
                   size_t count = 4000);

/// Quantile of Student's t with `degrees` of freedom that 97.5 % lie below.
double student_t_975(size_t degrees);

/// Distribution function of the standard normal.
double normal_cdf(double z);

}  // namespace halflight
