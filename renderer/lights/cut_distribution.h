// A distribution over the clusters of a cut, and stratified draws of leaves from it.
#pragma once

#include <span>
#include <vector>

#include "core/random.h"
#include "lights/light_tree.h"

namespace halflight {

/// A light drawn with its weight: E[weight · 1{light = i}] = 1 for every light that can matter.
struct LightSample {
  uint32_t light;  ///< position in the tree's order
  float weight;    ///< 1 / (P(light)); the average over N draws estimates the sum over S
};

/// Scratch memory for one thread; reused from pixel to pixel without allocation.
class CutDistribution {
 public:
  /// Importance per cluster to fill before `build`; at least `padded_size` floats.
  std::span<float> importance(const Cut&);

  /// Prefix sums of the importances, mixed with the guard: q = (1 − α) q̂/Σq̂ + α u, u_k ∝ guard_k; q = u where Σq̂ = 0
  /// or not finite. Returns false when nothing can be drawn (no power).
  bool build(const Cut&, std::span<const float> guard, float alpha);

  /// Probability of cluster k: the difference of the prefix sums the search uses.
  double cluster_probability(uint32_t k) const;

  /// P(i) of a leaf: cluster probability × Φ_i / Φ_k, from the rounded differences the search uses.
  double probability(const LightTree&, const Cut&, uint32_t k, uint32_t leaf) const;

  /// N stratified draws u_j = (j + ξ_j)/N along the leaves in tree order, written to `out` (N = out.size()).
  void draw(const LightTree&, const Cut&, RandomStream&, std::span<LightSample> out) const;

 private:
  std::vector<float> importance_;
  std::vector<double> prefix_;
};

/// The guard u_k ∝ Φ_k/(r_k² + R_k²), at infinity Φ_k, each kind normalised to its share of Σ Φ-weights at x.
void guard_importance(const Cut&, Vec3 x, std::span<float> out);

}  // namespace halflight
