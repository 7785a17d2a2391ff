// Runs of a race: one technique with one seed, its error taken at each budget.
#pragma once

#include <functional>
#include <stop_token>

#include "core/image.h"
#include "film/metrics.h"
#include "report/race.h"
#include "session.h"

namespace halflight {

/// What pictures are measured against, and how far it is itself from what it stands for: its variance in each
/// of the metrics (rmse: the root of it), 0 where it is exact or not known.
struct ReferencePicture {
  ImageRgb image;
  ErrorMetrics own;
  ReferenceFacts facts;
};

/// Metrics of a picture that is one standard deviation off in every pixel and channel: the share of Var(r) in
/// them.
ErrorMetrics own_error(const ImageRgb& reference, const ImageRgb& variance);

/// What a technique's passes cost in the budget's unit: at its start (S, tree, cut, G-buffer), each pass, and
/// each sample a pixel. Sizes of passes are planned with it; it has no part in any result.
struct PassCost {
  double start = 0, pass = 0, sample = 0;
  bool known() const { return sample > 0; }
};

struct RunRequest {
  RenderSettings settings;  ///< technique, target and seed among them
  Equal equal = Equal::time;
  std::vector<double> budgets;  ///< increasing
  bool progressive = true;      ///< one run through all budgets, or one each
  uint32_t least_passes = 1;    ///< of an equal-samples run: a reference wants many sets S and pixel grids
  PassCost cost{};              ///< from `measure_cost`, or unknown
};

/// Three passes that count for nothing: what passes cost, and memory and caches as warm as every later run
/// finds them.
PassCost measure_cost(Session&, const RunRequest&);

/// Runs a technique on the session's scene as if it were opened anew (`Session::start_over`), so that wall
/// time holds S, tree, cut, shadow maps, G-buffer and the technique's own preparation. Passes go over whole
/// pictures; their sizes follow from what earlier ones cost. `on_pass` hears, after each pass, the share of
/// the run that is done; `keep_last` gets the last checkpoint's film. Where a pass takes longer
/// than the way between two budgets, the one that it ended farther from has no snapshot.
RaceRun run_race(Session&, const RunRequest&, const ReferencePicture&, std::stop_token,
                 const std::function<void(double share)>& on_pass,
                 const std::function<void(const Film&)>& keep_last = {});

/// Seconds of the technique that does nothing, on the same scene: to its first pass, and for each later one.
HarnessCost run_null(Session&, const RenderSettings&);

}  // namespace halflight
