#include "experiments/races.h"

#include <algorithm>

#include "commands/open_scene.h"

namespace halflight {

namespace {

/// relMSE of each complete run at the last checkpoint that all of the racer's runs have.
std::vector<double> last_errors(const Race& race, std::string_view id) {
  std::vector<double> errors;
  for (const Racer& racer : race.racers)
    if (racer.id == id)
      for (const RaceRun& run : racer.runs)
        if (run.complete && !run.snapshots.empty()) errors.push_back(run.snapshots.back().relmse);
  return errors;
}

double mean_of(const std::vector<double>& values, std::span<const uint32_t> chosen) {
  double sum = 0;
  for (const uint32_t i : chosen) sum += values[i];
  return sum / static_cast<double>(chosen.size());
}

}  // namespace

Race run_order(const ExperimentRun& run, const RaceOrder& order, const std::string& name) {
  Options options = run.options;
  options.scene = order.scene, options.scene_given = true;
  options.render.light = order.light;
  options.render.width = order.width, options.render.height = order.height;
  options.render.target = order.target;
  options.no_discretisation = true;
  options.techniques = order.techniques, options.variants = order.variants;
  options.budgets = order.budgets, options.equal = order.equal;
  for (const auto& [key, value] : order.settings) options.render.values.set(key, value);
  options.output = (run.folder / name).string();
  return compare_techniques(options, run.bench);
}

std::optional<EndOfRace> end_of(const Race& race, const Analysis& analysis, std::string_view id) {
  for (const RacerResult& result : analysis.results) {
    if (race.racers[result.racer].id != id || result.points.empty()) continue;
    const CurvePoint& point = result.points.back();
    return EndOfRace{point.error, point.spp, point.wall_seconds};
  }
  return std::nullopt;
}

Estimate error_ratio(const Race& race, std::string_view first, std::string_view second) {
  const std::vector<double> a = last_errors(race, first), b = last_errors(race, second);
  const size_t runs = std::min(a.size(), b.size());
  const double none = std::numeric_limits<double>::quiet_NaN();
  if (runs == 0) return {none, none, none};
  return bootstrap(runs,
                   [&](std::span<const uint32_t> chosen) { return mean_of(a, chosen) / mean_of(b, chosen); });
}

RenderedPicture render_picture(Session& session, const RenderSettings& settings, uint32_t samples,
                               const ExperimentRun& run) {
  session.set_settings(settings);
  session.start_over();
  for (uint32_t done = 0; done < samples && !run.stopped();) {
    const uint32_t round = std::min(samples - done, session.round_samples(samples));
    session.run_pass(round, 1, 0, run.bench.interruption.token());
    done += round;
  }
  return {session.film().image(), session.stats(), session.film().mean_samples()};
}

ErrorMetrics error_of(const ImageRgb& image, const ImageRgb& reference) {
  return measure_radiance_error(image, reference);
}

std::string cell(double value) { return number_text(value); }

}  // namespace halflight
