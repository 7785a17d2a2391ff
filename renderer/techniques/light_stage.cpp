#include "techniques/light_stage.h"

#include <algorithm>

#include "core/random.h"
#include "core/stopwatch.h"
#include "core/timeline.h"
#include "core/vector_bytes.h"

namespace halflight {

namespace {

constexpr uint32_t most_pushed_points = 131072;

bool same_place(const VirtualLight& a, const VirtualLight& b) {
  return a.kind == b.kind && a.position == b.position && a.normal == b.normal && a.measure == b.measure;
}

bool same_places(const LightTree& tree, const std::vector<VirtualLight>& lights) {
  if (tree.lights.size() != lights.size()) return false;
  for (size_t i = 0; i < lights.size(); ++i)
    if (!same_place(tree.lights[i], lights[tree.original[i]])) return false;
  return true;
}

}  // namespace

CutSettings cut_settings(const SettingValues& values, bool leaves) {
  CutSettings cut;
  cut.leaves = leaves;
  cut.relative_error = static_cast<float>(values.get("cut.error"));
  cut.sigma = static_cast<float>(values.get("cut.sigma"));
  cut.least = static_cast<uint32_t>(values.get("cut.least"));
  cut.most = std::max(static_cast<uint32_t>(values.get("cut.most")), cut.least);
  return cut;
}

std::vector<VirtualLight> LightStage::gather(const Scene& scene, const LightPointsFunction& light_points) {
  std::vector<VirtualLight> all;
  const auto place = [&](Stage stage, const auto& make) {
    Stopwatch watch;
    std::vector<VirtualLight> more = make();
    StageCounter& counter = counters_[stage];
    ++counter.calls;
    counter.bytes = more.size() * sizeof(VirtualLight);
    if (all.empty())
      all = std::move(more);
    else
      all.insert(all.end(), more.begin(), more.end());
    counter.seconds += watch.seconds();
  };
  if (kinds_.environment)
    place(Stage::environment_points, [&] { return environment_points(scene.environment, point_settings_); });
  if (kinds_.emitters) place(Stage::emitter_points, [&] { return emitter_points(scene, point_settings_); });
  if (kinds_.surfaces && !bounce_points_.empty())
    place(Stage::surface_points, [&] {
      const TimelineScope scope("light points");
      return bounce_lights(bounce_points_, light_points(bounce_points_));
    });
  if (kinds_.punctual) place(Stage::punctual_points, [&] { return punctual_points(scene); });
  counters_[Stage::surface_points].bytes += vector_bytes(bounce_points_);
  return all;
}

void LightStage::make_cut(const SettingValues& values, CutMaking making) {
  Stopwatch watch;
  cut_ = making == CutMaking::none
             ? Cut()
             : illumination_cut(tree_, cut_settings(values, making == CutMaking::leaves));
  counters_[Stage::light_tree].bytes = vector_bytes(tree_.nodes, tree_.original);
  if (making == CutMaking::leaves) counters_[Stage::light_tree].bytes += held_bytes(cut_);
  if (making != CutMaking::refined) return;
  counters_[Stage::cut] = {1, held_bytes(cut_), watch.seconds()};
}

void LightStage::build(const Scene& scene, const LightKinds& kinds, const SettingValues& values,
                       CutMaking cut_making, uint64_t pass_seed, const LightPointsFunction& light_points) {
  counters_ = {};
  kinds_ = kinds;
  point_settings_.count = static_cast<uint32_t>(values.get("lights.count"));
  point_settings_.seed = hash_combine(static_cast<uint64_t>(values.get("lights.seed")), pass_seed);
  point_settings_.repulsion_steps = static_cast<int>(values.get("lights.repulsion"));
  // So many are nearer to the integral where they were drawn than the default set when pushed
  // (docs/performance.md).
  if (point_settings_.count > most_pushed_points) point_settings_.repulsion_steps = 0;
  // Pushed points have no known density: redrawn sets stay stratified, so that their mean is the integral.
  if (pass_seed != 0) point_settings_.repulsion_steps = 0;
  Stopwatch watch;
  bounce_points_ = std::vector<BouncePoint>();  // and gives its memory back
  if (kinds_.surfaces) {
    const TimelineScope scope("place points");
    bounce_points_ = spread_surface_points(scene, point_settings_);
    counters_[Stage::surface_points].seconds = watch.seconds();
  }
  std::vector<VirtualLight> lights = gather(scene, light_points);
  const TimelineScope scope("tree and cut");
  watch.lap();
  tree_ = build_light_tree(std::move(lights));
  counters_[Stage::light_tree] = {1, 0, watch.lap()};
  make_cut(values, cut_making);
}

void LightStage::relight(const Scene& scene, const SettingValues& values, CutMaking cut_making,
                         const LightPointsFunction& light_points) {
  counters_ = {};
  std::vector<VirtualLight> lights = gather(scene, light_points);
  const TimelineScope scope("tree and cut");
  Stopwatch watch;
  if (same_places(tree_, lights)) {
    std::vector<Vec3> radiance(lights.size());
    std::transform(lights.begin(), lights.end(), radiance.begin(),
                   [](const VirtualLight& l) { return l.radiance; });
    halflight::relight(tree_, radiance);
  } else {
    tree_ = build_light_tree(std::move(lights));
  }
  counters_[Stage::light_tree] = {1, 0, watch.lap()};
  make_cut(values, cut_making);
}

}  // namespace halflight
