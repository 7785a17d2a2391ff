#include "report/analysis.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace halflight {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// An error of less than this many times the reference's own is doubtful: Var(r) has been subtracted, but is
/// itself an estimate.
constexpr double doubtful_below = 1.0;

/// What the statistics of a racer are made from: its complete runs at the checkpoints that all of them have.
struct Table {
  std::vector<uint32_t> checkpoints;
  RunCurves curves;
  std::vector<const RaceRun*> runs;

  const RaceSnapshot& at(size_t run, size_t point) const {
    const auto& list = runs[run]->snapshots;
    return *std::find_if(list.begin(), list.end(),
                         [&](const RaceSnapshot& s) { return s.checkpoint == checkpoints[point]; });
  }
};

bool has_checkpoint(const RaceRun& run, uint32_t checkpoint) {
  return std::any_of(run.snapshots.begin(), run.snapshots.end(),
                     [&](const RaceSnapshot& s) { return s.checkpoint == checkpoint; });
}

Table make_table(const Race& race, const Racer& racer) {
  Table table;
  for (const RaceRun& run : racer.runs)
    if (run.complete) table.runs.push_back(&run);
  if (table.runs.empty()) return table;
  for (uint32_t c = 0; c < race.budgets.size(); ++c)
    if (std::all_of(table.runs.begin(), table.runs.end(),
                    [&](const RaceRun* run) { return has_checkpoint(*run, c); }))
      table.checkpoints.push_back(c);
  const double pixels = static_cast<double>(race.width) * race.height;
  for (size_t r = 0; r < table.runs.size(); ++r) {
    table.curves.x.emplace_back(), table.curves.y.emplace_back();
    for (size_t p = 0; p < table.checkpoints.size(); ++p) {
      table.curves.x.back().push_back(axis_value(table.at(r, p), race.equal, pixels));
      table.curves.y.back().push_back(table.at(r, p).relmse);
    }
  }
  return table;
}

/// The curve without its doubtful points.
Curve trusted(const Curve& curve, const std::vector<CurvePoint>& points) {
  Curve result;
  for (size_t i = 0; i < curve.x.size(); ++i) {
    if (points[i].doubtful) continue;
    result.x.push_back(curve.x[i]);
    result.y.push_back(curve.y[i]);
  }
  return result;
}

std::vector<CurvePoint> curve_points(const Race& race, const Table& table) {
  std::vector<CurvePoint> points;
  const double pixels = static_cast<double>(race.width) * race.height,
               runs = static_cast<double>(table.runs.size());
  for (size_t p = 0; p < table.checkpoints.size(); ++p) {
    CurvePoint point{table.checkpoints[p], 0, {}, 0, 0, 0, 0};
    for (size_t r = 0; r < table.runs.size(); ++r) {
      const RaceSnapshot& s = table.at(r, p);
      point.x += table.curves.x[r][p] / runs;
      point.trimmed += s.relmse_trimmed / runs;
      point.spp += s.spp / runs;
      point.wall_seconds += s.wall_seconds / runs;
      point.rays_a_pixel += static_cast<double>(s.rays) / pixels / runs;
    }
    point.error = bootstrap(table.runs.size(), [&](std::span<const uint32_t> chosen) {
      return mean_curve(table.curves, chosen).y[p];
    });
    point.doubtful =
        !(point.error.value > doubtful_below * race.reference.relmse.value_or(0)) && point.error.value != 0;
    points.push_back(point);
  }
  return points;
}

RacerResult result_of(const Race& race, size_t index, const Table& table) {
  RacerResult result;
  result.racer = index;
  result.runs = table.runs.size();
  result.preview = race.racers[index].preview;
  result.slope = {unknown, unknown, unknown};
  result.reach.fill(result.slope);
  for (uint32_t c = 0; c < race.budgets.size(); ++c)
    if (!table.runs.empty() &&
        std::find(table.checkpoints.begin(), table.checkpoints.end(), c) == table.checkpoints.end())
      result.missed.push_back(c);
  if (table.checkpoints.empty()) return result;
  result.points = curve_points(race, table);
  const auto mean = [&](std::span<const uint32_t> chosen) {
    return trusted(mean_curve(table.curves, chosen), result.points);
  };
  std::vector<uint32_t> all(table.runs.size());
  std::iota(all.begin(), all.end(), 0u);
  const Curve curve = mean(all);
  result.line = fit_log_log(curve.x, curve.y);
  result.slope = bootstrap(table.runs.size(), [&](std::span<const uint32_t> chosen) {
    const Curve resampled = mean(chosen);
    const auto line = fit_log_log(resampled.x, resampled.y);
    return line ? line->slope : unknown;
  });
  for (size_t g = 0; g < goals.size(); ++g)
    result.reach[g] = bootstrap(table.runs.size(), [&](std::span<const uint32_t> chosen) {
      return first_reach(mean(chosen), goals[g]);
    });
  return result;
}

/// Two racers' runs side by side, as many of each as both have.
struct Pair {
  const Racer *first, *second;
  Table a, b;
  size_t runs() const { return std::min(a.runs.size(), b.runs.size()); }
};

double common_end(const Pair& pair, std::span<const uint32_t> runs) {
  return std::min(mean_curve(pair.a.curves, runs).x.back(), mean_curve(pair.b.curves, runs).x.back());
}

bool has_interval(const Estimate& estimate) { return estimate.low == estimate.low; }

std::string against_one(const Verdict& v) {
  return has_interval(v.ratio) ? estimate_text(v.ratio)
                               : fmt::format("{} (too few runs for an interval)", number_text(v.ratio.value));
}

Verdict error_verdict(const Race& race, const Pair& pair) {
  Verdict v{pair.first->id, pair.second->id, "error", {}, 0, false, ""};
  std::vector<uint32_t> all(pair.runs());
  std::iota(all.begin(), all.end(), 0u);
  v.at = common_end(pair, all);
  v.ratio = bootstrap(pair.runs(), [&](std::span<const uint32_t> chosen) {
    const double end = common_end(pair, chosen);
    const double first = *value_at(mean_curve(pair.a.curves, chosen), end),
                 second = *value_at(mean_curve(pair.b.curves, chosen), end);
    return second > 0 && first > 0 ? first / second : unknown;
  });
  if (!v.ratio.known()) {
    v.text = fmt::format("{} and {}: no ratio, an error is lost in the reference's own.", v.first, v.second);
    return v;
  }
  v.seen = v.ratio.excludes(1);
  const std::string place = fmt::format("{} {}", number_text(v.at), equal_info(race.equal).unit);
  v.text = v.seen || !has_interval(v.ratio)
               ? fmt::format("At {}, the error of {} is {} of that of {}.", place, v.first, against_one(v),
                             v.second)
               : fmt::format("No difference seen between {} and {}: at {}, the ratio of their errors is {}.",
                             v.first, v.second, place, against_one(v));
  return v;
}

/// Where both reach the goal within their budgets and not before the first one.
std::optional<Verdict> reach_verdict(const Race& race, const Pair& pair, double goal) {
  const auto reach = [&](const Table& table, std::span<const uint32_t> chosen) {
    return first_reach(mean_curve(table.curves, chosen), goal);
  };
  std::vector<uint32_t> all(pair.runs());
  std::iota(all.begin(), all.end(), 0u);
  const double first = reach(pair.a, all), second = reach(pair.b, all);
  const std::string_view unit = equal_info(race.equal).unit, of_it = equal_info(race.equal).of_it;
  if (std::isinf(first) && std::isinf(second)) return {};
  Verdict v{pair.first->id, pair.second->id, goal_text(goal), {unknown, unknown, unknown}, 0, true, ""};
  if (std::isinf(first) || std::isinf(second)) {
    const bool swap = std::isinf(first);
    const double end = mean_curve((swap ? pair.a : pair.b).curves, all).x.back();
    v.text = fmt::format("{} reaches relMSE {} at {} {}; {} has not by {} {}.", swap ? v.second : v.first,
                         goal_text(goal), number_text(swap ? second : first), unit, swap ? v.first : v.second,
                         number_text(end), unit);
    return v;
  }
  if (first <= mean_curve(pair.a.curves, all).x.front() || second <= mean_curve(pair.b.curves, all).x.front())
    return {};
  v.ratio = bootstrap(pair.runs(), [&](std::span<const uint32_t> chosen) {
    return reach(pair.a, chosen) / reach(pair.b, chosen);
  });
  v.seen = v.ratio.excludes(1);
  v.text = v.seen || !has_interval(v.ratio)
               ? fmt::format("{} reaches relMSE {} in {} of the {} of {}.", v.first, goal_text(goal),
                             against_one(v), of_it, v.second)
               : fmt::format("No difference seen in the {} to relMSE {} between {} and {}: the ratio is {}.",
                             of_it, goal_text(goal), v.first, v.second, against_one(v));
  return v;
}

void add_verdicts(const Race& race, const Pair& pair, std::vector<Verdict>& out) {
  if (pair.runs() == 0 || pair.a.checkpoints.empty() || pair.b.checkpoints.empty()) return;
  out.push_back(error_verdict(race, pair));
  for (const double goal : goals)
    if (auto verdict = reach_verdict(race, pair, goal)) out.push_back(std::move(*verdict));
}

/// Less error where all curves end comes first; what has no picture comes last, previews behind everything.
void rank(std::vector<RacerResult>& results) {
  double end = std::numeric_limits<double>::infinity();
  for (const RacerResult& r : results)
    if (!r.preview && !r.points.empty()) end = std::min(end, r.points.back().x);
  const auto error = [&](const RacerResult& r) {
    Curve curve;
    for (const CurvePoint& p : r.points) curve.x.push_back(p.x), curve.y.push_back(p.error.value);
    return value_at(curve, end).value_or(std::numeric_limits<double>::infinity());
  };
  std::stable_sort(results.begin(), results.end(), [&](const RacerResult& a, const RacerResult& b) {
    if (a.preview != b.preview) return b.preview;
    return error(a) < error(b);
  });
}

}  // namespace

std::string goal_text(double goal) {
  return fmt::format("1e{}", static_cast<int>(std::lround(std::log10(goal))));
}

std::string number_text(double value) {
  if (std::isnan(value)) return "–";
  if (std::isinf(value)) return value > 0 ? "∞" : "−∞";
  const double size = std::abs(value);
  std::string text = size != 0 && (size < 1e-3 || size >= 1e5) ? fmt::format("{:.2e}", value)
                     : size >= 100                             ? fmt::format("{:.0f}", value)
                                                               : fmt::format("{:.3g}", value);
  if (text.front() == '-') text.replace(0, 1, "−");
  return text;
}

std::string estimate_text(const Estimate& estimate, std::string_view unit) {
  const std::string with_unit = unit.empty() ? "" : fmt::format(" {}", unit);
  if (!estimate.known()) return "–";
  if (estimate.low != estimate.low) return number_text(estimate.value) + with_unit;
  return fmt::format("{} [{}, {}]{}", number_text(estimate.value), number_text(estimate.low),
                     number_text(estimate.high), with_unit);
}

Analysis analyse(const Race& race) {
  Analysis analysis;
  std::vector<Table> tables;
  for (size_t i = 0; i < race.racers.size(); ++i) {
    tables.push_back(make_table(race, race.racers[i]));
    if (!tables.back().runs.empty()) analysis.results.push_back(result_of(race, i, tables.back()));
  }
  rank(analysis.results);
  for (size_t i = 0; i < analysis.results.size(); ++i) {
    for (size_t j = i + 1; j < analysis.results.size(); ++j) {
      const size_t a = analysis.results[i].racer, b = analysis.results[j].racer;
      if (analysis.results[i].preview || analysis.results[j].preview) continue;
      add_verdicts(race, {&race.racers[a], &race.racers[b], tables[a], tables[b]}, analysis.verdicts);
    }
    if (i == 0) analysis.headlines = analysis.verdicts.size();
  }
  return analysis;
}

}  // namespace halflight
