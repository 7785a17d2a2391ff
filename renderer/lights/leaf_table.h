// One distribution over all leaves for very many draws: an inverted running sum with a guide.
#pragma once

#include <span>
#include <vector>

#include "core/random.h"
#include "lights/cut_distribution.h"

namespace halflight {

/// P(i) as whole numbers with a sum near 2^40, so that P is what the search really gives.
class LeafTable {
 public:
  /// Of a distribution over a cut of `leaves` leaves; `drawable` false empties the table.
  void build(const Cut&, const CutDistribution&, uint32_t leaves, bool drawable);
  bool drawable() const { return total_ > 0; }

  double probability(uint32_t leaf) const;
  float weight(uint32_t leaf) const { return entries_[leaf].weight; }

  /// Stratified draws u_j = (j + ξ_j)/N, in the order of the leaves.
  void draw(RandomStream&, std::span<LightSample> out) const;

 private:
  /// What belongs to a leaf, and to the slot of the guide of that number: for even light they are neighbours.
  struct Entry {
    double end = 0;      ///< running sum after the leaf
    float weight = 0;    ///< 1/P; 0 where P is 0
    uint32_t guide = 0;  ///< first leaf that can hold the sum at (slot + ξ)/leaves (Chen & Asau 1974)
  };

  std::vector<Entry> entries_;
  double total_ = 0;
};

}  // namespace halflight
