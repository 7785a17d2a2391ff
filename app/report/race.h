// What a race of techniques has measured, as plain data: the reports are made of it and know nothing of
// sessions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace halflight {

/// What every technique gets the same amount of.
enum class Equal { time, samples, rays };

/// "time", "s", "wall time in seconds" and so on.
struct EqualInfo {
  std::string_view id, unit, axis;
  std::string_view of_it;  ///< "in 0.31 of the time"
};
const EqualInfo& equal_info(Equal);

/// A picture at one checkpoint of a run.
struct RaceSnapshot {
  uint32_t checkpoint = 0;                   ///< index of the budget
  double budget = 0;                         ///< seconds, samples a pixel or rays a pixel
  double wall_seconds = 0, cpu_seconds = 0;  ///< of the run so far, all but taking and measuring snapshots
  double spp = 0;
  uint64_t rays = 0;  ///< visibility and closest hit, those that lit the surface points included
  // Against the race's reference; Var(r) is subtracted from all but smape, so that relmse may fall below 0.
  double relmse = 0, relmse_trimmed = 0, rmse = 0, smape = 0;
};

/// One technique with one seed. `complete`: it was not interrupted.
struct RaceRun {
  uint64_t seed = 0;
  bool complete = false;
  std::vector<RaceSnapshot> snapshots;
};

/// Files of a racer's picture at the last checkpoint of its first run, relative to the report; empty where
/// there is none.
struct PictureFiles {
  std::string exr, png, error_png;
};

struct Racer {
  std::string id, title, source, note, target;
  bool preview = false;  ///< biased, or with a target of its own: shown, not ranked
  std::string why_preview;
  std::vector<RaceRun> runs;
  PictureFiles picture;
  /// relMSE of that picture against the integral, where the race has one: sampling and discretisation error
  /// together.
  std::optional<double> relmse_of_integral{};
};

struct LeftOut {
  std::string id, why;
};

struct ReferenceFacts {
  std::string how;               ///< one sentence: which technique, with what
  std::optional<double> relmse;  ///< its own, from two halves; nothing where it is not known
  bool exact = false;
  double seconds = 0;  ///< it took; 0 where it was there already
  std::string file;
  PictureFiles picture;
};

/// How far the sum over S is from the integral it stands for: of the discrete reference against one of the
/// continuous target that sees the same pixel centres, so that no edge is in it. The latter's own variance is
/// subtracted. No technique of the race has a part in it.
struct DiscretisationError {
  double relmse = 0, relmse_trimmed = 0, rmse = 0, smape = 0;
  double own_relmse = 0;  ///< the integral's picture's own, what was subtracted
  std::string how;        ///< one sentence: how the integral was found
  PictureFiles picture;   ///< the integral, and the map of the sum's error

  /// Whether it stands out from the noise of the integral's picture.
  bool told() const { return relmse > own_relmse; }
};

/// What a technique that does nothing costs: the harness itself.
struct HarnessCost {
  double preparation_seconds = 0;  ///< S, tree, cut and G-buffer, until the end of the first pass
  double pass_seconds = 0;         ///< each further pass
};

using Facts = std::vector<std::pair<std::string, std::string>>;

struct Race {
  std::string title, scene, camera, target, light;
  int width = 0, height = 0;
  Equal equal = Equal::time;
  bool progressive = true;  ///< budgets are checkpoints of one run; otherwise each budget has its own
  std::vector<double> budgets;
  std::vector<uint64_t> seeds;
  std::vector<Racer> racers;
  std::vector<LeftOut> left_out;
  ReferenceFacts reference;
  std::optional<DiscretisationError> discretisation;  ///< discrete target, unless left out
  HarnessCost harness;
  uint32_t light_count = 0, cut_size = 0;  ///< of the scene's S, where it has one
  double error_scale = 1;                  ///< signed relative error at the ends of the error maps' colours
  double shared_seconds = 0;               ///< loading the scene and building Embree's tree: not in any run
  Facts settings, machine;
  std::vector<std::string> warnings;
  bool interrupted = false;
};

/// Position of a snapshot on the race's axis, `pixels` in the picture.
double axis_value(const RaceSnapshot&, Equal, double pixels);

/// One row a snapshot:
/// technique,seed,budget_seconds,wall_seconds,cpu_seconds,spp,rays,relmse,relmse_trimmed,rmse,smape, target.
/// `budget_seconds` holds the budget in the race's own unit where that is not time.
std::string errors_csv(const Race&);

}  // namespace halflight
