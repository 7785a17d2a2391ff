#include "report/race.h"

#include <fmt/format.h>

#include <array>

namespace halflight {

const EqualInfo& equal_info(Equal equal) {
  static constexpr std::array<EqualInfo, 3> infos{{
      {"time", "s", "wall time in seconds", "time"},
      {"samples", "samples", "samples a pixel", "samples"},
      {"rays", "rays", "rays a pixel", "rays"},
  }};
  return infos[static_cast<size_t>(equal)];
}

double axis_value(const RaceSnapshot& snapshot, Equal equal, double pixels) {
  switch (equal) {
    case Equal::time:
      return snapshot.wall_seconds;
    case Equal::samples:
      return snapshot.spp;
    default:
      return static_cast<double>(snapshot.rays) / pixels;
  }
}

std::string errors_csv(const Race& race) {
  std::string csv =
      "technique,seed,budget_seconds,wall_seconds,cpu_seconds,spp,rays,relmse,relmse_trimmed,rmse,smape,"
      "target\n";
  for (const Racer& racer : race.racers)
    for (const RaceRun& run : racer.runs)
      for (const RaceSnapshot& s : run.snapshots)
        csv += fmt::format("{},{},{:.10g},{:.6f},{:.6f},{:.10g},{},{:.10g},{:.10g},{:.10g},{:.10g},{}\n",
                           racer.id, run.seed, s.budget, s.wall_seconds, s.cpu_seconds, s.spp, s.rays,
                           s.relmse, s.relmse_trimmed, s.rmse, s.smape, racer.target);
  return csv;
}

}  // namespace halflight
