// A cut refined for a few neighbouring pixels: clusters that are large beside their distance are split, for
// inside them no single cosine or distance holds (ESTIMATORS: split any node with R_k/r > 0.5).
#pragma once

#include <array>
#include <vector>

#include "lights/light_tree.h"

namespace halflight {

/// Points of surfaces that stand together: their box, and the planes above which light has to lie to reach
/// them.
class PointGroup {
 public:
  void add(Vec3 point, Vec3 geometric_normal);
  bool empty() const { return box_.empty(); }
  const Aabb& box() const { return box_; }
  /// Whether members of a node of local light can be above the horizon of a point, but for some that lie
  /// hardly above it.
  bool sees(const LightNode&) const;

 private:
  static constexpr size_t most_planes = 16;
  struct Plane {
    Vec3 normal;
    float height;  ///< of its lowest point
  };

  Aabb box_;
  std::array<Plane, most_planes> planes_;
  size_t plane_count_ = 0;
  bool planes_are_full_ = false;  ///< and there are more: everything is seen
};

/// One thread's. The base cut and its tree must outlive it.
class TileCut {
 public:
  static constexpr uint32_t most_new = 512;  ///< clusters that splitting may add

  TileCut(const LightTree&, const Cut& base);

  /// The cut for a group of points, in tree order like the base cut. Clusters that the points see and that
  /// reach further than `most_reach` of their distance to the points' box are split, those first whose light
  /// varies most between places inside, until none does, they are leaves, or `most_new` clusters have been
  /// added.
  const Cut& refine(const PointGroup&, float most_reach);
  const Cut& cut() const { return cut_; }
  /// What the cut's padded size may come to.
  size_t most_padded() const;

 private:
  /// A node in the place of a base cluster, or of a part of one.
  struct Part {
    double variation;
    uint32_t node, begin;  ///< and its first leaf
    uint32_t base_cluster;

    bool operator<(const Part& o) const {
      return variation != o.variation ? variation < o.variation : node > o.node;
    }
  };

  void find_near(const PointGroup&, float most_reach);
  void split(const PointGroup&, float most_reach);
  void assemble();

  const LightTree* tree_;
  const Cut* base_;
  Cut cut_;
  std::vector<Part> open_;   ///< a heap of nodes that may be split
  std::vector<Part> parts_;  ///< and of those that stay
  std::vector<float> reach2_;
};

}  // namespace halflight
