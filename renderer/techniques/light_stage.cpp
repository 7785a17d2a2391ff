#include "techniques/light_stage.h"

#include <algorithm>

#include "core/random.h"
#include "core/stopwatch.h"

namespace halflight {

namespace {

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

CutSettings cut_settings(const SettingValues& values) {
  CutSettings cut;
  cut.relative_error = static_cast<float>(values.get("cut.error"));
  cut.sigma = static_cast<float>(values.get("cut.sigma"));
  cut.least = static_cast<uint32_t>(values.get("cut.least"));
  cut.most = std::max(static_cast<uint32_t>(values.get("cut.most")), cut.least);
  return cut;
}

std::vector<VirtualLight> LightStage::gather(const Scene& scene, const LightPointsFunction& light_points) {
  Stopwatch watch;
  std::vector<VirtualLight> all;
  const auto append = [&](std::vector<VirtualLight> more) {
    all.insert(all.end(), more.begin(), more.end());
  };
  if (kinds_.environment) append(environment_points(scene.environment, point_settings_));
  if (kinds_.emitters) append(emitter_points(scene, point_settings_));
  times_.points += watch.lap();
  if (kinds_.surfaces && !bounce_points_.empty()) {
    append(bounce_lights(bounce_points_, light_points(bounce_points_)));
    times_.lighting = watch.lap();
  }
  if (kinds_.punctual) append(punctual_points(scene));
  times_.points += watch.lap();
  return all;
}

void LightStage::build(const Scene& scene, const LightKinds& kinds, const SettingValues& values,
                       uint64_t pass_seed, const LightPointsFunction& light_points) {
  times_ = {};
  kinds_ = kinds;
  point_settings_.count = static_cast<uint32_t>(values.get("lights.count"));
  point_settings_.seed = hash_combine(static_cast<uint64_t>(values.get("lights.seed")), pass_seed);
  point_settings_.repulsion_steps = static_cast<int>(values.get("lights.repulsion"));
  // Pushed points have no known density: redrawn sets stay stratified, so that their mean is the integral.
  if (pass_seed != 0) point_settings_.repulsion_steps = 0;
  Stopwatch watch;
  bounce_points_.clear();
  if (kinds_.surfaces) bounce_points_ = spread_surface_points(scene, point_settings_);
  times_.points = watch.seconds();
  std::vector<VirtualLight> lights = gather(scene, light_points);
  watch.lap();
  tree_ = build_light_tree(std::move(lights));
  times_.tree = watch.lap();
  cut_ = illumination_cut(tree_, cut_settings(values));
  times_.cut = watch.lap();
}

void LightStage::relight(const Scene& scene, const SettingValues& values,
                         const LightPointsFunction& light_points) {
  times_ = {};
  std::vector<VirtualLight> lights = gather(scene, light_points);
  Stopwatch watch;
  if (same_places(tree_, lights)) {
    std::vector<Vec3> radiance(lights.size());
    std::transform(lights.begin(), lights.end(), radiance.begin(),
                   [](const VirtualLight& l) { return l.radiance; });
    halflight::relight(tree_, radiance);
  } else {
    tree_ = build_light_tree(std::move(lights));
  }
  times_.tree = watch.lap();
  cut_ = illumination_cut(tree_, cut_settings(values));
  times_.cut = watch.lap();
}

}  // namespace halflight
