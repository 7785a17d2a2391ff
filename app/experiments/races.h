// What several experiments share: races in sub-folders, and pictures of a given number of samples.
#pragma once

#include "experiments/experiment.h"
#include "report/analysis.h"

namespace halflight {

/// A race of an experiment; the rest of the options are the run's.
struct RaceOrder {
  std::string scene;
  LightSelection light = LightSelection::all;
  int width = 640, height = 480;
  std::vector<std::string> techniques;
  std::vector<double> budgets;
  Equal equal = Equal::time;
  std::vector<std::pair<std::string, std::string>> settings{};  ///< of all racers
  Target target = Target::discrete;
  std::vector<TechniqueVariant> variants{};  ///< beside the techniques, in turn with them
};

/// Runs it into the run's folder / `name`, with the full report of `halflight compare`.
Race run_order(const ExperimentRun&, const RaceOrder&, const std::string& name);

/// Mean relMSE of a racer at its last checkpoint with its interval over seeds, its samples a pixel and
/// seconds; nothing where it has no complete run.
struct EndOfRace {
  Estimate error;
  double spp, seconds;
};
std::optional<EndOfRace> end_of(const Race&, const Analysis&, std::string_view id);

/// relMSE of `first` over that of `second` at the end, with its interval; unknown where there is none.
Estimate error_ratio(const Race&, std::string_view first, std::string_view second);

/// A session's picture of exactly `samples` a pixel from the start, `seed` the samples' own; `stats` as it
/// ends.
struct RenderedPicture {
  ImageRgb image;
  SessionStats stats;
  double spp = 0;
};
RenderedPicture render_picture(Session&, const RenderSettings&, uint32_t samples, const ExperimentRun&);

/// Mean over the channels of (x − r)², and relMSE, of two pictures.
ErrorMetrics error_of(const ImageRgb& image, const ImageRgb& reference);

/// "0.0123 [0.011, 0.014]" and "1.3" as tables have them.
std::string cell(double);

}  // namespace halflight
