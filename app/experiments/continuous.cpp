// The continuous target: `halflight` against the other techniques, and what each of its ingredients buys.
#include <cmath>

#include "experiments/paper_experiments.h"
#include "experiments/races.h"

namespace halflight {

namespace {

constexpr std::array scenes{"cornell", "bedroom", "hall", "statue", "car", "box", "plate", "spheres"};

RaceOrder order_of(const ExperimentRun& run, const char* scene) {
  RaceOrder order;
  order.scene = scene;
  order.target = Target::continuous;
  order.width = run.choose(160, 48), order.height = run.choose(120, 36);
  order.budgets = run.options.budgets_given
                      ? run.options.budgets
                      : run.choose(std::vector<double>{0.5, 1, 2, 4}, std::vector<double>{0.5, 1});
  return order;
}

/// Time to relMSE 1e-2, of a racer by its id.
Estimate time_to_goal(const Race& race, const Analysis& analysis, std::string_view id) {
  for (const RacerResult& result : analysis.results)
    if (race.racers[result.racer].id == id) return result.reach[0];
  const double none = std::numeric_limits<double>::quiet_NaN();
  return {none, none, none};
}

/// An ingredient, and halflight without it.
struct Ingredient {
  const char* name;
  TechniqueVariant without;
};

const std::array<Ingredient, 7>& ingredients() {
  using Settings = std::vector<std::pair<std::string, std::string>>;
  const auto without = [](const char* what, Settings settings) {
    return TechniqueVariant{std::string("without-") + what, "halflight", std::move(settings)};
  };
  static const std::array<Ingredient, 7> all{{
      {"BRDF rays", without("brdf-rays", {{"halflight.brdf-share", "0"}, {"halflight.specular-share", "0"}})},
      {"more of them on specular lobes", without("specular-share", {{"halflight.specular-share", "0"}})},
      {"more clusters of the environment",
       without("environment-clusters", {{"halflight.environment-clusters", "0"}})},
      {"several positions a round", without("positions", {{"halflight.position-samples", "4096"}})},
      {"learned powers", without("powers", {{"halflight.powers", "0"}})},
      {"learned visibility", without("visibility", {{"halflight.visibility", "0"}})},
      {"one distribution for 4×4 like pixels", without("share", {{"halflight.share", "0"}})},
  }};
  return all;
}

}  // namespace

void run_continuous(const ExperimentRun& run, ExperimentReport& report, Facts& machine) {
  const std::vector<std::string> techniques{"halflight", "bidirectional", "mis", "light-bvh"};
  std::vector<std::vector<std::string>> rows;
  double log_ratio = 0, counted = 0, log_error = 0, raced = 0;
  for (const char* scene : scenes) {
    if (run.stopped()) break;
    RaceOrder order = order_of(run, scene);
    order.techniques = techniques;
    const Race race = run_order(run, order, scene);
    if (!any_complete(race)) continue;
    const Analysis analysis = analyse(race);
    for (const std::string& id : techniques) {
      const std::optional<EndOfRace> end = end_of(race, analysis, id);
      if (!end) continue;
      rows.push_back({scene, id, cell(end->seconds), cell(end->spp), estimate_text(end->error),
                      estimate_text(time_to_goal(race, analysis, id), " s"),
                      id == "halflight" ? "" : estimate_text(error_ratio(race, id, "halflight"))});
    }
    const double ours = time_to_goal(race, analysis, "halflight").value,
                 theirs = time_to_goal(race, analysis, "bidirectional").value;
    const double error = error_ratio(race, "bidirectional", "halflight").value;
    if (error > 0 && std::isfinite(error)) log_error += std::log(error), raced += 1;
    if (ours > 0 && std::isfinite(theirs)) log_ratio += std::log(theirs / ours), counted += 1;
    machine = race.machine;
  }
  report.describe("target",
                  "continuous; references by halflight with draws of its own, 16 times the largest budget");
  report.describe("seeds", run.options.seeds);
  report.table("continuous", "relMSE at equal wall time, and time to 1e-2",
               {"scene", "technique", "seconds", "samples a pixel", "relMSE", "time to 1e-2",
                "its relMSE over halflight's"},
               rows);
  if (raced > 0)
    report.text(
        fmt::format("Geometric mean over {} scenes of the relMSE at the end, bidirectional over halflight: "
                    "{}. relMSE falls "
                    "as 1/time, so that this is also by how much less time halflight has the same error.",
                    raced, cell(std::exp(log_error / raced))));
  if (counted > 0)
    report.text(
        fmt::format("Geometric mean over {} scenes of the time to 1e-2, bidirectional over halflight: {}. "
                    "Scenes on which either is still above it at the end do not count.",
                    counted, cell(std::exp(log_ratio / counted))));
}

void run_ingredients(const ExperimentRun& run, ExperimentReport& report, Facts& machine) {
  std::vector<std::vector<std::string>> rows;
  std::vector<double> logs(ingredients().size(), 0.0);
  for (const char* scene : scenes) {
    if (run.stopped()) break;
    RaceOrder order = order_of(run, scene);
    order.techniques = {"halflight"};
    order.budgets = {order.budgets.back() / 2};
    for (const Ingredient& ingredient : ingredients()) order.variants.push_back(ingredient.without);
    const Race race = run_order(run, order, scene);
    if (!any_complete(race)) continue;
    std::vector<std::string> row{scene};
    for (size_t i = 0; i < ingredients().size(); ++i) {
      const Estimate ratio = error_ratio(race, ingredients()[i].without.name, "halflight");
      row.push_back(estimate_text(ratio));
      logs[i] += std::log(ratio.value);
    }
    rows.push_back(row);
    machine = race.machine;
  }
  std::vector<std::string> headings{"scene"}, means{"geometric mean"};
  for (size_t i = 0; i < ingredients().size(); ++i) {
    headings.push_back(fmt::format("without {}", ingredients()[i].name));
    means.push_back(cell(std::exp(logs[i] / static_cast<double>(rows.size()))));
  }
  if (!rows.empty()) rows.push_back(means);
  report.describe("target", "continuous; references by halflight with draws of its own");
  report.describe("seeds", run.options.seeds);
  report.table("ingredients", "relMSE at equal wall time without each ingredient, over that of the whole",
               headings, rows);
  report.text(
      "Above 1: the ingredient buys that much. Brackets are 95 % bootstrap intervals over the seeds.");
}

}  // namespace halflight
