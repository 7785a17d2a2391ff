// The light of `halflight`: strata fixed by geometry, a tree and a cut over them whose powers come from a
// pilot set, and the set that is drawn afresh each round. The weights of the balance heuristic never depend
// on the set in hand, so that a light sample and a BRDF ray which meets the same light share it in full
// (ESTIMATORS: "Continuous mode"); which leaf of a cluster is drawn may.
#pragma once

#include <array>
#include <optional>
#include <utility>

#include "lights/cut_distribution.h"
#include "lights/light_strata.h"
#include "techniques/traced_light.h"

namespace halflight {

class LearnedLights {
 public:
  static constexpr uint32_t none = LightStrata::none;

  /// Makes strata, pilot sets, tree and cut for the frame's scene and kinds of light; `pilot_rays` light a
  /// stratum in all sets of the pilot together. With `punctual_clusters` each punctual light is a cluster of
  /// its own as far as the cut may go; the environment has at least `environment_clusters`, as far. Rays and
  /// stages are counted in the pass.
  LearnedLights(const FrameView&, uint32_t pilot_rays, bool punctual_clusters, uint32_t environment_clusters,
                PassStats&);

  /// Takes what the set in hand has shown into the powers of later rounds; that set is done with.
  void learn();
  /// What rounds have taught is forgotten; the pilot sets stay.
  void forget();
  /// Draws the set of a round, its points lit by `rays_a_point` rays.
  void draw_set(const FrameView&, uint64_t round, uint32_t rays_a_point, PassStats&);

  void count_held(const FrameView&, StageCounters&) const;

  const LightSources& sources() const { return sources_; }
  const LightTree& tree() const { return tree_; }
  const Cut& cut() const { return cut_; }
  /// The same clusters, their leaves to be drawn by what the set in hand sends.
  const Cut& drawn() const { return drawn_; }
  /// Probability of a leaf in its cluster by what was learned, over that of being drawn. Light samples are
  /// multiplied by it and weighed as if drawn with the former: weights of the balance heuristic must not know
  /// the set in hand, probabilities of draws may.
  float learned_over_drawn(uint32_t leaf) const { return learned_over_drawn_[leaf]; }
  uint32_t point_count() const { return strata_.surface_count(); }
  /// The set in hand, in the order of the cut's leaves.
  const VirtualLight& light(uint32_t leaf) const { return lights_[leaf]; }
  /// The cut's cluster that holds a leaf; `none` where the leaf has no power.
  uint32_t cluster_of(uint32_t leaf) const { return cluster_of_[leaf]; }
  /// Whether BRDF rays find light of the leaf too.
  bool met_by_rays(uint32_t leaf) const { return tree_.original[leaf] < strata_.punctual_begin(); }

  /// The leaf of what a ray met; points have the density 1/measure in its stratum. Nothing where there is no
  /// stratum.
  struct Met {
    uint32_t leaf;
    float measure;
  };
  std::optional<Met> met_environment(glm::ivec2 texel) const;
  std::optional<Met> met_emitter(SurfacePoint, bool front) const;
  std::optional<Met> met_surface(SurfacePoint, bool front) const;

 private:
  /// What each stratum was seen to send: the sum of grey radiances of its points in so many sets.
  struct Seen {
    std::vector<float> radiance;
    uint32_t sets = 0;
  };

  void see(std::span<const VirtualLight> set, Seen&) const;
  void use_powers();
  void draw_by_set();
  std::vector<VirtualLight> draw(const FrameView&, uint64_t seed, uint32_t rays_a_point, RayCounters&) const;
  std::optional<Met> met(uint32_t stratum, float measure) const;
  /// How many of a set each stage places.
  std::array<std::pair<Stage, uint32_t>, light_kind_count> members() const;

  LightSources sources_;
  LightStrata strata_;
  LightTree tree_;
  Cut cut_, drawn_;
  std::vector<uint32_t> leaf_of_;     ///< of each stratum
  std::vector<uint32_t> cluster_of_;  ///< of each leaf
  std::vector<VirtualLight> lights_;
  std::vector<float> learned_over_drawn_, leaf_weight_;  ///< of each leaf
  Seen pilot_, seen_;
};

}  // namespace halflight
