// From the scene's lights to S, its tree and the cut: the "lights" stage of a frame.
#pragma once

#include <functional>
#include <vector>

#include "lights/light_points.h"
#include "lights/light_tree.h"
#include "techniques/technique.h"

namespace halflight {

/// Finds irradiance on both sides of each bounce point; raster, rays or both stand behind it.
using LightPointsFunction = std::function<std::vector<Vec3>(const std::vector<BouncePoint>&)>;

/// How the frame's cut is made: not at all, of all lit leaves, or by refinement.
enum class CutMaking { none, leaves, refined };

/// Keeps the points while the geometry stands, re-lights them when a light changes, re-cuts when radiance
/// changes.
class LightStage {
 public:
  /// Places the points and builds everything. `pass_seed` ≠ 0 redraws independent points (continuous target).
  void build(const Scene&, const LightKinds&, const SettingValues&, CutMaking, uint64_t pass_seed,
             const LightPointsFunction&);
  /// Only colours or intensities changed: same points and topology.
  void relight(const Scene&, const SettingValues&, CutMaking, const LightPointsFunction&);

  const LightTree& tree() const { return tree_; }
  const Cut& cut() const { return cut_; }
  /// Calls and seconds of the last `build` or `relight`, and bytes held since; a cut of the leaves themselves
  /// goes with the tree.
  const StageCounters& counters() const { return counters_; }
  size_t bounce_point_count() const { return bounce_points_.size(); }

 private:
  std::vector<VirtualLight> gather(const Scene&, const LightPointsFunction&);
  void make_cut(const SettingValues&, CutMaking);

  LightKinds kinds_;
  LightPointSettings point_settings_;
  std::vector<BouncePoint> bounce_points_;
  LightTree tree_;
  Cut cut_;
  StageCounters counters_;
};

CutSettings cut_settings(const SettingValues&, bool leaves = false);

}  // namespace halflight
