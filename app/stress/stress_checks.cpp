#include <algorithm>
#include <cmath>

#include "core/stopwatch.h"
#include "stress/stress_stage.h"

namespace halflight {

namespace {

constexpr double rounding = 2e-5;  ///< sums in floats on the way
/// A seed's runs of the continuous target see 32 places in a pixel, not all of it.
constexpr double pixel_grid = 1e-3;
constexpr uint32_t pilot_index = 1'000'000;

/// What a run's picture is off from the truth.
class RunErrors {
 public:
  explicit RunErrors(const StressTruth& truth) : truth_(truth) {}

  void add(const ImageRgb& image) {
    const double whole = truth_.mean > 0 ? truth_.mean : 1;
    double relative = 0, squares = 0, truth_squares = 0;
    for (size_t i = 0; i < image.pixels.size(); ++i)
      for (int c = 0; c < 3; ++c) {
        // In units of the picture's mean: squares of radiances may leave the range.
        const double r = truth_.picture.pixels[i][c] / whole, x = image.pixels[i][c] / whole;
        const double error = square(x - r) - truth_.variance[i][c] / whole / whole;
        relative += error / (r * r + 1e-4);
        squares += error, truth_squares += r * r;
        largest_ = std::max(largest_, x);
      }
    ++runs_;
    relmse_ += relative / (3 * static_cast<double>(image.pixels.size()));
    variance_ += truth_squares > 0 ? squares / truth_squares : 0;
  }
  double relmse() const { return std::max(0.0, relmse_ / runs_); }
  double relative_variance() const { return std::max(0.0, variance_ / runs_); }
  double largest_pixel() const { return largest_; }

 private:
  const StressTruth& truth_;
  double runs_ = 0, relmse_ = 0, variance_ = 0, largest_ = 0;
};

double mean_of(const MarkStatistics& statistics) {
  return (statistics.mean[0] + statistics.mean[1] + statistics.mean[2]) / 3;
}

double mean_of(const ImageRgb& image) {
  double sum = 0;
  for (const Vec3 p : image.pixels) sum += (static_cast<double>(p.x) + p.y + p.z) / 3;
  return sum / static_cast<double>(image.pixels.size());
}

/// Runs for an interval within the case's, from the variance of a few; nothing where many more than can be
/// afforded would be needed.
std::optional<uint32_t> wanted_runs(const MarkStatistics& pilot, const StressTruth& truth, double interval,
                                    const RunCounts& counts) {
  if (!(truth.mean > 0)) return counts.least;
  double wanted = counts.least;
  for (int c = 0; c < Marks::channels; ++c) {
    const double deviation = std::sqrt(pilot.variance_of_mean(c) * pilot.runs) / truth.mean;
    wanted = std::max(wanted, 1.2 * square(6 * deviation / interval));
  }
  if (wanted > 8.0 * counts.most) return {};
  const double blocks = std::ceil(wanted / StressRuns::block);
  return std::min(static_cast<uint32_t>(blocks) * StressRuns::block, counts.most);
}

std::string judge_bias(const Contestant& contestant, const Measured& m) {
  const double ratio = m.mean / m.truth;
  if (ratio >= contestant.expectation.low && ratio <= contestant.expectation.high) return "";
  return fmt::format("its mean is {:.3g} of the truth; {:g} to {:g} was expected", ratio,
                     contestant.expectation.low, contestant.expectation.high);
}

void judge_mean(const Contestant& contestant, const MeanTest& test, double widest, bool quick,
                Finding& finding) {
  const bool may_have_tails = contestant.expectation.expected == Expected::tails;
  // Of a distribution with a long tail most runs lie below the mean, and close together.
  if (test.worst > 1 && may_have_tails && test.direction < 0) {
    finding.tails = true;
  } else if (test.worst > 1) {
    finding.shortfall = fmt::format("a mean is {:.1f} of its interval away from the truth", test.worst);
  } else if (test.interval > widest * (quick ? 3 : 1)) {
    finding.tails = may_have_tails;
    if (!may_have_tails)
      finding.shortfall = fmt::format("its interval of {:.1f} % is too wide to tell", 100 * test.interval);
  }
}

void describe(StressRuns& runs, const Contestant& contestant, Measured& m) {
  m.first_picture = runs.first_picture();
  m.light_count = runs.session().stats().light_count;
  m.cut_size = runs.session().stats().cut_size;
  if (contestant.target == Target::discrete) m.largest_weight = runs.largest_weight();
}

/// Σ|a − factor · b| / Σ|factor · b|, infinite where something is not finite.
double picture_difference(const ImageRgb& a, const ImageRgb& b, double factor) {
  double difference = 0, sum = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const double expected = factor * b.pixels[i][c];
      difference += std::abs(a.pixels[i][c] - expected), sum += std::abs(expected);
    }
  if (!std::isfinite(difference)) return infinity;
  return difference == 0 ? 0 : sum > 0 ? difference / sum : infinity;
}

std::string nan_shortfall(uint64_t count) {
  return count > 0 ? fmt::format("{} samples are not finite", count) : "";
}

}  // namespace

Finding check_mean(StressStage& stage, const Contestant& contestant) {
  const StressTruth& truth = stage.truth(contestant.target);
  StressRuns runs(stage, contestant);
  Finding finding;
  Measured& m = finding.measured;
  describe(runs, contestant, m);
  const StressCase& c = stage.stress_case();
  const RunCounts counts = stage.run_counts(contestant.target);
  const bool quick = counts.least < 16;

  // A pilot's variance tells how many runs it takes; the runs that count are others.
  MarkStatistics pilot, found;
  RunErrors errors(truth);
  const auto add = [&](uint32_t index, MarkStatistics& statistics) {
    const StressPicture picture = runs.run(index);
    m.nan_samples += picture.nan_samples;
    errors.add(picture.image);
    statistics.add(Marks::of(picture.image));
  };
  for (uint32_t i = 0; i < counts.pilot; ++i) add(pilot_index + i, pilot);
  const uint32_t wanted =
      wanted_runs(pilot, truth, c.interval, counts)
          .value_or(contestant.expectation.expected == Expected::tails ? counts.least : counts.most);
  const bool grid = contestant.target == Target::continuous && !c.constant_truth;
  const double tolerance = c.tolerance + (truth.mean > 0 ? rounding + (grid ? pixel_grid : 0) : 0);
  const bool may_have_tails = contestant.expectation.expected == Expected::tails;
  Stopwatch watch;
  MeanTest test;
  for (uint32_t aim = wanted; m.runs < aim;) {
    for (; m.runs < aim && !stage.stop().stop_requested(); ++m.runs) add(m.runs, found);
    if (stage.stop().stop_requested()) return finding;
    test = test_means(found, truth.marks, tolerance);
    // Where the pilot flattered, as many more as it takes.
    if (test.interval > c.interval && !may_have_tails) aim = std::min(aim + StressRuns::block, counts.most);
  }
  m.seconds = watch.seconds() / m.runs;

  m.truth = truth.mean, m.mean = mean_of(found);
  m.z = test.z, m.interval = test.interval, m.tile_z = test.worst_z, m.bound = test.bound;
  m.relmse = truth.mean > 0 ? errors.relmse() : 0;
  m.largest_pixel = errors.largest_pixel();
  m.variance = errors.relative_variance() * c.samples;

  finding.shortfall = nan_shortfall(m.nan_samples);
  if (!finding.shortfall.empty()) return finding;
  if (contestant.expectation.expected == Expected::bias)
    finding.shortfall = judge_bias(contestant, m);
  else
    judge_mean(contestant, test, c.interval, quick, finding);
  return finding;
}

Finding check_same_picture(StressStage& stage, const Contestant& contestant, double factor) {
  Finding finding;
  Measured& m = finding.measured;
  StressRuns tried(stage, contestant), base(stage, contestant, true);
  m.first_picture = tried.first_picture();
  m.light_count = tried.session().stats().light_count, m.cut_size = tried.session().stats().cut_size;
  m.difference = 0;
  Stopwatch watch;
  for (m.runs = 0; m.runs < 2; ++m.runs) {
    const StressPicture a = tried.run(m.runs), b = base.run(m.runs);
    m.nan_samples += a.nan_samples + b.nan_samples;
    m.mean = mean_of(a.image), m.truth = mean_of(b.image) * factor;
    m.difference = std::max(m.difference, picture_difference(a.image, b.image, factor));
  }
  m.seconds = watch.seconds() / (2 * m.runs);
  finding.shortfall = nan_shortfall(m.nan_samples);
  const double tolerance = stage.stress_case().tolerance;
  if (finding.shortfall.empty() && !(m.difference <= tolerance))
    finding.shortfall =
        fmt::format("pictures differ by {:.2g} of their sum, {:.2g} is allowed", m.difference, tolerance);
  if (finding.shortfall.empty() && !(m.mean > 0)) finding.shortfall = "the picture is black";
  return finding;
}

Finding check_edited_lights(StressStage& stage, const Contestant& contestant) {
  Finding finding;
  Measured& m = finding.measured;
  const StressCase& c = stage.stress_case();
  const RenderSettings settings =
      stage.settings(contestant.technique->id, contestant.target, contestant.settings);
  Messages messages;
  Session edited(c.scene(), settings, messages), fresh(c.truth_scene(), settings, messages);
  const LightEdits wanted = fresh.light_edits();
  for (int pass = 0; pass < 3; ++pass) edited.run_pass(c.samples, 1, 0, stage.stop());
  const double before = luminance(edited.film().mean_radiance());
  Stopwatch watch;
  edited.edit_lights(wanted);
  edited.run_pass(c.samples, 1, 0, stage.stop());
  m.first_picture = watch.lap();
  edited.run_pass(c.samples, 1, 0, stage.stop());
  m.seconds = watch.seconds();
  for (int pass = 0; pass < 2; ++pass) fresh.run_pass(c.samples, 1, 0, stage.stop());
  m.runs = 1;
  m.nan_samples = edited.film().nan_samples() + fresh.film().nan_samples();
  m.mean = luminance(edited.film().mean_radiance()), m.truth = luminance(fresh.film().mean_radiance());
  m.light_count = edited.stats().light_count, m.cut_size = edited.stats().cut_size;
  m.difference = picture_difference(edited.film().image(), fresh.film().image(), 1);
  finding.shortfall = nan_shortfall(m.nan_samples);
  if (finding.shortfall.empty() && !(m.difference <= c.tolerance))
    finding.shortfall =
        fmt::format("an edited session and a new one differ by {:.2g} of the picture's sum", m.difference);
  if (finding.shortfall.empty() && std::abs(m.mean / before - 1) < 0.05)
    finding.shortfall = "the edit changed nothing";
  return finding;
}

Finding check_counted_nans(StressStage& stage, const Contestant& contestant) {
  Finding finding;
  Measured& m = finding.measured;
  StressRuns runs(stage, contestant);
  m.first_picture = runs.first_picture();
  const StressPicture picture = runs.run(0);
  m.runs = 1;
  m.nan_samples = picture.nan_samples, m.mean = mean_of(picture.image);
  const bool finite = std::all_of(picture.image.pixels.begin(), picture.image.pixels.end(),
                                  [](Vec3 p) { return is_finite(p); });
  if (m.nan_samples == 0 || !picture.first_nan)
    finding.shortfall = "a radiance that is not a number was not counted";
  else if (!finite)
    finding.shortfall = "the picture holds what is no number";
  return finding;
}

Finding check_variance_growth(StressStage& stage, const Contestant& contestant, double most) {
  Finding finding;
  Measured& m = finding.measured;
  const uint32_t count = std::max(2u, stage.run_counts(contestant.target).least);
  // Spread of each pixel over runs, relative to its mean.
  const auto variance = [&](bool of_truth) {
    StressRuns runs(stage, contestant, of_truth);
    if (!of_truth) describe(runs, contestant, m);
    double sum = 0, squares = 0;
    std::vector<double> pixel_sum, pixel_squares;
    for (uint32_t i = 0; i < count; ++i) {
      const StressPicture run = runs.run(i);
      const ImageRgb& picture = run.image;
      m.nan_samples += run.nan_samples;
      pixel_sum.resize(picture.pixels.size()), pixel_squares.resize(picture.pixels.size());
      for (size_t p = 0; p < picture.pixels.size(); ++p) {
        const double value = luminance(picture.pixels[p]);
        pixel_sum[p] += value, pixel_squares[p] += value * value;
      }
    }
    for (size_t p = 0; p < pixel_sum.size(); ++p) {
      const double mean = pixel_sum[p] / count;
      sum += mean * mean, squares += (pixel_squares[p] / count - mean * mean) * count / (count - 1);
    }
    return sum > 0 ? squares / sum * stage.samples() : infinity;
  };
  const double far = variance(true);
  m.variance = variance(false);
  m.runs = count;
  const double growth = m.variance / far;
  m.difference = growth;
  finding.shortfall = nan_shortfall(m.nan_samples);
  const bool bias = contestant.expectation.expected == Expected::bias;
  if (finding.shortfall.empty() && !bias && !(growth <= most))
    finding.shortfall =
        fmt::format("relative variance × samples grows {:.3g} times, {:g} is allowed", growth, most);
  if (finding.shortfall.empty() && bias && !(growth >= contestant.expectation.low))
    finding.shortfall = fmt::format("grows {:.3g} times only; at least {:g} was expected of it", growth,
                                    contestant.expectation.low);
  return finding;
}

}  // namespace halflight
