// Walks down the light tree, several samples at a time: what light-bvh and stochastic-lightcuts share.
//
// Two levels of the tree's binary nodes make one node here, whose up to four children are weighed together;
// children without light are left out. The importance of a child is
//   I_c = Φ cos θ' cos θ / max(r², R²)   (bounded geometry: + A cos θ'/2π below; at infinity: no division)
// with bounds on the cosines at light and point (Conty Estevez & Kulla 2018, eq. 3), 0 only where no point of
// its box with no normal of its cone can send light; times a bound on the BRDF where the point has one. The
// bounds are the box's, not its sphere's: a flat box in the point's own plane gives nothing, however near it
// is. A child's probability is
//   p_c = (1 − β) I_c/ΣI + β g_c,   g_c = ½ Φ_c/ΣΦ + ½/children   (at the root, over kinds: 1/kinds),
// g alone where ΣI is 0 or not finite; P(i) is the product along the way. As β = 2⁻¹⁰ and g_c ≥ 1/8, every
// branch has p_c ≥ 2⁻¹³, and every lit leaf P > 0.
//
// One number in [0, 1) takes a sample all the way: the branch's share of it is stretched to [0, 1) again.
// Numbers have 53 bits, and a branch taken with probability p uses up log2(1/p) of them; where fewer than 40
// are left the number is drawn anew, so that each branch keeps its probability to 2⁻²⁷ of it. Strata are lost
// only below nodes less likely than 2⁻¹³, where a sample is alone unless N is in the thousands.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/random.h"
#include "lights/cut_distribution.h"
#include "lights/light_tree.h"
#include "scene/gbuffer.h"

namespace halflight {

/// Up to four children as arrays; four cache lines.
struct alignas(64) WalkNode {
  static constexpr int width = 4;

  float centre_x[width], centre_y[width], centre_z[width];  ///< of the box
  float extent_x[width], extent_y[width], extent_z[width];  ///< half its size
  float axis_x[width], axis_y[width], axis_z[width];        ///< of the cone of normals, unit
  float cos_cone[width];  ///< of half its angle; -1 where emission does not depend on a normal
  float power[width];     ///< Φ in units of the tree's
  float measure[width];   ///< A; 0 for distant and punctual light
  float local[width];     ///< 0 at infinity
  float guard[width];     ///< g; 0 where there is no child
  int32_t child[width];   ///< another node, or ~leaf
  uint32_t begin[width];  ///< first leaf
};

/// The tree as walks see it; made when lights change.
struct WalkTree {
  std::vector<WalkNode> nodes;  ///< the root first; empty when nothing is lit

  /// `power_unit` brings powers into the range of floats.
  void build(const LightTree&, double power_unit);
};

/// The specular lobe as a bound on its value: peak/(1 + sharpness (1 − c))², c the cosine with the mirror
/// direction.
struct LobeBound {
  Vec3 axis;
  float diffuse;  ///< luminance of k_d/π
  float peak, sharpness;
};

LobeBound lobe_bound(const GBufferTexel&);

/// The shaded point as importances need it.
struct WalkPoint {
  Vec3 x, normal;
  float softening;  ///< 1/2π for the bounded geometry term, 0 for the exact one
  bool has_lobe = false;
  LobeBound lobe{};
};

/// What each child may send at most, to within the rounding of the cosines' bounds: its importance, `lobe`
/// included, with the least distance its sphere allows instead of that to the centre.
void bound_children(const WalkNode&, const WalkPoint&, float* bound);

/// Scratch of one thread.
class LightWalk {
 public:
  /// Begins anew: samples are to be written to `out`.
  void start(std::span<LightSample> out);
  /// The next `count` samples enter at `node` (or ~leaf), stratified among themselves; `share` is the part of
  /// all samples they are.
  void enter(const WalkTree&, int32_t node, uint32_t count, double share, RandomStream&);
  /// Takes all samples to their leaves, in the order of the tree where entries were.
  void finish(const WalkTree&, const WalkPoint&, RandomStream&);

 private:
  struct Step {
    int32_t node;
    uint32_t begin, end;  ///< samples
    double probability;   ///< of coming here, times the entry's share
    double used;          ///< probability since the numbers were drawn
  };

  void go(const WalkTree&, const Step&);
  void renew(Step&, RandomStream&);
  void take_one(const WalkTree&, const Step&, const double* p);
  void split(const WalkTree&, const Step&, const double* p);

  std::span<LightSample> out_;
  uint32_t entered_ = 0;
  std::vector<double> number_;
  size_t step_count_ = 0;
  std::vector<Step> steps_;     ///< level after level; the first step_count_ count
  std::vector<int32_t> nodes_;  ///< theirs
  std::vector<std::array<double, WalkNode::width>> branch_;  ///< p of a level's steps
};

/// Probability of `leaf` among walks that start at `node`; the same product as walks make of it. 0 where it
/// is not below.
double walk_probability(const WalkTree&, const WalkPoint&, int32_t node, uint32_t leaf, double share);

}  // namespace halflight
