// From a race's snapshots to curves, slopes, times to an error, and verdicts.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "report/race.h"
#include "report/statistics.h"

namespace halflight {

/// Errors that reports give the time to.
inline constexpr std::array<double, 2> goals{1e-2, 1e-3};

struct CurvePoint {
  uint32_t checkpoint;
  double x;                                ///< mean position on the race's axis
  Estimate error;                          ///< mean relMSE
  double trimmed;                          ///< mean relMSE without the worst 0.1 % of pixels
  double spp, wall_seconds, rays_a_pixel;  ///< means
  bool doubtful = false;  ///< so near the reference's own error that it says little; in no fit
};

struct RacerResult {
  size_t racer;     ///< index into Race::racers
  size_t runs = 0;  ///< complete ones, which all of this is from
  std::vector<CurvePoint> points;
  std::vector<uint32_t> missed;  ///< checkpoints that passed before the first picture was done in some run
  std::optional<LogLine> line;
  Estimate slope;
  std::array<Estimate, goals.size()> reach;  ///< position on the axis where the error is down to each goal
  bool preview = false;
};

/// A sentence, with the ratio that it is from.
struct Verdict {
  std::string first, second;  ///< technique ids; the ratio is first's over second's
  std::string measure;        ///< "error" at the common end, or "1e-2" and so on: what it took to get there
  Estimate ratio;
  double at = 0;      ///< position on the axis, for "error"
  bool seen = false;  ///< the interval leaves 1 out
  std::string text;
};

struct Analysis {
  std::vector<RacerResult> results;  ///< ranked: by error at the end they all reached; previews last
  std::vector<Verdict> verdicts;     ///< of the first against each other, then every other pair
  size_t headlines = 0;              ///< verdicts of the first against each other
};

Analysis analyse(const Race&);

/// "0.31 [0.28, 0.35]"; "–" where nothing is known.
std::string estimate_text(const Estimate&, std::string_view unit = "");
/// "1e-2" of one of the goals.
std::string goal_text(double goal);
/// Three significant digits, ∞ for what never ends.
std::string number_text(double);

}  // namespace halflight
