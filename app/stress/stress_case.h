// The extreme cases of `halflight stress`: each is an expectation written down first, then a scene that tries
// it on every technique that applies.
//
// To add one: an entry in the file of its family, with inputs, bound, tolerance and exemptions; a new family
// is a function in stress_families.h and a line in registry.cpp. Techniques come from the registry of
// techniques: a new one is tried on every case whose target it supports.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "session.h"

namespace halflight {

/// What is expected of a technique in a case.
enum class Expected {
  truth,     ///< its mean is the truth, told by an interval no wider than the case's
  tails,     ///< as truth, but its tails may keep any run that can be afforded from telling
  bias,      ///< it fails: its mean over the truth lies within bounds that leave 1 out
  left_out,  ///< it is not tried
};

/// An expectation that differs from the case's own, and why. `technique` is an id, or "*" for all.
struct Exemption {
  std::string_view technique;
  Expected expected = Expected::tails;
  std::string why{};
  std::optional<Target> target{};  ///< nothing: both
  double low = 0, high = 0;        ///< Expected::bias: bounds of mean / truth
};

/// A technique with settings of its own, tried beside those of the registry.
struct Variant {
  std::string_view technique;
  std::vector<std::pair<std::string, std::string>> settings;
  Exemption expectation;
  std::optional<Target> target{};  ///< nothing: the case's
};

enum class StressVerdict { as_expected, fails_as_expected, untestable_tails, left_out, falls_short };
std::string_view verdict_name(StressVerdict);

/// What was found. NaN stands for what a check does not measure.
struct Measured {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();

  double truth = none, mean = none;    ///< of the whole picture, channels averaged
  double z = none;                     ///< of that mean
  double interval = none;              ///< half-width of its interval at the test's level, over the truth
  double tile_z = none, bound = none;  ///< largest |z| of channels and tiles, and what is allowed
  uint64_t nan_samples = 0;
  double largest_weight = none;  ///< 1/P of the lights drawn over the lights there are: 1 where all are alike
  double largest_pixel = none;   ///< of one run, over the truth's mean
  double relmse = none;          ///< of a run with the case's samples a pixel, less the truth's own noise
  double variance = none;        ///< relative variance of a pixel × samples
  double seconds = none;         ///< of a run
  double first_picture = none;   ///< seconds from the scene in memory to a sample in each pixel
  double difference = none;      ///< pictures that should be one: Σ|a − b| / Σ|b|
  uint32_t runs = 0;
  uint32_t light_count = 0, cut_size = 0;
};

/// Measurements, and the reason why they fall short; empty where they do not.
struct Finding {
  Measured measured;
  std::string shortfall;
  bool tails = false;  ///< no verdict: the tails do not allow one
};

/// How much a run of the whole list may cost.
struct StressEffort {
  bool quick = false;
  uint32_t most_runs = 0;  ///< independent runs of a technique at most; 0: as the case says
};

/// Who is tried.
struct Contestant {
  const TechniqueInfo* technique;
  Target target;
  std::vector<std::pair<std::string, std::string>> settings;
  Exemption expectation;
  std::string label;
};

struct StressCase;

/// What a case's checks share: its truths, found once a target. Ends with the case.
class StressStage;

struct StressCase {
  std::string
      id;  ///< its number in the list of extreme cases, with a letter where there are several; A1 … : added
  std::string name;
  std::string inputs;  ///< what is in the scene
  std::string bound;   ///< what is expected and why
  std::function<Scene()> scene;
  std::function<void(RenderSettings&)> set = [](RenderSettings&) {};
  std::vector<Exemption> exemptions{};
  std::vector<Variant> variants{};
  double tolerance = 0;    ///< relative, beyond the interval: what the bound allows
  double interval = 0.05;  ///< widest interval, relative, that tells a mean from a wrong one
  std::vector<Target> targets{Target::discrete, Target::continuous};
  uint32_t samples = 16;  ///< a pixel and run
  int width = 32, height = 24;
  std::function<Scene()> truth_scene{};    ///< where the truth is of another scene than the one tried
  std::optional<Vec3> constant_truth{};    ///< the same known radiance in each pixel
  std::function<void(Session&)> adjust{};  ///< before the first pass, such as the camera
  std::function<Finding(StressStage&, const Contestant&)> check{};  ///< nothing: the mean is the truth
  bool biased_too = false;  ///< techniques with a target of their own are tried as well
};

/// All cases, in the order of the list.
const std::vector<StressCase>& stress_cases();

/// A row of the table.
struct StressResult {
  std::string id, name, technique, expected, reason;
  Measured measured;
  StressVerdict verdict = StressVerdict::as_expected;
};

/// Who is tried in a case: by the registry, the case's exemptions and variants. `wanted` empty: all.
std::vector<Contestant> contestants(const StressCase&, const std::vector<std::string>& wanted);

/// Tries a case on each contestant. `progress` is told who is next; stops early, with fewer rows, when asked.
std::vector<StressResult> run_stress_case(const StressCase&, const StressEffort&,
                                          const std::vector<std::string>& wanted, std::stop_token,
                                          const std::function<void(const std::string&)>& progress);

}  // namespace halflight
