#include "film/sample_allocation.h"

#include <algorithm>
#include <cmath>

#include "core/errors.h"
#include "core/parallel.h"

namespace halflight {

namespace {

// Radii of the windows whose variances are averaged: the small one follows edges, the large one has seen rare
// bright samples. Several sizes and weights did no better (docs/performance.md).
constexpr int radii[] = {1, 4};
// Least share of the mean number of samples, so that what the passes missed does not stay.
constexpr double least_share = 0.1;
// What a visit costs before its first sample, in samples: a pixel's part in a distribution that neighbours
// share.
constexpr double visit_cost = 6;
constexpr uint32_t least_visit = 8;
constexpr double least_scale = 1e-6, highest_scale = 1e9;

/// Mean over the square of `radius` around each pixel, the pixel itself left out.
std::vector<double> mean_of_others(const std::vector<double>& values, int width, int height, int radius) {
  std::vector<double> rows(values.size()), result(values.size());
  parallel_for(0, static_cast<size_t>(height), 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y)
      for (int x = 0; x < width; ++x) {
        double sum = 0;
        for (int i = std::max(0, x - radius); i <= std::min(width - 1, x + radius); ++i)
          sum += values[y * width + i];
        rows[y * width + x] = sum;
      }
  });
  parallel_for(0, static_cast<size_t>(height), 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      const int top = std::max(0, static_cast<int>(y) - radius),
                bottom = std::min(height - 1, static_cast<int>(y) + radius);
      for (int x = 0; x < width; ++x) {
        const size_t pixel = y * width + x;
        double sum = 0;
        for (int j = top; j <= bottom; ++j) sum += rows[static_cast<size_t>(j) * width + x];
        const int columns = std::min(width - 1, x + radius) - std::max(0, x - radius) + 1;
        const int others = columns * (bottom - top + 1) - 1;
        result[pixel] = others > 0 ? std::max(0.0, sum - values[pixel]) / others : 0.0;
      }
    }
  });
  return result;
}

double mean_of_channels(Vec3d v) { return (v.x + v.y + v.z) / 3; }

/// A mean over the pixels, `constant + slope · t` for as long as no pixel changes sides.
struct Line {
  double constant = 0, slope = 0;
};

/// Mean of what `add(i, sum)` adds over i below `count`, in one fixed order.
template <class Add>
Line mean_over(size_t count, const Add& add) {
  constexpr size_t piece = 4096;
  std::vector<Line> sums((count + piece - 1) / piece);
  parallel_for(0, sums.size(), 1, [&](size_t begin, size_t end) {
    for (size_t p = begin; p < end; ++p)
      for (size_t i = p * piece; i < std::min(count, (p + 1) * piece); ++i)
        add(static_cast<uint32_t>(i), sums[p]);
  });
  Line mean;
  for (const Line& sum : sums)
    mean.constant += sum.constant / static_cast<double>(count),
        mean.slope += sum.slope / static_cast<double>(count);
  return mean;
}

/// Samples a pixel, linear in t = scale; `root` is √e.
Line samples_line(const std::vector<double>& root, const Film& film, double scale) {
  return mean_over(root.size(), [&](uint32_t i, Line& sum) {
    const double done = film.samples(i);
    if (scale * root[i] > done)
      sum.slope += root[i];
    else
      sum.constant += done;
  });
}

/// relMSE expected, linear in t = 1/scale: √e t where a pixel gets more samples, e/n where it has enough.
Line error_line(const std::vector<double>& root, const Film& film, double inverse_scale) {
  return mean_over(root.size(), [&](uint32_t i, Line& sum) {
    const double done = film.samples(i);
    if (root[i] > done * inverse_scale)
      sum.slope += root[i];
    else
      sum.constant += root[i] * root[i] / done;
  });
}

/// The t at which a sum comes to `wanted` that is linear piece by piece, and bent the same way everywhere, by
/// Newton's method from an end at which all pixels slope: it comes to the piece that holds t, and ends there.
template <class LineAt>
double solve(double wanted, const LineAt& line_at, double t) {
  constexpr int most_steps = 50;
  constexpr double near = 1e-9;
  for (int i = 0; i < most_steps; ++i) {
    const Line line = line_at(t);
    if (!(line.slope > 0)) break;  // every pixel has more than enough
    const double next = std::max(0.0, (wanted - line.constant) / line.slope);
    if (std::abs(next - t) <= near * t) break;
    t = next;
  }
  return t;
}

}  // namespace

SampleAllocation::SampleAllocation(int width, int height) : width_(width), height_(height) {
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  sum_.resize(pixels, Vec3d(0));
  variance_.resize(pixels), root_.resize(pixels);
}

void SampleAllocation::learn(const Film& before, const Film& after) {
  ++passes_;
  const auto added = [&](uint32_t pixel, int half) {
    const uint32_t count = after.half_samples(pixel, half), old = before.half_samples(pixel, half);
    const Vec3d sum = after.half_mean(pixel, half) * static_cast<double>(count) -
                      before.half_mean(pixel, half) * static_cast<double>(old);
    return std::pair(sum, count - old);
  };
  samples_ += added(0, 0).second + added(0, 1).second;
  double picture = 0;
  for (uint32_t i = 0; i < sum_.size(); ++i) {
    const auto [a, count_a] = added(i, 0);
    const auto [b, count_b] = added(i, 1);
    HALFLIGHT_CHECK(count_a > 0 && count_b > 0);
    const double na = count_a, nb = count_b;
    const Vec3d apart = a / na - b / nb;
    variance_[i] += mean_of_channels(apart * apart) / (1 / na + 1 / nb);
    sum_[i] += a + b;
    picture += mean_of_channels(sum_[i]);
  }

  // Relative variance: of the windows' variance to the square of their brightness.
  const auto pixels = static_cast<double>(sum_.size()), samples = static_cast<double>(samples_);
  const double floor2 = std::pow(0.01 * picture / (pixels * samples), 2);
  std::vector<double> bright(sum_.size());
  for (size_t i = 0; i < bright.size(); ++i) bright[i] = mean_of_channels(sum_[i]) / samples;
  std::fill(root_.begin(), root_.end(), 0.0);
  for (const int radius : radii) {
    const std::vector<double> variance = mean_of_others(variance_, width_, height_, radius),
                              brightness = mean_of_others(bright, width_, height_, radius);
    for (size_t i = 0; i < root_.size(); ++i)
      if (const double scale = brightness[i] * brightness[i] + floor2; scale > 0)
        root_[i] += variance[i] / (passes_ * scale * std::size(radii));
  }
  double total = 0;
  for (double& root : root_) total += root = std::isfinite(root) ? std::sqrt(root) : 0.0;
  // Where there is no noise at all, all pixels are alike.
  const double least = total > 0 ? least_share * total / pixels : 1.0;
  for (double& root : root_) root = std::max(root, least);
}

double SampleAllocation::expected_relmse(const Film& film, double scale) const {
  const double inverse_scale = 1 / std::max(scale, least_scale);
  const Line line = error_line(root_, film, inverse_scale);
  return line.constant + line.slope * inverse_scale;
}

double SampleAllocation::scale_for_samples(const Film& film, double wanted) const {
  const double scale = solve(
      wanted, [&](double t) { return samples_line(root_, film, t); }, highest_scale);
  return std::clamp(scale, least_scale, highest_scale);
}

double SampleAllocation::scale_for_error(const Film& film, double wanted) const {
  const double inverse = solve(
      wanted, [&](double t) { return error_line(root_, film, t); }, 0);
  return std::clamp(1 / inverse, least_scale, highest_scale);
}

bool SampleAllocation::next_round(const Film& film, double scale, uint32_t most,
                                  std::vector<uint16_t>& samples) const {
  samples.assign(root_.size(), 0);
  bool any = false;
  for (uint32_t i = 0; i < root_.size(); ++i) {
    const double done = film.samples(i), wanted = scale * root_[i], lacking = wanted - done;
    // Of e/n with one more visit against what as much work brings elsewhere: (n − done)² > done · cost.
    if (!(lacking * lacking > done * visit_cost) || lacking < least_visit) continue;
    samples[i] = static_cast<uint16_t>(std::min<double>(lacking + 0.5, most));
    any = true;
  }
  return any;
}

}  // namespace halflight
