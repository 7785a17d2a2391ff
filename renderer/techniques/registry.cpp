#include <algorithm>
#include <array>

#include "core/errors.h"
#include "techniques/technique.h"

namespace halflight {

// Each family's file describes its own technique.
TechniqueInfo reference_technique();
TechniqueInfo null_technique();
TechniqueInfo illumination_technique();
TechniqueInfo bidirectional_technique();
TechniqueInfo single_point_technique();
TechniqueInfo brdf_technique();
TechniqueInfo sir_technique();
TechniqueInfo mis_technique();
TechniqueInfo instant_technique();
TechniqueInfo light_bvh_technique();
TechniqueInfo stochastic_lightcuts_technique();
TechniqueInfo filtered_technique();
TechniqueInfo path_technique();
TechniqueInfo halflight_technique();

std::string_view target_name(Target target) { return target == Target::discrete ? "discrete" : "continuous"; }

std::span<const TechniqueInfo> techniques() {
  static const std::array registry{
      halflight_technique(),    bidirectional_technique(), single_point_technique(),
      illumination_technique(), brdf_technique(),          sir_technique(),
      mis_technique(),          light_bvh_technique(),     stochastic_lightcuts_technique(),
      instant_technique(),      filtered_technique(),      path_technique(),
      reference_technique()};
  return registry;
}

const TechniqueInfo& find_technique(std::string_view id) {
  static const TechniqueInfo null = null_technique();
  if (id == null.id) return null;
  std::vector<std::string> valid;
  for (const TechniqueInfo& info : techniques()) {
    if (info.id == id) return info;
    valid.emplace_back(info.id);
  }
  throw unknown_name("technique", id, valid);
}

Target choose_target(const TechniqueInfo& info, std::optional<Target> wanted) {
  const bool discrete = info.target == TargetSupport::discrete || info.target == TargetSupport::both;
  const bool continuous = info.target != TargetSupport::discrete;
  if (!wanted) return discrete ? Target::discrete : Target::continuous;
  if (*wanted == Target::discrete ? discrete : continuous) return *wanted;
  throw usage_error(
      fmt::format("technique '{}' does not run in the {} target", info.id, target_name(*wanted)));
}

StageSet reads_cut(const SettingValues&, Target, const LightKinds&) { return StageSet().add(Stage::cut); }

bool uses_light_set(const TechniqueInfo& info, Target target) {
  if (info.target == TargetSupport::own) return false;
  return !(target == Target::continuous && info.leaves_s_when_continuous);
}

PassStats& PassStats::operator+=(const PassStats& o) {
  lights_seconds += o.lights_seconds;
  distribution_seconds += o.distribution_seconds, sampling_seconds += o.sampling_seconds;
  visibility_seconds += o.visibility_seconds, resolve_seconds += o.resolve_seconds;
  gbuffer_seconds += o.gbuffer_seconds, gpu_seconds += o.gpu_seconds;
  light_count = std::max(light_count, o.light_count), cut_size = std::max(cut_size, o.cut_size);
  rays += o.rays;
  stages += o.stages;
  useful_rays += o.useful_rays, pixels += o.pixels;
  finished = finished && o.finished;
  return *this;
}

}  // namespace halflight
