#include "film/film.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <numeric>
#include <utility>

#include "core/errors.h"
#include "core/parallel.h"

namespace halflight {

Film::Film(int width, int height)
    : width_(width), height_(height), pixels_(static_cast<size_t>(width) * static_cast<size_t>(height)) {}

void Film::add(uint32_t pixel, int half, Vec3 mean, uint32_t samples) {
  Pixel& p = pixels_[pixel];
  const uint64_t place = uint64_t{pixel} << 32 | (p.count[0] + p.count[1]);
  p.count[half] += samples;
  if (is_finite(mean)) {
    p.sum[half] += Vec3d(mean) * static_cast<double>(samples);
    return;
  }
  std::atomic_ref(nan_samples_).fetch_add(samples, std::memory_order_relaxed);
  std::atomic_ref first(first_nan_);
  uint64_t known = first.load();
  while (place < known && !first.compare_exchange_weak(known, place)) {
  }
}

std::optional<NanPlace> Film::first_nan() const {
  if (first_nan_ == nowhere) return {};
  return NanPlace{static_cast<uint32_t>(first_nan_ >> 32), static_cast<uint32_t>(first_nan_)};
}

void Film::merge(const Film& other) {
  HALFLIGHT_CHECK(other.width_ == width_ && other.height_ == height_);
  for (size_t i = 0; i < pixels_.size(); ++i) {
    for (int half = 0; half < 2; ++half) {
      pixels_[i].sum[half] += other.pixels_[i].sum[half];
      pixels_[i].count[half] += other.pixels_[i].count[half];
    }
  }
  nan_samples_ += other.nan_samples_;
  first_nan_ = std::min(first_nan_, other.first_nan_);
}

void Film::clear() {
  std::fill(pixels_.begin(), pixels_.end(), Pixel{});
  nan_samples_ = 0;
  first_nan_ = nowhere;
}

Vec3d Film::half_mean(uint32_t pixel, int half) const {
  const Pixel& p = pixels_[pixel];
  return p.count[half] > 0 ? p.sum[half] / static_cast<double>(p.count[half]) : Vec3d(0);
}

double Film::mean_samples() const {
  double sum = 0;
  for (const Pixel& p : pixels_) sum += static_cast<double>(p.count[0]) + p.count[1];
  return pixels_.empty() ? 0 : sum / static_cast<double>(pixels_.size());
}

Vec3 Film::radiance(uint32_t pixel) const {
  const Pixel& p = pixels_[pixel];
  const double count = static_cast<double>(p.count[0]) + p.count[1];
  return count > 0 ? Vec3((p.sum[0] + p.sum[1]) / count) : Vec3(0);
}

ImageRgb Film::image() const {
  ImageRgb image(width_, height_);
  for (uint32_t i = 0; i < pixels_.size(); ++i) image.pixels[i] = radiance(i);
  return image;
}

ImageRgb Film::preview() const {
  ImageRgb image(width_, height_);
  parallel_for(0, static_cast<size_t>(height_), 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y) {
      for (size_t x = 0; x < static_cast<size_t>(width_); ++x) {
        // The pixel itself, else the corner of the 2×2 or 4×4 block it stands in: those are sampled first.
        const size_t places[] = {y * width_ + x, (y & ~size_t{1}) * width_ + (x & ~size_t{1}),
                                 (y & ~size_t{3}) * width_ + (x & ~size_t{3})};
        for (const size_t place : places) {
          if (samples(static_cast<uint32_t>(place)) == 0) continue;
          image.pixels[y * width_ + x] = radiance(static_cast<uint32_t>(place));
          break;
        }
      }
    }
  });
  return image;
}

Vec3d Film::Pixel::mean() const { return (sum[0] + sum[1]) / (static_cast<double>(count[0]) + count[1]); }

Vec3d Film::Pixel::variance_of_mean() const {
  const double a = count[0], b = count[1];
  const Vec3d difference = sum[0] / a - sum[1] / b;
  return difference * difference * (a * b / ((a + b) * (a + b)));
}

Vec3d Film::Pixel::lesser_half() const {
  return glm::min(sum[0] / static_cast<double>(count[0]), sum[1] / static_cast<double>(count[1]));
}

Vec3 Film::variance(uint32_t pixel) const {
  const Pixel& p = pixels_[pixel];
  if (!p.has_both_halves()) return Vec3(0);
  return Vec3(glm::min(p.variance_of_mean(), Vec3d(std::numeric_limits<float>::max())));
}

/// Of each pixel of a row, the sum of means of it and its neighbours in the row that have both halves, and
/// how many they are. Rows outside of the picture have none.
Film::RowSums Film::row_sums(int y) const {
  RowSums sums{std::vector<Vec3d>(static_cast<size_t>(width_), Vec3d(0)),
               std::vector<int>(static_cast<size_t>(width_), 0)};
  if (y < 0 || y >= height_) return sums;
  const Pixel* row = &pixels_[static_cast<size_t>(y) * width_];
  for (int x = 0; x < width_; ++x) {
    if (!row[x].has_both_halves()) continue;
    const Vec3d mean = row[x].mean();
    for (int i = std::max(x - 1, 0); i <= std::min(x + 1, width_ - 1); ++i)
      sums.sum[i] += mean, ++sums.count[i];
  }
  return sums;
}

/// Σ of relative variances of a row's pixels, between the sums of the row before and of the next.
double Film::row_relmse(int y, const RowSums& before, const RowSums& after, double floor2) const {
  const Pixel* row = &pixels_[static_cast<size_t>(y) * width_];
  double sum = 0;
  for (int x = 0; x < width_; ++x) {
    const Pixel& p = row[x];
    if (!p.has_both_halves()) continue;
    Vec3d near = before.sum[x] + after.sum[x];
    int others = before.count[x] + after.count[x];
    for (const int i : {x - 1, x + 1})
      if (i >= 0 && i < width_ && row[i].has_both_halves()) near += row[i].mean(), ++others;
    // Measured against what is around it or what both halves agree on: a pixel far off in one of them would
    // make its own error look small, and a bright detail in the dark would make it look large.
    const Vec3d surrounding = others > 0 ? near / static_cast<double>(others) : p.mean();
    const Vec3d variance = p.variance_of_mean(), r = glm::max(surrounding, p.lesser_half());
    const Vec3d scale = r * r + floor2;
    for (int c = 0; c < 3; ++c)
      if (scale[c] > 0) sum += variance[c] / scale[c] / 3;
  }
  return sum;
}

double Film::estimated_relmse() const {
  const auto rows = static_cast<size_t>(height_);
  std::vector<double> row_mean(rows, 0), row_sum(rows, 0);
  std::vector<size_t> row_pairs(rows, 0);
  constexpr size_t rows_at_once = 16;
  parallel_for(0, rows, rows_at_once, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y)
      for (size_t x = 0; x < static_cast<size_t>(width_); ++x) {
        const Pixel& p = pixels_[y * static_cast<size_t>(width_) + x];
        if (!p.has_both_halves()) continue;
        const Vec3d mean = p.mean();
        row_mean[y] += (mean.x + mean.y + mean.z) / 3, ++row_pairs[y];
      }
  });
  const size_t pairs = std::accumulate(row_pairs.begin(), row_pairs.end(), size_t{0});
  // A few pixels that are ahead of the rest say nothing of the picture.
  if (pairs == 0 || 2 * pairs < pixels_.size()) return -1;
  const double picture_mean =
      std::accumulate(row_mean.begin(), row_mean.end(), 0.0) / static_cast<double>(pairs);
  const double floor2 = 1e-4 * picture_mean * picture_mean;
  parallel_for(0, rows, rows_at_once, [&](size_t begin, size_t end) {
    const int first = static_cast<int>(begin);
    RowSums before = row_sums(first - 1), own = row_sums(first);
    for (int y = first; y < static_cast<int>(end); ++y) {
      RowSums after = row_sums(y + 1);
      row_sum[static_cast<size_t>(y)] = row_relmse(y, before, after, floor2);
      before = std::exchange(own, std::move(after));
    }
  });
  return std::accumulate(row_sum.begin(), row_sum.end(), 0.0) / static_cast<double>(pairs);
}

Vec3 Film::mean_radiance() const {
  Vec3d sum(0);
  for (uint32_t i = 0; i < pixels_.size(); ++i) sum += Vec3d(radiance(i));
  return pixels_.empty() ? Vec3(0) : Vec3(sum / static_cast<double>(pixels_.size()));
}

}  // namespace halflight
