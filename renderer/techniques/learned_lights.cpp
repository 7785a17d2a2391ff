#include "techniques/learned_lights.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/random.h"
#include "techniques/light_stage.h"
#include "trace/ray_gbuffer.h"

namespace halflight {

namespace {

// Powers of surfaces and emitters are those of single points, which may miss what their stratum holds: each
// takes a small share from the mean of its kind, and those of surfaces one from their neighbours on the tree.
constexpr double own_share = 0.7, kind_share = 0.01;
constexpr size_t neighbours = 4;  ///< on either side

/// Radiances of the pilot, grey, none black beside a lit one of its kind, and smoothed along the leaves of
/// surfaces; in the original order.
std::vector<Vec3> smoothed_radiances(const LightTree& tree) {
  const size_t count = tree.lights.size();
  std::vector<double> grey(count);
  std::array<double, light_kind_count> sum{}, measure{};
  const auto kind_of = [&](size_t i) { return static_cast<size_t>(tree.lights[i].kind); };
  const auto is_surface = [&](size_t i) { return tree.lights[i].kind == LightKind::surface; };
  for (size_t i = 0; i < count; ++i) {
    grey[i] = tree.lights[i].measure > 0 ? leaf_power(tree.lights[i]) / tree.lights[i].measure : 0;
    sum[kind_of(i)] += grey[i] * tree.lights[i].measure, measure[kind_of(i)] += tree.lights[i].measure;
  }
  std::vector<Vec3> result(count);
  for (size_t i = 0; i < count; ++i) {
    double value = grey[i];
    const double mean = measure[kind_of(i)] > 0 ? sum[kind_of(i)] / measure[kind_of(i)] : 0;
    if (tree.lights[i].kind == LightKind::emitter) value = (1 - kind_share) * grey[i] + kind_share * mean;
    if (is_surface(i)) {
      double around = 0, found = 0;
      for (size_t j = i > neighbours ? i - neighbours : 0; j < std::min(count, i + neighbours + 1); ++j)
        if (is_surface(j)) around += grey[j], found += 1;
      value = own_share * grey[i] + (1 - own_share - kind_share) * (around / found) + kind_share * mean;
    }
    result[tree.original[i]] = Vec3(static_cast<float>(value));
  }
  return result;
}

}  // namespace

LearnedLights::LearnedLights(const FrameView& frame, uint32_t pilot_rays, RayCounters& counters)
    : sources_(*frame.scene, frame.kinds),
      strata_(*frame.scene,
              {frame.kinds.environment, frame.kinds.emitters, frame.kinds.surfaces, frame.kinds.punctual},
              static_cast<uint32_t>(frame.settings->get("lights.count"))) {
  constexpr uint64_t pilot = 0x70696c6f74ull;
  std::vector<VirtualLight> points = draw(frame, hash_combine(frame.seed, pilot), pilot_rays, counters);
  // Directional lights are distant ones too, but no cells.
  for (uint32_t i = 0; i < std::min<size_t>(strata_.punctual_begin(), points.size()); ++i)
    if (points[i].kind == LightKind::environment) points[i].radiance = strata_.environment_mean(i);
  tree_ = build_light_tree(std::move(points));
  relight(tree_, smoothed_radiances(tree_));
  cut_ = illumination_cut(tree_, cut_settings(*frame.settings));
  leaf_of_.resize(strata_.size());
  for (uint32_t i = 0; i < tree_.original.size(); ++i) leaf_of_[tree_.original[i]] = i;
}

std::vector<VirtualLight> LearnedLights::draw(const FrameView& frame, uint64_t seed, uint32_t rays_a_point,
                                              RayCounters& counters) const {
  return strata_.draw(seed, [&](const std::vector<BouncePoint>& points) {
    PointLighting lighting;
    lighting.samples = static_cast<int>(rays_a_point);
    lighting.seed = seed;
    lighting.alpha_seed = frame.alpha_seed;
    return irradiance_by_rays(*frame.rays, sources_.environment, sources_.emitters, points, lighting,
                              counters);
  });
}

void LearnedLights::draw_set(const FrameView& frame, uint64_t round, uint32_t rays_a_point,
                             RayCounters& counters) {
  const std::vector<VirtualLight> set =
      draw(frame, hash_combine(frame.seed, round + 1), rays_a_point, counters);
  lights_.resize(set.size());
  for (size_t i = 0; i < set.size(); ++i) lights_[i] = set[tree_.original[i]];
}

std::optional<LearnedLights::Met> LearnedLights::met(uint32_t stratum, float measure) const {
  if (stratum == none || !(measure > 0)) return std::nullopt;
  return Met{leaf_of_[stratum], measure};
}

std::optional<LearnedLights::Met> LearnedLights::met_environment(Vec3 wi) const {
  const uint32_t stratum = strata_.environment_stratum(wi);
  return stratum == none ? std::nullopt : met(stratum, strata_.environment_measure(stratum));
}

std::optional<LearnedLights::Met> LearnedLights::met_emitter(SurfacePoint point, bool front) const {
  return met(strata_.emitter_stratum(point, front), strata_.emitter_measure(point.triangle));
}

std::optional<LearnedLights::Met> LearnedLights::met_surface(SurfacePoint point, bool front) const {
  return met(strata_.surface_stratum(point, front), strata_.surface_measure(point.triangle));
}

}  // namespace halflight
