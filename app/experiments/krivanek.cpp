// Křivánek, environment maps with multiple importance sampling: a Phong sphere under environments from
// uniform to spiky, by samples of the BRDF, of the map, and of both under the balance heuristic.
//
// For the balance heuristic with N samples of each of two parents, Veach & Guibas 1995 bound
//   MSE_mis ≤ MSE_parent(N) + (1/N − 1/2N) μ² = MSE_parent(N) + μ²/2N.
// The estimators are unbiased, so the variance over repeats is their mean squared error; N = 1, where draws
// are independent.
#include "commands/compare_report.h"
#include "experiments/paper_experiments.h"
#include "experiments/races.h"
#include "scene/built_in_environments.h"
#include "scene/built_in_spheres.h"

namespace halflight {

namespace {

constexpr std::array<float, 5> exponents{1, 10, 100, 1000, 10000};
constexpr int side = 32;

/// Mean over the sphere's pixels of the estimate, its square, and its variance.
struct CellStatistics {
  double mean_square = 0, variance = 0;
};

CellStatistics repeat(Session& session, RenderSettings settings, const char* strategy, uint32_t samples,
                      uint32_t repeats, const ExperimentRun& run) {
  settings.values.set("mis.strategy", strategy);
  std::vector<double> sum(side * side), squares(side * side);
  for (uint32_t k = 0; k < repeats && !run.stopped(); ++k) {
    settings.seed = k + 1;
    session.set_settings(settings);
    session.run_pass(samples, 1, 0);
    for (uint32_t i = 0; i < sum.size(); ++i) {
      const double value = luminance(session.film().radiance(i));
      sum[i] += value, squares[i] += value * value;
    }
  }
  CellStatistics result;
  double pixels = 0;
  const double n = repeats;
  for (uint32_t i = 0; i < sum.size(); ++i) {
    if (!session.gbuffer().texels[i].hit()) continue;
    const double mean = sum[i] / n;
    result.mean_square += mean * mean;
    result.variance += std::max(0.0, squares[i] / n - mean * mean) * n / (n - 1);
    ++pixels;
  }
  result.mean_square /= pixels, result.variance /= pixels;
  return result;
}

}  // namespace

void run_krivanek(const ExperimentRun& run, ExperimentReport& report, Facts& machine) {
  const uint32_t repeats = run.choose(400u, 40u);
  std::vector<std::vector<std::string>> rows;
  std::array<double, 3> worst{};
  std::array<std::string, 3> worst_cell;
  size_t kept = 0;
  for (const BuiltInEnvironment& environment : built_in_environments()) {
    const Environment map = environment.make();
    for (const float exponent : exponents) {
      if (run.stopped()) break;
      run.bench.progress.show(fmt::format("{}, exponent {}", environment.name, exponent));
      Messages messages;
      RenderSettings settings = run.options.render;
      settings.width = settings.height = side;
      settings.technique = "mis", settings.target = Target::continuous,
      settings.light = LightSelection::direct;
      settings.backend = Backend::none;
      Session session(make_phong_sphere(exponent, map), settings, messages);
      run.bench.interruption.keep_what_there_is();
      const CellStatistics both = repeat(session, settings, "both", 2, repeats, run);
      const CellStatistics brdf = repeat(session, settings, "brdf", 1, repeats, run);
      const CellStatistics light = repeat(session, settings, "light", 1, repeats, run);
      if (run.stopped()) break;
      const double mu2 = both.mean_square;
      const bool holds = both.variance <= std::min(brdf.variance, light.variance) + 0.5 * mu2;
      kept += holds;
      const std::array<double, 3> relative{both.variance / mu2, brdf.variance / mu2, light.variance / mu2};
      for (size_t i = 0; i < 3; ++i)
        if (relative[i] > worst[i]) {
          worst[i] = relative[i];
          worst_cell[i] = fmt::format("{}, exponent {}", environment.name, exponent);
        }
      rows.push_back({std::string(environment.name), fmt::format("{}", exponent), cell(relative[0]),
                      cell(relative[1]), cell(relative[2]), cell(std::min(relative[1], relative[2]) + 0.5),
                      holds ? "holds" : "broken"});
      machine = machine_facts(session);
    }
  }
  run.bench.progress.hide();
  report.describe("target", "continuous, direct light of the environment");
  report.describe("repeats", repeats);
  report.table("grid", "MSE / μ² of one BRDF sample, one light sample, and both",
               {"environment", "exponent", "mis", "brdf", "light", "bound", "Veach–Guibas"}, rows);
  std::vector<std::vector<std::string>> worst_rows;
  for (size_t i = 0; i < 3; ++i)
    worst_rows.push_back({std::array{"mis", "brdf", "light"}[i], cell(worst[i]), worst_cell[i]});
  report.table("worst", "The worst cell of each", {"estimator", "MSE / μ²", "cell"}, worst_rows);
  report.text(fmt::format("The bound holds in {} of {} cells.", kept, rows.size()));
}

}  // namespace halflight
