#include <algorithm>
#include <exception>

#include "stress/stress_stage.h"

namespace halflight {

namespace {

bool supports(const TechniqueInfo& technique, Target target) {
  return technique.target == TargetSupport::both ||
         technique.target ==
             (target == Target::discrete ? TargetSupport::discrete : TargetSupport::continuous);
}

bool is_truth(const StressCase& c, const TechniqueInfo& technique) {
  return !c.constant_truth && !c.check && (technique.id == "reference" || technique.id == "path");
}

/// The case's exemption for a technique; one that names it goes before one for all.
Exemption expectation_of(const StressCase& c, const TechniqueInfo& technique, Target target) {
  Exemption found{technique.id, Expected::truth, ""};
  for (const bool named : {false, true})
    for (const Exemption& e : c.exemptions)
      if (e.technique == (named ? technique.id : "*") && (!e.target || *e.target == target)) found = e;
  return found;
}

std::string label_of(const TechniqueInfo& technique, Target target,
                     const std::vector<std::pair<std::string, std::string>>& settings) {
  std::string label(technique.id);
  for (const auto& [key, value] : settings)
    label += fmt::format(" {}={}", key.substr(key.find('.') + 1), value);
  return label + fmt::format(" ({})", technique.target == TargetSupport::own ? "own" : target_name(target));
}

std::string expected_text(const StressCase& c, const Exemption& e) {
  switch (e.expected) {
    case Expected::tails:
      return fmt::format("the truth, but tails may keep it untested: {}", e.why);
    case Expected::bias:
      return fmt::format("fails: {}", e.why);
    case Expected::left_out:
      return fmt::format("left out: {}", e.why);
    case Expected::truth:
      break;
  }
  return c.bound;
}

/// A case that ends in an error falls short with its message; the others go on.
Finding tried(const StressCase& c, StressStage& stage, const Contestant& contestant) {
  try {
    return c.check ? c.check(stage, contestant) : check_mean(stage, contestant);
  } catch (const std::exception& error) {
    Finding finding;
    finding.shortfall = error.what();
    return finding;
  }
}

}  // namespace

std::string_view verdict_name(StressVerdict verdict) {
  switch (verdict) {
    case StressVerdict::as_expected:
      return "as expected";
    case StressVerdict::fails_as_expected:
      return "fails as expected";
    case StressVerdict::untestable_tails:
      return "untestable tails";
    case StressVerdict::left_out:
      return "left out";
    case StressVerdict::falls_short:
      break;
  }
  return "falls short";
}

std::vector<Contestant> contestants(const StressCase& c, const std::vector<std::string>& wanted) {
  const auto is_wanted = [&](std::string_view id) {
    return wanted.empty() || std::find(wanted.begin(), wanted.end(), id) != wanted.end();
  };
  std::vector<Contestant> result;
  for (const Target target : c.targets) {
    for (const TechniqueInfo& technique : techniques()) {
      const bool unbiased = technique.bias == Bias::unbiased && supports(technique, target);
      const bool own = c.biased_too && technique.target == TargetSupport::own && target == c.targets.back() &&
                       technique.device == Device::cpu;
      if (technique.hidden || !is_wanted(technique.id) || is_truth(c, technique) || !(unbiased || own))
        continue;
      result.push_back(
          {&technique, target, {}, expectation_of(c, technique, target), label_of(technique, target, {})});
    }
    for (const Variant& variant : c.variants) {
      if (!is_wanted(variant.technique) || (variant.target && *variant.target != target)) continue;
      const TechniqueInfo& technique = find_technique(variant.technique);
      result.push_back({&technique, target, variant.settings, variant.expectation,
                        label_of(technique, target, variant.settings)});
    }
  }
  return result;
}

std::vector<StressResult> run_stress_case(const StressCase& c, const StressEffort& effort,
                                          const std::vector<std::string>& wanted, std::stop_token stop,
                                          const std::function<void(const std::string&)>& progress) {
  std::vector<StressResult> results;
  StressStage stage(c, effort, stop);
  for (const Contestant& contestant : contestants(c, wanted)) {
    if (stop.stop_requested()) break;
    if (progress) progress(fmt::format("{} {}: {}", c.id, c.name, contestant.label));
    StressResult result{c.id, c.name, contestant.label, expected_text(c, contestant.expectation), "", {}};
    if (contestant.expectation.expected == Expected::left_out) {
      result.verdict = StressVerdict::left_out;
    } else {
      const Finding finding = tried(c, stage, contestant);
      if (stop.stop_requested()) break;
      result.measured = finding.measured;
      result.reason = finding.shortfall;
      result.verdict = !finding.shortfall.empty()                          ? StressVerdict::falls_short
                       : finding.tails                                     ? StressVerdict::untestable_tails
                       : contestant.expectation.expected == Expected::bias ? StressVerdict::fails_as_expected
                                                                           : StressVerdict::as_expected;
    }
    results.push_back(std::move(result));
  }
  return results;
}

}  // namespace halflight
