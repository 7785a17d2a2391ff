// A distribution over the clusters of a cut, and stratified draws of leaves from it.
#pragma once

#include <span>
#include <vector>

#include "core/random.h"
#include "lights/light_tree.h"

namespace halflight {

/// A light drawn with its weight: E[weight · 1{light = i}] = 1 for every light that can matter.
struct LightSample {
  uint32_t light;        ///< position in the tree's order
  float weight;          ///< 1 / P(light); the average over N draws estimates the sum over S
  uint32_t cluster = 0;  ///< of the cut, where it was drawn from one
};

/// How a leaf is chosen inside its cluster: ∝ Φ_i, or each alike (Wang & Åkerlund §3.2).
enum class LeafRule { by_power, uniform };

/// Probabilities over clusters, for one thread; reused from pixel to pixel without allocation. Shares are
/// whole numbers with a sum near 2^40, so that every sum of them is exact, ΣP = 1 and P is what the search
/// really gives.
class CutDistribution {
 public:
  /// Importance per cluster to fill before `build`: `padded_size` floats, ≥ 0. What lies past `size` is
  /// ignored.
  std::span<float> importance(const Cut&);

  /// Mixes the importances with the guard: q = (1 − α) q̂/Σq̂ + α u, u_k ∝ guard_k; q = u where Σq̂ = 0 or not
  /// finite. With α > 0 every cluster keeps a probability above 0; with α = 0 (no guard needed) the zeros of
  /// q̂ stay. Returns false when nothing can be drawn.
  bool build(const Cut&, std::span<const float> guard, float alpha, LeafRule rule = LeafRule::by_power);

  /// Probability of cluster k.
  double cluster_probability(uint32_t k) const;

  /// P(i) of a leaf of cluster k.
  double probability(const Cut&, uint32_t k, uint32_t leaf) const;

  /// The weight a draw of the leaf gets.
  float weight(const Cut&, uint32_t k, uint32_t leaf) const;

  /// N stratified draws u_j = (j + ξ_j)/N along the leaves in tree order, written to `out` (N = out.size()).
  void draw(const Cut&, RandomStream&, std::span<LightSample> out) const;

 private:
  double cluster_share(uint32_t k) const;
  void make_guide();

  std::vector<float> importance_;
  std::vector<double> share_;      ///< running sum inside each block of 16 clusters
  std::vector<double> block_end_;  ///< running sum over blocks
  /// Where the search for a sum's block starts, for each of as many slots of equal share as there are blocks
  /// (Chen & Asau 1974).
  std::vector<uint32_t> guide_;
  double slots_per_share_ = 0, total_ = 0;
  LeafRule rule_ = LeafRule::by_power;
};

}  // namespace halflight
