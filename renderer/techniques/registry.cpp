#include <array>

#include "core/errors.h"
#include "techniques/technique.h"

namespace halflight {

// Each family's file describes its own technique.
TechniqueInfo reference_technique();
TechniqueInfo illumination_technique();
TechniqueInfo bidirectional_technique();

std::string_view target_name(Target target) { return target == Target::discrete ? "discrete" : "continuous"; }

std::span<const TechniqueInfo> techniques() {
  static const std::array registry{bidirectional_technique(), illumination_technique(),
                                   reference_technique()};
  return registry;
}

const TechniqueInfo& find_technique(std::string_view id) {
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

PassStats& PassStats::operator+=(const PassStats& o) {
  distribution_seconds += o.distribution_seconds, sampling_seconds += o.sampling_seconds;
  visibility_seconds += o.visibility_seconds, resolve_seconds += o.resolve_seconds;
  rays += o.rays;
  useful_rays += o.useful_rays, pixels += o.pixels;
  finished = finished && o.finished;
  return *this;
}

}  // namespace halflight
