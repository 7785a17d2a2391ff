// The distribution over a cut that knows the BRDF: an analytic product with the lobe's counted rays mixed in
// (ESTIMATORS: "Repaired form"). Over the illumination cut it is Wang & Åkerlund's bidirectional sampling,
// over a cut of equal radiances BRDF sampling alone.
#pragma once

#include <memory>

#include "lights/cut_counting.h"
#include "lights/cut_distribution.h"
#include "lights/tile_cut.h"
#include "scene/gbuffer.h"
#include "techniques/shared_distribution.h"
#include "techniques/technique.h"

namespace halflight {

struct CountedCutParameters {
  uint32_t ray_count;   ///< N_ρ; at most RayBundle::capacity
  float tau;            ///< weight of the analytic estimate, in rays
  float alpha;          ///< share of draws that ignore the BRDF
  bool share = false;   ///< whether neighbours that are alike draw from one distribution
  bool always = false;  ///< counts on lobes of every width, and where there is none (benchmarks)
};

/// Counting rays that the plan leaves out are none.
CountedCutParameters planned(const FrameView&, CountedCutParameters);

/// `ray_count` directions of the specular lobe; those below the horizon are lost, as their light is.
void shoot_lobe_rays(const GBufferTexel&, uint32_t ray_count, RandomStream&, RayBundle&);

/// A LightSampler (techniques/pixel_loop.h): q̂_k = l_k [k_s ŝ_k + (k_d/π) cos θ_k Ω_k], ŝ_k = (N_k + τ
/// g_k)/(N_ρ + τ), g_k > 0 the lobe's analytic mass in the cluster; a ray that meets m boxes adds 1/m to
/// each; q = (1 − α) q̂/Σq̂ + α u, u_k ∝ Φ_k/(r_k² + R_k²); leaves ∝ Φ_i. With α > 0 no lit leaf has
/// probability 0, for no pixel: pixels that are alike can share a distribution.
class CountedCut {
 public:
  /// The cut must outlive it.
  CountedCut(const Cut&, const CountedCutParameters&);
  /// Splits clusters that reach further than `most_reach` of their distance to the pixels in hand.
  CountedCut(const LightTree&, const Cut&, const CountedCutParameters&, float most_reach);

  void begin_group(const PointGroup& points);
  /// Whether neighbours can share a distribution at all. Without the guard a cluster that sends nothing to
  /// the one would be lost to the other.
  bool shares() const { return parameters_.share && parameters_.alpha > 0; }
  /// Whether the distribution made for one of two neighbouring points serves the other.
  bool serves(const GBufferTexel& one, const GBufferTexel& other) const;
  bool begin_pixel(const GBufferTexel& texel, RandomStream& random) {
    return begin_pixels({texel, {}}, random);
  }
  bool begin_pixels(const SharedPoint&, RandomStream&);
  void draw(RandomStream& random, std::span<LightSample> out) const {
    distribution_.draw(*cut_, random, out);
  }
  const Cut& cut() const { return *cut_; }
  const CutDistribution& distribution() const { return distribution_; }
  void count_stages(StageCounters&) const;

 private:
  bool counts(const GBufferTexel&) const;

  std::unique_ptr<TileCut> tile_cut_;  ///< null where nothing is split
  const Cut* cut_;
  CountedCutParameters parameters_;
  float most_reach_ = 0;
  CutDistribution distribution_;
  ClusterCounter counter_;
  RayBundle rays_;
  std::vector<float> guard_, arriving_;
  uint64_t counted_rays_ = 0, refined_blocks_ = 0;
};

}  // namespace halflight
