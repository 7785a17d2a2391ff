// The light tree and the illumination cut (Wang & Åkerlund §3.2): binary trees over S, one a kind, under one root.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/math.h"
#include "lights/virtual_light.h"

namespace halflight {

/// A node covers the leaves [begin, end) of the tree's order. Leaves of the tree are nodes with end = begin + 1.
struct LightNode {
  Vec3 low, high;      ///< box of positions (of directions, at infinity)
  uint32_t begin, end;
  int32_t left = -1;   ///< right is left + 1; −1: a leaf
  float measure = 0;   ///< A_k or Ω_k: Σ A_i
  double power = 0;    ///< Σ Φ_i
  float error = 0;     ///< |C| var(l), variance weighted by measure: the cut's refinement criterion
  Vec3 centre{0};      ///< measure-weighted mean position (at infinity: unit mean direction)
  Vec3 normal{0};      ///< mean normal, not unit: its length tells how much the normals agree
  LightKind kind = LightKind::surface;

  uint32_t count() const { return end - begin; }
};

struct LightTree {
  std::vector<LightNode> nodes;
  std::array<int32_t, light_kind_count> roots{-1, -1, -1, -1};
  std::vector<VirtualLight> lights;    ///< in tree order: neighbours in the array are neighbours in space
  std::vector<uint32_t> original;      ///< tree position → index in the array the tree was built from
  std::vector<double> power_prefix;    ///< Σ Φ of leaves before i; size lights + 1
};

/// Builds topology and order from positions and normals; radiances are aggregated too.
LightTree build_light_tree(std::vector<VirtualLight> lights);

/// Takes new radiances (in the original order) and aggregates them; topology stays.
void relight(LightTree&, std::span<const Vec3> radiance);

struct CutSettings {
  float relative_error = 0.05f;  ///< ε: refine while |C| var(l) > ε² (ΣΦ)²/|S| of the kind
  float sigma = 0;               ///< > 0: the paper's absolute σ instead (eq. 5; the paper uses 5)
  uint32_t least = 64;           ///< nodes for each kind that is lit
  uint32_t most = 1024;
};

/// The illumination cut: disjoint clusters that cover every lit leaf, in tree order. Arrays are padded to a multiple of
/// 16 with clusters of no power, for SIMD loops.
struct Cut {
  uint32_t size = 0;
  std::vector<uint32_t> node;
  std::vector<uint32_t> begin, end;           ///< leaf ranges
  std::vector<float> power;                   ///< Φ_k = Σ Φ_i
  std::vector<float> radiance;                ///< l_k = Φ_k / measure
  std::vector<float> measure;                 ///< A_k (Ω_k at infinity)
  std::vector<float> centre_x, centre_y, centre_z;
  std::vector<float> normal_x, normal_y, normal_z;
  std::vector<float> radius;                  ///< half diagonal of the box
  std::vector<float> low_x, low_y, low_z, high_x, high_y, high_z;
  std::vector<LightKind> kind;

  size_t padded_size() const { return power.size(); }
};

Cut illumination_cut(const LightTree&, const CutSettings&);

}  // namespace halflight
