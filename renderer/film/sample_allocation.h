// Adaptive sampling: how many samples each pixel is to have, so that the picture's relMSE falls soonest.
//
// With e a pixel's relative variance of one sample, n samples there leave e/n: for a given sum of n, Σ e/n is
// least where n ∝ √e (Neyman 1934, optimal allocation). What a pixel gets is decided by its neighbours, from
// passes in which every pixel has as many samples, and by sums over the whole picture, in which it is one of
// many: but for those its own samples are independent of their number, and their mean stays unbiased. A
// number of samples that a pixel's own samples decide would not do (ESTIMATORS: "a mean whose weights depend
// on data is biased"). Nor does this in the continuous target, where neighbours of a round share S:
// docs/performance.md has that bias measured.
#pragma once

#include <cstdint>
#include <vector>

#include "film/film.h"

namespace halflight {

class SampleAllocation {
 public:
  SampleAllocation() = default;
  SampleAllocation(int width, int height);

  /// What `after` has beyond `before` is one more uniform pass: at every pixel as many samples, in both
  /// halves.
  void learn(const Film& before, const Film& after);

  // A scale λ stands for a picture: max(samples so far, λ √e) samples at each pixel.

  /// The scale whose picture has so many samples a pixel on average.
  double scale_for_samples(const Film&, double mean_samples) const;
  /// The scale whose picture is expected to have this relMSE.
  double scale_for_error(const Film&, double relmse) const;

  /// relMSE expected of a scale's picture; of the picture so far: 0.
  double expected_relmse(const Film&, double scale) const;

  /// Samples that each pixel gets in the next round towards a scale: none, or a number up to `most`. True
  /// where any gets some. A visit costs as much as several samples: pixels wait until they lack enough to be
  /// worth one.
  bool next_round(const Film&, double scale, uint32_t most, std::vector<uint16_t>& samples) const;

 private:
  int width_ = 0, height_ = 0;
  uint32_t passes_ = 0;           ///< learned from
  uint64_t samples_ = 0;          ///< a pixel, of those passes
  std::vector<Vec3d> sum_;        ///< of those samples
  std::vector<double> variance_;  ///< of a sample, mean over channels, summed over the passes
  std::vector<double> root_;      ///< √e
};

}  // namespace halflight
