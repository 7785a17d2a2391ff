#include "report/report_json.h"

#include <fmt/format.h>

#include <cmath>

namespace halflight {

namespace {

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json facts_json(const Facts& facts) {
  Json json = Json::object();
  for (const auto& [key, value] : facts) json[key] = value;
  return json;
}

Json estimate_json(const Estimate& e) {
  return {{"value", number(e.value)}, {"low", number(e.low)}, {"high", number(e.high)}};
}

/// `reached` tells what null stands for.
Json reach_json(const RacerResult& result, const Estimate& e) {
  Json json = estimate_json(e);
  json["reached"] = result.points.empty() || !e.known()  ? "unknown"
                    : std::isinf(e.value)                ? "never"
                    : e.value <= result.points.front().x ? "by the first checkpoint"
                                                         : "within";
  return json;
}

Json points_json(const RacerResult& result) {
  Json points = Json::array();
  for (const CurvePoint& p : result.points)
    points.push_back({{"checkpoint", p.checkpoint},
                      {"x", number(p.x)},
                      {"relmse", estimate_json(p.error)},
                      {"relmse_trimmed", number(p.trimmed)},
                      {"wall_seconds", number(p.wall_seconds)},
                      {"spp", number(p.spp)},
                      {"rays_a_pixel", number(p.rays_a_pixel)},
                      {"near_reference_error", p.doubtful}});
  return points;
}

Json result_json(const Race& race, const RacerResult& result) {
  const Racer& racer = race.racers[result.racer];
  Json json{{"id", racer.id},      {"title", racer.title},        {"source", racer.source},
            {"note", racer.note},  {"target", racer.target},      {"preview", racer.preview},
            {"runs", result.runs}, {"picture", racer.picture.exr}};
  if (racer.preview) {
    json["why_preview"] = racer.why_preview;
    json["error_includes_bias"] = true;
  } else {
    json["slope"] = estimate_json(result.slope);
    for (size_t g = 0; g < goals.size(); ++g)
      json[fmt::format("{}_to_{}", equal_info(race.equal).of_it, goal_text(goals[g]))] =
          reach_json(result, result.reach[g]);
  }
  if (racer.relmse_of_integral) json["relmse_of_integral"] = number(*racer.relmse_of_integral);
  json["points"] = points_json(result);
  json["checkpoints_missed"] = result.missed;
  return json;
}

Json reference_json(const ReferenceFacts& reference) {
  return {{"how", reference.how},
          {"exact", reference.exact},
          {"own_relmse", reference.relmse ? number(*reference.relmse) : Json(nullptr)},
          {"seconds", reference.seconds},
          {"file", reference.file}};
}

/// Null in the continuous target, and where it was left out.
Json discretisation_json(const Race& race) {
  if (!race.discretisation) return nullptr;
  const DiscretisationError& error = *race.discretisation;
  return {{"of", "the reference of the discrete target: the sum over S"},
          {"against", "the continuous target through pixel centres: the integral"},
          {"how", error.how},
          {"relmse", number(error.relmse)},
          {"relmse_trimmed", number(error.relmse_trimmed)},
          {"rmse", number(error.rmse)},
          {"smape", number(error.smape)},
          {"own_relmse", number(error.own_relmse)},
          {"told_from_noise", error.told()},
          {"file", error.picture.exr}};
}

Json verdicts_json(const Analysis& analysis) {
  Json verdicts = Json::array();
  for (const Verdict& v : analysis.verdicts)
    verdicts.push_back({{"first", v.first},
                        {"second", v.second},
                        {"measure", v.measure},
                        {"ratio", estimate_json(v.ratio)},
                        {"difference_seen", v.seen},
                        {"text", v.text}});
  return verdicts;
}

}  // namespace

Json race_json(const Race& race, const Analysis& analysis) {
  const EqualInfo& info = equal_info(race.equal);
  Json json{{"scene", race.scene},
            {"camera", race.camera},
            {"target", race.target},
            {"light", race.light},
            {"width", race.width},
            {"height", race.height},
            {"equal", info.id},
            {"unit", info.unit},
            {"budgets", race.budgets},
            {"budgets_are", race.progressive ? "checkpoints of one run" : "a run each"},
            {"seeds", race.seeds},
            {"interrupted", race.interrupted},
            {"intervals", "95 %, bootstrap over seeds, each for itself"},
            {"relmse", "mean((x−r)²/(r² + (0.01 mean r)²)), the reference's own variance subtracted"}};
  json["reference"] = reference_json(race.reference);
  json["discretisation"] = discretisation_json(race);
  json["techniques"] = Json::array();
  for (const RacerResult& result : analysis.results) json["techniques"].push_back(result_json(race, result));
  json["left_out"] = Json::array();
  for (const LeftOut& out : race.left_out) json["left_out"].push_back({{"id", out.id}, {"why", out.why}});
  json["verdicts"] = verdicts_json(analysis);
  json["harness"] = {{"preparation_seconds", race.harness.preparation_seconds},
                     {"pass_seconds", race.harness.pass_seconds},
                     {"shared_seconds_in_no_run", race.shared_seconds}};
  json["settings"] = facts_json(race.settings);
  json["machine"] = facts_json(race.machine);
  json["warnings"] = race.warnings;
  return json;
}

}  // namespace halflight
