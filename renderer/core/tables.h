// Piecewise-constant distributions over tables of non-negative weights.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/math.h"

namespace halflight {

/// Discrete distribution over n weights. P(i) is the difference of the very prefix sums the search uses, so that the
/// probabilities add to one exactly and no drawn entry has probability zero.
class DiscreteTable {
 public:
  DiscreteTable() = default;
  /// `weights` must be finite and ≥ 0; all zero gives a table with `empty()`.
  explicit DiscreteTable(std::span<const float> weights);

  bool empty() const { return total_ <= 0; }
  double total() const { return total_; }
  size_t size() const { return prefix_.empty() ? 0 : prefix_.size() - 1; }
  double probability(size_t i) const { return (prefix_[i + 1] - prefix_[i]) / total_; }

  struct Draw {
    uint32_t index;
    float probability;
    float residual;  ///< uniform in [0, 1) given the index; reusable as a random number
  };
  /// Entry for u in [0, 1). The table must not be empty.
  Draw draw(float u) const;

 private:
  std::vector<double> prefix_;
  std::vector<uint32_t> guide_;  ///< the entry in which each of 2ᵏ equal shares begins (Chen & Asau 1974)
  double total_ = 0;
};

/// Piecewise-constant density on the unit square, rows × columns cells (marginal over rows, conditional in a row).
class PlaneTable {
 public:
  PlaneTable() = default;
  PlaneTable(std::span<const float> weights, int columns, int rows);

  bool empty() const { return marginal_.empty(); }
  double total() const { return marginal_.total(); }

  struct Draw {
    Vec2 position;  ///< in the unit square, x along a row
    float pdf;      ///< per unit area of the square
    uint32_t cell;  ///< row * columns + column
  };
  Draw draw(Vec2 u) const;
  /// Density at a point of the unit square, the one `draw` uses.
  float pdf(Vec2 position) const;

 private:
  int columns_ = 0, rows_ = 0;
  DiscreteTable marginal_;
  std::vector<DiscreteTable> conditional_;
};

}  // namespace halflight
