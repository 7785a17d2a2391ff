#include "commands/compare_setup.h"

#include <algorithm>
#include <cmath>

namespace halflight {

namespace {

bool supports(const TechniqueInfo& info, Target target) {
  if (info.target == TargetSupport::both) return true;
  return info.target == (target == Target::discrete ? TargetSupport::discrete : TargetSupport::continuous);
}

/// The sum over S itself; others that need a single pass race with as many samples in it as a budget holds.
bool is_reference(const TechniqueInfo& info) { return info.exact && info.target != TargetSupport::own; }

std::string why_preview(const TechniqueInfo& info) {
  if (info.target == TargetSupport::own)
    return info.note.empty() ? "has a target of its own" : std::string(info.note);
  if (info.bias == Bias::biased) return info.note.empty() ? "is biased" : std::string(info.note);
  return "";
}

/// The names asked for, each once; empty for all.
std::vector<std::string> names(const Options& options) {
  std::vector<std::string> result;
  for (const std::string& name : options.techniques)
    if (std::find(result.begin(), result.end(), name) == result.end()) result.push_back(name);
  if (std::find(result.begin(), result.end(), "all") != result.end()) result.clear();
  return result;
}

/// Discrete where every one of them runs in it, else continuous where every one runs in that.
Target common_target(const std::vector<const TechniqueInfo*>& infos) {
  const auto all_support = [&](Target target) {
    return std::all_of(infos.begin(), infos.end(), [&](const TechniqueInfo* info) {
      return info->target == TargetSupport::own || supports(*info, target);
    });
  };
  const bool all_own = std::all_of(infos.begin(), infos.end(), [](const TechniqueInfo* info) {
    return info->target == TargetSupport::own;
  });
  if (!all_own && all_support(Target::discrete)) return Target::discrete;
  if (all_support(Target::continuous)) return Target::continuous;
  std::vector<std::string> words;
  for (const TechniqueInfo* info : infos)
    words.push_back(fmt::format("{} ({})", info->id, target_support_name(info->target)));
  throw usage_error(
      fmt::format("--techniques: no target that all of them run in: {}", fmt::join(words, ", ")));
}

void check_budgets(const Options& options) {
  double before = 0;
  for (const double budget : options.budgets) {
    if (budget <= before)
      throw usage_error(fmt::format("--budgets: must increase; {:g} follows {:g}", budget, before));
    if (options.equal == Equal::samples && (budget != std::floor(budget) || budget > 1e9))
      throw usage_error(fmt::format("--budgets: {:g} is no whole number of samples a pixel", budget));
    before = budget;
  }
}

}  // namespace

RaceSetup set_up_race(const Options& options) {
  check_budgets(options);
  RaceSetup setup;
  const std::vector<std::string> wanted = names(options);
  setup.named = !wanted.empty();
  std::vector<const TechniqueInfo*> infos;
  for (const std::string& name : wanted) {
    infos.push_back(&find_technique(name));
    if (is_reference(*infos.back()))
      throw usage_error(
          fmt::format("--techniques: {} does not race: it is what the others are measured against", name));
  }
  setup.target = options.render.target ? *options.render.target
                 : setup.named         ? common_target(infos)
                                       : Target::discrete;
  if (!setup.named)
    for (const TechniqueInfo& info : techniques()) infos.push_back(&info);

  for (const TechniqueInfo* info : infos) {
    const std::string preview = why_preview(*info);
    if (is_reference(*info))
      setup.left_out.push_back({std::string(info->id), "it is what the others are measured against"});
    else if (info->target == TargetSupport::own || supports(*info, setup.target))
      setup.entries.push_back({std::string(info->id), info, preview});
    else if (setup.named)
      throw usage_error(fmt::format("--techniques: {} does not run in the {} target of this race", info->id,
                                    target_name(setup.target)));
    else
      setup.left_out.push_back(
          {std::string(info->id),
           fmt::format("does not run in the {} target of this race", target_name(setup.target))});
  }
  for (const TechniqueVariant& variant : options.variants) {
    const TechniqueInfo& info = find_technique(variant.technique);
    setup.entries.push_back({variant.name, &info, why_preview(info), variant.settings});
  }
  return setup;
}

}  // namespace halflight
