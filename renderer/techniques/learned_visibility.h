// How much of what each cluster sends arrives in each part of the picture, learned from the light samples of
// earlier rounds (ESTIMATORS: "Learned visibility"). It steers draws only: what it says of a round is known
// to later rounds.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/vector_bytes.h"

namespace halflight {

/// Light samples of one cluster, drawn and arrived, in one tile.
struct VisibilityCount {
  uint16_t drawn = 0, arrived = 0;
};

class LearnedVisibility {
 public:
  static constexpr uint32_t side = 16;  ///< of a tile, in pixels

  LearnedVisibility() = default;
  /// `clusters`: padded size of the cut.
  LearnedVisibility(int width, int height, size_t clusters);

  bool fits(int width, int height, size_t clusters) const {
    return width == width_ && height == height_ && clusters == clusters_;
  }
  uint32_t tile_of(uint32_t pixel) const {
    const uint32_t width = static_cast<uint32_t>(width_), x = pixel % width, y = pixel / width;
    return y / side * columns_ + x / side;
  }
  size_t held_bytes() const { return vector_bytes(pending_, known_); }
  /// What this round finds; one thread writes to a tile.
  std::span<VisibilityCount> pending(uint32_t tile) {
    return {pending_.data() + tile * clusters_, clusters_};
  }
  /// Between rounds: what was pending is known from now on.
  void publish();
  void forget();
  /// max(least, √v̂) of each cluster, v̂ = (a₀ v₀ + arrived)/(a₀ + drawn) over the 3×3 tiles around; v₀ is that
  /// of all clusters together.
  void factors(uint32_t tile, std::span<float> out) const;

 private:
  int width_ = 0, height_ = 0;
  uint32_t columns_ = 0, rows_ = 0;
  size_t clusters_ = 0;
  bool knows_ = false;
  std::vector<VisibilityCount> pending_, known_;
};

}  // namespace halflight
