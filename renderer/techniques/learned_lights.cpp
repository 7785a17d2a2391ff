#include "techniques/learned_lights.h"

#include <algorithm>
#include <array>
#include <bit>
#include <utility>

#include "core/parallel.h"
#include "core/random.h"
#include "core/timeline.h"
#include "core/vector_bytes.h"
#include "techniques/light_stage.h"
#include "trace/ray_gbuffer.h"

namespace halflight {

namespace {

// Powers of surfaces and emitters are those of a few points, which may miss what their stratum holds: each
// takes a small share from the mean of its kind, and those of surfaces one from their neighbours on the tree,
// as if those were so many sets more.
constexpr double neighbours_sets = 0.4, kind_share = 0.01;
constexpr size_t neighbours = 4;  ///< on either side
constexpr uint32_t pilot_sets = 4;

float grey_radiance(const VirtualLight& light) {
  return light.measure > 0 ? static_cast<float>(leaf_power(light) / light.measure) : 0.0f;
}

/// Radiances as drawing takes them, of `grey` ones in the tree's order that are means over `sets`: none black
/// beside a lit one of its kind, smoothed along the leaves of surfaces. In the original order.
std::vector<Vec3> smoothed_radiances(const LightTree& tree, const std::vector<float>& grey, uint32_t sets) {
  const size_t count = tree.lights.size();
  std::array<double, light_kind_count> sum{}, measure{};
  const auto kind_of = [&](size_t i) { return static_cast<size_t>(tree.lights[i].kind); };
  const auto is_surface = [&](size_t i) { return tree.lights[i].kind == LightKind::surface; };
  for (size_t i = 0; i < count; ++i)
    sum[kind_of(i)] += static_cast<double>(grey[i]) * tree.lights[i].measure,
        measure[kind_of(i)] += tree.lights[i].measure;
  const double around_share = neighbours_sets / (sets + neighbours_sets) * (1 - kind_share);
  std::vector<Vec3> result(count);
  for (size_t i = 0; i < count; ++i) {
    double value = grey[i];
    const double mean = measure[kind_of(i)] > 0 ? sum[kind_of(i)] / measure[kind_of(i)] : 0;
    if (tree.lights[i].kind == LightKind::emitter) value = (1 - kind_share) * value + kind_share * mean;
    if (is_surface(i)) {
      double around = 0, found = 0;
      for (size_t j = i > neighbours ? i - neighbours : 0; j < std::min(count, i + neighbours + 1); ++j)
        if (is_surface(j)) around += static_cast<double>(grey[j]), found += 1;
      value = (1 - around_share - kind_share) * value + around_share * (around / found) + kind_share * mean;
    }
    result[tree.original[i]] = Vec3(static_cast<float>(value));
  }
  return result;
}

}  // namespace

LearnedLights::LearnedLights(const FrameView& frame, uint32_t pilot_rays, bool punctual_clusters,
                             uint32_t environment_clusters, PassStats& stats)
    : sources_(*frame.scene, frame.kinds),
      strata_(*frame.scene,
              {frame.kinds.environment, frame.kinds.emitters, frame.kinds.surfaces, frame.kinds.punctual},
              static_cast<uint32_t>(frame.settings->get("lights.count"))) {
  const TimelineScope scope("pilot sets");
  constexpr uint64_t pilot = 0x70696c6f74ull;
  const uint32_t rays = std::max(1u, pilot_rays / pilot_sets);
  for (uint32_t i = 0; i < pilot_sets; ++i) {
    std::vector<VirtualLight> set =
        draw(frame, hash_combine(hash_combine(frame.seed, pilot), i), rays, stats.rays);
    see(set, pilot_);
    if (i == 0) tree_ = build_light_tree(std::move(set));
  }
  seen_ = pilot_;
  use_powers();
  CutSettings cut = cut_settings(*frame.settings, !frame.runs(Stage::cut));
  if (punctual_clusters) cut.least_punctual = cut.most;
  cut.least_environment = environment_clusters;
  cut_ = illumination_cut(tree_, cut);
  leaf_of_.resize(strata_.size());
  for (uint32_t i = 0; i < tree_.original.size(); ++i) leaf_of_[tree_.original[i]] = i;
  cluster_of_.assign(tree_.lights.size(), none);
  for (uint32_t k = 0; k < cut_.size; ++k)
    std::fill(cluster_of_.begin() + cut_.begin[k], cluster_of_.begin() + cut_.end[k], k);
  if (strata_.size() == 0) return;
  for (const Stage stage : {Stage::strata, Stage::light_tree}) ++stats.stages[stage].calls;
  if (frame.runs(Stage::cut)) ++stats.stages[Stage::cut].calls;
  if (strata_.surface_count() > 0) ++stats.stages[Stage::pilot_set].calls;
}

void LearnedLights::see(std::span<const VirtualLight> set, Seen& seen) const {
  seen.radiance.resize(set.size());
  for (size_t i = 0; i < set.size(); ++i) {
    // Directional lights are distant ones too, but no cells.
    const bool is_cell = set[i].kind == LightKind::environment && i < strata_.punctual_begin();
    const Vec3 radiance = is_cell ? strata_.environment_mean(static_cast<uint32_t>(i)) : set[i].radiance;
    VirtualLight light = set[i];
    light.radiance = radiance;
    seen.radiance[i] += grey_radiance(light);
  }
  ++seen.sets;
}

void LearnedLights::use_powers() {
  const float scale = 1 / static_cast<float>(seen_.sets);
  std::vector<float> grey(seen_.radiance.size());
  for (size_t i = 0; i < grey.size(); ++i) grey[i] = seen_.radiance[tree_.original[i]] * scale;
  relight(tree_, smoothed_radiances(tree_, grey, seen_.sets));
}

void LearnedLights::learn() {
  if (lights_.empty()) return;
  for (size_t i = 0; i < lights_.size(); ++i)
    if (tree_.lights[i].kind != LightKind::environment && tree_.lights[i].kind != LightKind::punctual)
      seen_.radiance[tree_.original[i]] += grey_radiance(lights_[i]);
    else
      seen_.radiance[tree_.original[i]] *=
          static_cast<float>(seen_.sets + 1) / static_cast<float>(seen_.sets);
  ++seen_.sets;
  if (std::has_single_bit(seen_.sets)) {
    use_powers();
    refresh_cut(tree_, cut_);
  }
}

void LearnedLights::forget() {
  if (seen_.sets == pilot_.sets) return;
  seen_ = pilot_;
  use_powers();
  refresh_cut(tree_, cut_);
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
                             PassStats& stats) {
  const TimelineScope scope("light set");
  const std::vector<VirtualLight> set =
      draw(frame, hash_combine(frame.seed, round + 1), rays_a_point, stats.rays);
  lights_.resize(set.size());
  for (size_t i = 0; i < set.size(); ++i) lights_[i] = set[tree_.original[i]];
  draw_by_set();
  for (const auto& [stage, count] : members()) stats.stages[stage].calls += count > 0;
}

/// Inside a cluster leaves are drawn in proportion to what their points send in this set, but for a share
/// that goes by what was learned.
void LearnedLights::draw_by_set() {
  constexpr double learned_share = 0.1;
  leaf_weight_.assign(lights_.size(), 0.0f);
  learned_over_drawn_.assign(lights_.size(), 1.0f);
  drawn_ = cut_;
  const auto each_cluster = [&](const auto& visit) {
    parallel_for(0, cut_.size, 16, [&](size_t begin, size_t end) {
      for (size_t k = begin; k < end; ++k) visit(static_cast<uint32_t>(k), cut_.begin[k], cut_.end[k]);
    });
  };
  each_cluster([&](uint32_t k, uint32_t begin, uint32_t end) {
    double sum = 0;
    for (uint32_t i = begin; i < end; ++i) sum += leaf_power(lights_[i]);
    const bool by_set = cut_.kind[k] != LightKind::punctual && sum > 0 && std::isfinite(sum);
    for (uint32_t i = begin; i < end; ++i) {
      const double learned = leaf_probability(cut_, k, i);
      if (!(learned > 0)) continue;
      leaf_weight_[i] = static_cast<float>(
          by_set ? (1 - learned_share) * (leaf_power(lights_[i]) / sum) + learned_share * learned : learned);
    }
  });
  weigh_leaves(drawn_, leaf_weight_);
  each_cluster([&](uint32_t k, uint32_t begin, uint32_t end) {
    for (uint32_t i = begin; i < end; ++i)
      if (leaf_weight_[i] > 0)
        learned_over_drawn_[i] =
            static_cast<float>(leaf_probability(cut_, k, i) / leaf_probability(drawn_, k, i));
  });
}

std::array<std::pair<Stage, uint32_t>, light_kind_count> LearnedLights::members() const {
  return {{{Stage::environment_points, strata_.emitters_begin()},
           {Stage::emitter_points, strata_.surfaces_begin() - strata_.emitters_begin()},
           {Stage::surface_points, strata_.punctual_begin() - strata_.surfaces_begin()},
           {Stage::punctual_points, strata_.size() - strata_.punctual_begin()}}};
}

void LearnedLights::count_held(const FrameView& frame, StageCounters& counters) const {
  for (const auto& [stage, count] : members()) counters[stage].bytes += count * sizeof(VirtualLight);
  if (strata_.size() == 0) return;
  counters[Stage::strata].bytes += strata_.held_bytes();
  counters[Stage::light_tree].bytes += held_bytes(tree_) + vector_bytes(leaf_of_, cluster_of_);
  counters[frame.cut_stage()].bytes +=
      held_bytes(cut_) + held_bytes(drawn_) + vector_bytes(learned_over_drawn_, leaf_weight_);
}

std::optional<LearnedLights::Met> LearnedLights::met(uint32_t stratum, float measure) const {
  if (stratum == none || !(measure > 0)) return std::nullopt;
  return Met{leaf_of_[stratum], measure};
}

std::optional<LearnedLights::Met> LearnedLights::met_environment(glm::ivec2 texel) const {
  const uint32_t stratum = strata_.environment_stratum(texel);
  return stratum == none ? std::nullopt : met(stratum, strata_.environment_measure(stratum));
}

std::optional<LearnedLights::Met> LearnedLights::met_emitter(SurfacePoint point, bool front) const {
  return met(strata_.emitter_stratum(point, front), strata_.emitter_measure(point.triangle));
}

std::optional<LearnedLights::Met> LearnedLights::met_surface(SurfacePoint point, bool front) const {
  return met(strata_.surface_stratum(point, front), strata_.surface_measure(point.triangle));
}

}  // namespace halflight
