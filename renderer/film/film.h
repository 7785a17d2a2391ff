// Accumulation: two independent halves a pixel, so that the picture knows how wrong it still is.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/image.h"
#include "core/math.h"

namespace halflight {

/// Where a radiance came that was no number: a pixel, and which of its samples is the first that may be it
/// (from 0; a mean of several is added at once).
struct NanPlace {
  uint32_t pixel, sample;
  bool operator==(const NanPlace&) const = default;
};

/// Sums in double. Each pixel has two halves filled by independent draws; the picture is their weighted mean.
class Film {
 public:
  Film() = default;
  Film(int width, int height);

  int width() const { return width_; }
  int height() const { return height_; }

  /// Adds the mean of `samples` samples to a half (0 or 1) of a pixel. One thread a pixel at a time.
  /// A mean that is not finite becomes 0 and is counted.
  void add(uint32_t pixel, int half, Vec3 mean, uint32_t samples);

  /// Adds another film of the same size; the order of merges is the caller's to fix.
  void merge(const Film& other);
  void clear();

  uint32_t samples(uint32_t pixel) const { return pixels_[pixel].count[0] + pixels_[pixel].count[1]; }
  /// Samples of one half, and their mean; 0 where it has none.
  uint32_t half_samples(uint32_t pixel, int half) const { return pixels_[pixel].count[half]; }
  Vec3d half_mean(uint32_t pixel, int half) const;
  double mean_samples() const;
  Vec3 radiance(uint32_t pixel) const;
  ImageRgb image() const;
  /// The picture so far; pixels with no sample yet take the nearest coarser one that has some.
  ImageRgb preview() const;
  /// Variance of the pixel's mean, from the two halves: (A − B)² n_A n_B / (n_A + n_B)², which is (A − B)²/4
  /// where both have as many samples. 0 until both have some.
  Vec3 variance(uint32_t pixel) const;

  /// relMSE expected of the picture, mean(variance / (r² + (0.01 mean r)²)) over the pixels whose halves both
  /// have samples, r being the larger of what surrounds a pixel and its lesser half; negative while fewer
  /// than half of the pixels have both.
  double estimated_relmse() const;
  uint64_t nan_samples() const { return nan_samples_; }
  /// The first pixel, row by row, that had a sample which was not finite, and its first; nothing where there
  /// was none.
  std::optional<NanPlace> first_nan() const;
  Vec3 mean_radiance() const;

 private:
  struct Pixel {
    std::array<Vec3d, 2> sum{};
    std::array<uint32_t, 2> count{};

    bool has_both_halves() const { return count[0] > 0 && count[1] > 0; }
    Vec3d mean() const;
    Vec3d variance_of_mean() const;
    Vec3d lesser_half() const;  ///< both halves must have samples
  };
  struct RowSums {
    std::vector<Vec3d> sum;
    std::vector<int> count;
  };
  RowSums row_sums(int y) const;
  double row_relmse(int y, const RowSums& before, const RowSums& after, double floor2) const;

  int width_ = 0, height_ = 0;
  std::vector<Pixel> pixels_;
  static constexpr uint64_t nowhere = ~0ull;
  uint64_t nan_samples_ = 0;
  uint64_t first_nan_ = nowhere;  ///< pixel · 2³² + sample
};

}  // namespace halflight
