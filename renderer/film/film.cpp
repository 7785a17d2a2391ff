#include "film/film.h"

#include <algorithm>
#include <atomic>

#include "core/errors.h"
#include "core/parallel.h"

namespace halflight {

Film::Film(int width, int height)
    : width_(width), height_(height), pixels_(static_cast<size_t>(width) * static_cast<size_t>(height)) {}

void Film::add(uint32_t pixel, int half, Vec3 mean, uint32_t samples) {
  Pixel& p = pixels_[pixel];
  p.count[half] += samples;
  if (is_finite(mean)) {
    p.sum[half] += Vec3d(mean) * static_cast<double>(samples);
    return;
  }
  std::atomic_ref(nan_samples_).fetch_add(samples, std::memory_order_relaxed);
  std::atomic_ref first(first_nan_pixel_);
  uint32_t known = first.load();
  while (pixel < known && !first.compare_exchange_weak(known, pixel)) {
  }
}

std::optional<uint32_t> Film::first_nan_pixel() const {
  if (first_nan_pixel_ == no_pixel) return {};
  return first_nan_pixel_;
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
  first_nan_pixel_ = std::min(first_nan_pixel_, other.first_nan_pixel_);
}

void Film::clear() {
  std::fill(pixels_.begin(), pixels_.end(), Pixel{});
  nan_samples_ = 0;
  first_nan_pixel_ = no_pixel;
}

uint32_t Film::samples(uint32_t pixel) const { return pixels_[pixel].count[0] + pixels_[pixel].count[1]; }

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

Vec3 Film::variance(uint32_t pixel) const {
  const Pixel& p = pixels_[pixel];
  if (p.count[0] == 0 || p.count[1] == 0) return Vec3(0);
  const Vec3d difference =
      p.sum[0] / static_cast<double>(p.count[0]) - p.sum[1] / static_cast<double>(p.count[1]);
  return Vec3(difference * difference * 0.25);
}

double Film::estimated_relmse() const {
  const Vec3d mean(mean_radiance());
  const double floor2 = std::pow(0.01 * (mean.x + mean.y + mean.z) / 3, 2);
  double sum = 0;
  size_t pairs = 0;
  for (const Pixel& p : pixels_) {
    if (p.count[0] == 0 || p.count[1] == 0) continue;
    const Vec3d a = p.sum[0] / static_cast<double>(p.count[0]),
                b = p.sum[1] / static_cast<double>(p.count[1]);
    ++pairs;
    for (int c = 0; c < 3; ++c) {
      const double difference = a[c] - b[c], r = 0.5 * (a[c] + b[c]), scale = r * r + floor2;
      if (scale > 0) sum += 0.25 * difference * difference / scale / 3;
    }
  }
  return pairs > 0 ? sum / static_cast<double>(pairs) : -1;
}

Vec3 Film::mean_radiance() const {
  Vec3d sum(0);
  for (uint32_t i = 0; i < pixels_.size(); ++i) sum += Vec3d(radiance(i));
  return pixels_.empty() ? Vec3(0) : Vec3(sum / static_cast<double>(pixels_.size()));
}

}  // namespace halflight
