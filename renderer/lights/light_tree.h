// The light tree and the illumination cut (Wang & Åkerlund §3.2): binary trees over S, one a kind, in one
// array.
#pragma once

#include <array>
#include <memory>
#include <span>
#include <vector>

#include "core/math.h"
#include "lights/virtual_light.h"

namespace halflight {

/// A node covers the leaves [begin, end) of the tree's order. Leaves of the tree are nodes with end = begin
/// + 1.
struct LightNode {
  Vec3 low, high;  ///< box of positions (of directions, at infinity)
  uint32_t begin, end;
  int32_t left = -1;  ///< right is left + 1; −1: a leaf
  float measure = 0;  ///< A_k or Ω_k: Σ A_i
  double power = 0;   ///< Σ Φ_i
  double error = 0;  ///< |C| var(l), variance weighted by measure, radiance²: the cut's refinement criterion
  Vec3 centre{0};    ///< measure-weighted mean position (at infinity: unit mean direction)
  Vec3 normal{0};    ///< mean normal, not unit: its length tells how much the normals agree
  LightKind kind = LightKind::surface;
  float thickness = 0;  ///< no member lies further from the centre along the direction of `normal`

  /// How far members may lie from the centre along a unit direction, at most.
  float extent_along(Vec3 direction) const;
  uint32_t count() const { return end - begin; }
  double mean_radiance() const { return measure > 0 ? power / measure : 0; }  ///< l_k
};

struct LightTree {
  std::vector<LightNode> nodes;  ///< children stand after their parent
  std::array<int32_t, light_kind_count> roots{-1, -1, -1, -1};
  std::vector<VirtualLight> lights;  ///< in tree order: neighbours in the array are neighbours in space
  std::vector<uint32_t> original;    ///< tree position → index in the array the tree was built from
};

/// Φ_i in double, where neither 1e-30 nor 1e30 leaves the range; 0 where the radiance is not finite or
/// negative.
double leaf_power(const VirtualLight&);

/// Builds topology and order from positions and normals; radiances are aggregated too. Positions must be
/// finite. The same tree for any number of threads.
LightTree build_light_tree(std::vector<VirtualLight> lights);

/// A power of two above the sum of all power: importances are reckoned in units of it. 1 where all is dark.
double power_unit(const LightTree&);

size_t held_bytes(const LightTree&);

/// Takes new radiances (in the original order) and aggregates them; topology stays.
void relight(LightTree&, std::span<const Vec3> radiance);

struct CutSettings {
  float relative_error =
      0.05f;  ///< ε: refine while |C| var(l) > ε² |S| l̄² of the kind (= ε² (ΣΦ)²/|S| for equal A_i)
  float sigma = 0;      ///< > 0: the paper's absolute σ instead (eq. 5; the paper uses 5)
  uint32_t least = 64;  ///< nodes for each kind that is lit
  /// And of punctual lights, where more: alike in strength they have no error that would split them, and yet
  /// they differ by nearness.
  uint32_t least_punctual = 0;
  /// And of the environment, where more: clusters alike in radiance inside still differ in cosine and lobe.
  /// Those beyond what the error asks for are split by power and extent.
  uint32_t least_environment = 0;
  uint32_t most = 1024;
  bool leaves = false;  ///< no refinement: every lit leaf is a cluster
};

/// What draws need of a leaf, and of the guide's slot of that number: for even light they are neighbours.
struct CutLeaf {
  double end = 0;           ///< running sum of shares after the leaf
  float inverse_share = 0;  ///< 0 where the share is 0
  uint32_t guide = 0;       ///< first leaf that can hold a sum of the slot (Chen & Asau 1974)

  bool operator==(const CutLeaf&) const = default;
};

/// Where draws look for leaves of a cluster. The slot of a sum s is guide_begin + ⌊(s − guide_start)
/// guide_step⌋; parts of a cluster use its slots.
struct LeafRange {
  double start = 0, total = 0;  ///< the sum of shares before the cluster's leaves, and their own
  double guide_start = 0, guide_step = 0;
  uint32_t guide_begin = 0;
};

/// The illumination cut: disjoint clusters that cover every lit leaf, in tree order. Arrays of clusters are
/// padded to a multiple of 16 with clusters of no power, for SIMD loops.
struct Cut {
  uint32_t size = 0;
  double power_unit = 1;  ///< a power of two; `power` and `radiance` are in units of it
  std::vector<uint32_t> node;
  std::vector<uint32_t> begin, end;  ///< leaf ranges
  std::vector<float> power;          ///< Φ_k = Σ Φ_i, in (0, 1]; may round to 0 beside far stronger ones
  std::vector<float> radiance;       ///< l_k = Φ_k / measure
  std::vector<float> measure;        ///< A_k (Ω_k at infinity)
  std::vector<float> centre_x, centre_y, centre_z;
  std::vector<float> normal_x, normal_y, normal_z;  ///< mean normal; 0 where emission does not depend on it
  std::vector<float> radius;                        ///< distance from the centre to the box's farthest corner
  std::vector<float> extent_x, extent_y, extent_z;  ///< from the centre to the box's farther face, each axis
  std::vector<float> thickness;                     ///< LightNode::thickness
  std::vector<float> low_x, low_y, low_z, high_x, high_y, high_z;
  std::vector<LightKind> kind;

  std::vector<float> local;          ///< 1; 0 at infinity
  std::vector<float> normal_spread;  ///< 1 − |mean normal|; 1 where emission does not depend on a normal
  std::vector<float> softening;  ///< a of Φ c'/(r² + a c'): A_k/2π; 0 at infinity; R_k² for punctual lights
  std::vector<float> has_extent;  ///< 1 where a ray can hit the cluster; 0 for punctual lights

  /// Of each light. Shares are whole numbers, near 2^32 Φ_i/Φ_k in cluster k and at least 1 where Φ_i > 0:
  /// sums of whole numbers are exact, so that P from differences is the probability a search really gives.
  /// Cuts of one tree that differ in their clusters alone have it in common.
  std::shared_ptr<const std::vector<CutLeaf>> leaves;
  std::vector<LeafRange> leaf_range;  ///< of each cluster

  /// Sum of the leaves' shares before a leaf.
  double sum_before(uint32_t leaf) const { return leaf > 0 ? (*leaves)[leaf - 1].end : 0.0; }
  double share(uint32_t leaf) const { return (*leaves)[leaf].end - sum_before(leaf); }
  size_t padded_size() const { return power.size(); }
};

Cut illumination_cut(const LightTree&, const CutSettings&);

/// The same clusters with what the tree's members send now. Every member that does must lie in one of them.
void refresh_cut(const LightTree&, Cut&);

/// Share of a leaf in its cluster k, as draws choose it.
double leaf_probability(const Cut&, uint32_t k, uint32_t leaf);

/// Chooses leaves in proportion to `weight` (of each leaf, ≥ 0, with a sum near 1 in each cluster).
void weigh_leaves(Cut&, std::span<const float> weight);

size_t held_bytes(const Cut&);
/// Without the leaves, which cuts of one tree share.
size_t held_bytes_of_clusters(const Cut&);

/// Box of all clusters that are not at infinity.
Aabb local_bounds(const Cut&);

/// The clusters of a cut as one sees them who is blind to light: all members, lit or not, of radiance 1, so
/// that Φ is the measure. Punctual lights, which have none, get Wang & Åkerlund's Ω_k = |C_k| 4π/|S|, seen
/// from as far as half the extent of the local lights.
Cut equal_radiance_cut(const LightTree&, const Cut&);

}  // namespace halflight
