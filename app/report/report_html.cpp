#include "report/report_html.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/html_parts.h"

namespace halflight {

namespace {

/// What it took to get to a goal.
std::string reach_text(const RacerResult& result, const Estimate& reach) {
  if (result.points.empty() || !reach.known()) return "–";
  if (std::isinf(reach.value)) return fmt::format("&gt; {}", number_text(result.points.back().x));
  if (reach.value <= result.points.front().x)
    return fmt::format("≤ {}", number_text(result.points.front().x));
  return html_text(estimate_text(reach));
}

std::string name_cell(const Racer& racer, size_t color) {
  return fmt::format("<i class=\"key\" style=\"background:{}\"></i>{}<small>{}</small>", series_color(color),
                     html_text(racer.id), html_text(racer.title));
}

/// A value with its interval on a line below.
std::string two_lines(const Estimate& e) {
  if (!e.known()) return "–";
  const std::string value = html_text(number_text(e.value));
  if (e.low != e.low) return value;
  return fmt::format("{}<small>{} to {}</small>", value, html_text(number_text(e.low)),
                     html_text(number_text(e.high)));
}

std::string reach_cell(const RacerResult& result, const Estimate& reach) {
  const bool inside = !result.points.empty() && reach.known() && std::isfinite(reach.value) &&
                      reach.value > result.points.front().x;
  return inside ? two_lines(reach) : reach_text(result, reach);
}

std::string standings(const Race& race, const Analysis& analysis) {
  const EqualInfo& info = equal_info(race.equal);
  std::vector<std::vector<std::string>> rows;
  for (size_t i = 0; i < analysis.results.size(); ++i) {
    const RacerResult& r = analysis.results[i];
    if (r.preview) continue;
    std::vector<std::string> row{name_cell(race.racers[r.racer], i)};
    if (r.points.empty()) {
      row.insert(row.end(), {"no picture in time", "–", "–", "–", "–", "–", "–"});
    } else {
      const CurvePoint& end = r.points.back();
      row.push_back(two_lines(end.error) + (end.doubtful ? "<small>near the reference's own</small>" : ""));
      row.push_back(html_text(number_text(end.trimmed)));
      for (const Estimate& reach : r.reach) row.push_back(reach_cell(r, reach));
      row.push_back(two_lines(r.slope));
      row.push_back(number_text(end.spp));
      row.push_back(end.wall_seconds > 0
                        ? number_text(end.rays_a_pixel * race.width * race.height / end.wall_seconds / 1e6)
                        : "–");
    }
    rows.push_back(std::move(row));
  }
  std::vector<std::string> headings{"technique", "relMSE at the end", "without worst 0.1\u00a0%"};
  const std::string_view unit = race.equal == Equal::time ? ",\u00a0s" : "";
  for (const double goal : goals)
    headings.push_back(fmt::format("{} to {}{}", info.of_it, goal_text(goal), unit));
  headings.insert(headings.end(), {"slope", "samples a pixel", "Mrays a second"});
  return html_table(headings, rows);
}

/// Discretisation error apart from sampling error, in a race towards the sum over S.
std::string two_errors(const Race& race, const Analysis& analysis) {
  if (!race.discretisation) return "";
  const DiscretisationError& error = *race.discretisation;
  std::vector<std::vector<std::string>> rows{
      {"discretisation<small>of the sum over S, whoever samples it</small>",
       error.told() ? html_text(number_text(error.relmse))
                    : fmt::format("&lt; {}", html_text(number_text(2 * error.own_relmse))),
       html_text(number_text(error.relmse_trimmed)), "the sum against the integral, through pixel centres",
       "–"}};
  for (size_t i = 0; i < analysis.results.size(); ++i) {
    const RacerResult& r = analysis.results[i];
    if (r.preview || r.points.empty()) continue;
    const Racer& racer = race.racers[r.racer];
    rows.push_back({name_cell(racer, i), two_lines(r.points.back().error),
                    html_text(number_text(r.points.back().trimmed)), "sampling: against the sum",
                    racer.relmse_of_integral ? html_text(number_text(*racer.relmse_of_integral)) : "–"});
  }
  return html_section(
      "errors", "Two errors",
      html_table({"what", "relMSE", "without worst 0.1\u00a0%", "of what", "both together"}, rows) +
          fmt::format(
              "<p class=\"small\">Techniques of the discrete target converge to a sum over one set S of "
              "virtual lights; more samples never take them nearer to the integral than that sum is. The "
              "integral: {}; its own relMSE, {}, is subtracted. Antialiasing is in neither. Discretisation "
              "error is that of one set S (lights.seed); both together are of the first seed's "
              "picture.</p>\n",
              html_text(error.how), number_text(error.own_relmse)));
}

std::string verdict_list(const Analysis& analysis, size_t begin, size_t end) {
  std::string items;
  for (size_t i = begin; i < end; ++i) {
    const Verdict& v = analysis.verdicts[i];
    items += fmt::format("<li{}>{}</li>\n", v.seen ? "" : " class=\"unseen\"", html_text(v.text));
  }
  return items.empty() ? "" : "<ul class=\"verdicts\">\n" + items + "</ul>\n";
}

std::string verdicts(const Race& race, const Analysis& analysis) {
  if (analysis.verdicts.empty())
    return "<p class=\"none\">Fewer than two techniques have a complete run: there is nothing to "
           "compare.</p>\n";
  std::string html = verdict_list(analysis, 0, analysis.headlines);
  if (analysis.headlines < analysis.verdicts.size())
    html += "<details><summary>every other pair</summary>\n" +
            verdict_list(analysis, analysis.headlines, analysis.verdicts.size()) + "</details>\n";
  return html +
         fmt::format(
             "<p class=\"small\">Brackets are 95 % intervals by bootstrap over {} seeds, each for itself; "
             "where "
             "one holds 1, no difference is seen.{}</p>\n",
             race.seeds.size(),
             race.seeds.size() < 5
                 ? " Fewer than five seeds are too few for intervals: what is said of them may be chance."
                 : "");
}

std::string plots(const Race& race, const Analysis& analysis) {
  std::string html =
      html_plot(error_plot(race, analysis, PlotAxis::race), "race",
                "Means over seeds. Bands: 95 % bootstrap intervals; dotted: fitted power laws.");
  if (race.equal != Equal::samples)
    html += html_plot(error_plot(race, analysis, PlotAxis::samples), "samples",
                      "The same errors over samples a pixel: what a sample is worth, whatever it costs.");
  return html;
}

std::string pictures(const Race& race, const Analysis& analysis) {
  std::vector<PanelPicture> panel;
  if (race.discretisation && !race.discretisation->picture.png.empty()) {
    const DiscretisationError& error = *race.discretisation;
    panel.push_back({"integral", "what the sum over S stands for", error.picture.png, ""});
    panel.push_back({"reference",
                     fmt::format("the sum over S; discretisation relMSE {}", number_text(error.relmse)),
                     race.reference.picture.png, error.picture.error_png});
  } else if (!race.reference.picture.png.empty()) {
    panel.push_back({"reference", "", race.reference.picture.png, ""});
  }
  for (const RacerResult& r : analysis.results) {
    const Racer& racer = race.racers[r.racer];
    if (racer.picture.png.empty() || racer.runs.empty() || racer.runs.front().snapshots.empty()) continue;
    const RaceSnapshot& last = racer.runs.front().snapshots.back();
    panel.push_back(
        {racer.id,
         fmt::format("{}relMSE {}, {} s, {} samples a pixel", racer.preview ? "preview, includes bias: " : "",
                     number_text(last.relmse), number_text(last.wall_seconds), number_text(last.spp)),
         racer.picture.png, racer.picture.error_png});
  }
  return html_pictures(panel, race.width, race.height, race.error_scale);
}

std::string previews(const Race& race, const Analysis& analysis) {
  std::vector<std::vector<std::string>> rows;
  for (size_t i = 0; i < analysis.results.size(); ++i) {
    const RacerResult& r = analysis.results[i];
    if (!r.preview || r.points.empty()) continue;
    const Racer& racer = race.racers[r.racer];
    const CurvePoint& end = r.points.back();
    rows.push_back({name_cell(racer, i), html_text(racer.why_preview), two_lines(end.error),
                    fmt::format("{} s", number_text(end.wall_seconds)), number_text(end.spp)});
  }
  if (rows.empty()) return "";
  return html_section(
      "previews", "Previews, not ranked",
      "<p>These do not converge to the reference: their error includes their bias, and they share no "
      "verdict.</p>\n" +
          html_table({"technique", "why", "relMSE with its bias", "time", "samples a pixel"}, rows));
}

std::string left_out(const Race& race) {
  if (race.left_out.empty()) return "";
  Facts facts;
  for (const LeftOut& out : race.left_out) facts.emplace_back(out.id, out.why);
  return html_section("left-out", "Left out", html_facts(facts));
}

std::string missed_text(const Race& race, const Analysis& analysis) {
  std::string text;
  for (const RacerResult& r : analysis.results) {
    if (r.missed.empty()) continue;
    std::vector<std::string> budgets;
    for (const uint32_t c : r.missed) budgets.push_back(fmt::format("{:g}", race.budgets[c]));
    text += fmt::format(
        "<li>{} has no picture of its own at {} {}: a pass over all pixels took longer.</li>\n",
        html_text(race.racers[r.racer].id), fmt::join(budgets, ", "), equal_info(race.equal).unit);
  }
  return text;
}

std::string method(const Race& race, const Analysis& analysis) {
  const EqualInfo& info = equal_info(race.equal);
  std::string items = fmt::format("<li>Reference: {}</li>\n", html_text(race.reference.how));
  if (race.reference.relmse)
    items += fmt::format(
        "<li>The reference's own relMSE is {}; it is subtracted from every error, and errors below it are in "
        "no "
        "fit.</li>\n",
        number_text(*race.reference.relmse));
  else if (!race.reference.exact)
    items += "<li>The reference's own error is not known and is part of every error.</li>\n";
  items += "<li>relMSE = mean((x − r)² / (r² + (0.01 mean r)²)) over pixels and channels.</li>\n";
  items +=
      race.progressive
          ? fmt::format(
                "<li>Budgets are checkpoints of one run a seed: the passes before a checkpoint are part of "
                "what "
                "follows. A checkpoint lies where a whole pass ends, so the axis shows the {} it "
                "took.</li>\n",
                info.of_it)
          : std::string(
                "<li>Each budget has a run of its own, so that all its samples are drawn together.</li>\n");
  items += fmt::format(
      "<li>Wall time holds everything but what all share and no technique changes: reading the scene and "
      "building the tree of "
      "its triangles ({} s, once), and taking and measuring snapshots.</li>\n",
      number_text(race.shared_seconds));
  items += fmt::format(
      "<li>A technique that does nothing needs {} s until its first pass is done (the light set, its tree "
      "and cut, the "
      "G-buffer: as in every run), and {} s for each further pass: this is what the harness itself "
      "costs.</li>\n",
      number_text(race.harness.preparation_seconds), number_text(race.harness.pass_seconds));
  items +=
      "<li>Before the race each technique runs three passes that count for nothing: they tell how large "
      "passes "
      "may be, and "
      "leave memory and caches warm for all.</li>\n";
  items +=
      "<li>Seeds are the outer loop, techniques the inner one: a machine that slows down slows all "
      "alike.</li>\n";
  items +=
      "<li>Slopes and times are of the mean error over seeds; times are interpolated in logarithms.</li>\n";
  return "<ul>\n" + items + missed_text(race, analysis) + "</ul>\n";
}

std::string headline(const Race& race, const Analysis& analysis) {
  const bool ranked = !analysis.results.empty() && !analysis.results.front().preview;
  if (!ranked || analysis.headlines == 0) return "";
  for (size_t i = 0; i < analysis.headlines; ++i)
    if (analysis.verdicts[i].seen && analysis.verdicts[i].measure != "error")
      return fmt::format("<p class=\"lead\">{}</p>\n", html_text(analysis.verdicts[i].text));
  return fmt::format("<p class=\"lead\">{}</p>\n", html_text(analysis.verdicts.front().text));
}

std::string header(const Race& race, const Analysis& analysis) {
  std::string html = fmt::format(
      "<header>\n<p class=\"kicker\">halflight compare · equal {} · {} target</p>\n<h1>{}</h1>\n<p "
      "class=\"facts\">{} × {}, "
      "{} light, {} seeds, budgets {} {}</p>\n",
      equal_info(race.equal).id, html_text(race.target), html_text(race.title), race.width, race.height,
      html_text(race.light), race.seeds.size(), fmt::join(race.budgets, ", "), equal_info(race.equal).unit);
  if (race.interrupted)
    html +=
        "<p class=\"warning\">This comparison was interrupted: it holds the runs that were complete.</p>\n";
  return html + headline(race, analysis) + "</header>\n";
}

std::string warnings(const Race& race) {
  std::string items;
  for (const std::string& warning : race.warnings) items += fmt::format("<li>{}</li>\n", html_text(warning));
  return items.empty() ? "" : html_section("warnings", "Warnings", "<ul>\n" + items + "</ul>\n");
}

}  // namespace

std::string race_html(const Race& race, const Analysis& analysis) {
  std::string body = header(race, analysis);
  body += html_section("standings", "Standings", standings(race, analysis));
  body += two_errors(race, analysis);
  body += html_section("error", fmt::format("Error against {}", equal_info(race.equal).of_it),
                       plots(race, analysis));
  body += html_section("verdicts", "Verdicts", verdicts(race, analysis));
  body += html_section("pictures", "Pictures", pictures(race, analysis));
  body += previews(race, analysis) + left_out(race);
  body += html_section("method", "How it was measured", method(race, analysis));
  body += html_section("settings", "Settings", html_facts(race.settings));
  body += html_section("machine", "Machine", html_facts(race.machine));
  return html_page(fmt::format("{} – halflight compare", race.title), body + warnings(race));
}

}  // namespace halflight
