// Means of pictures over independent runs: whole picture, channels and tiles, and whether they are the truth.
#pragma once

#include <vector>

#include "film/film.h"

namespace halflight {

/// A picture in few numbers: its mean in each channel, then the mean of each tile over channels.
struct Marks {
  static constexpr int channels = 3, tile_columns = 4, tile_rows = 3;

  /// Tiles of a picture that has fewer pixels than tiles are left out.
  static std::vector<double> of(const ImageRgb&);
};

/// Running mean and variance of marks over runs (Welford 1962).
struct MarkStatistics {
  double runs = 0;
  std::vector<double> mean, squares;

  void add(const std::vector<double>& marks);
  double variance_of_mean(size_t mark) const;
};

/// Result of comparing means with a truth that may have noise of its own.
struct MeanTest {
  double z = 0;         ///< of the mean over channels: the largest of the three
  double interval = 0;  ///< widest of the channels' half-widths, over the truth's mean
  double worst = 0;     ///< largest |difference less tolerance| / (bound × deviation): above 1 it differs
  double worst_z = 0, bound = 0;
  double direction = 0;  ///< sign of the worst difference
};

/// Chance that a technique without bias is called wrong in a case.
inline constexpr double stress_level = 1e-4;

/// Differences up to `tolerance` × the larger of the mark's truth and the whole picture's are rounding and
/// not looked at; of a black truth up to `tolerance` itself.
MeanTest test_means(const MarkStatistics& found, const MarkStatistics& truth, double tolerance);

}  // namespace halflight
