#include "stress/stress_report.h"

#include <algorithm>
#include <cmath>

#include "report/html_parts.h"
#include "text_table.h"

namespace halflight {

namespace {

constexpr StressVerdict verdicts[] = {StressVerdict::as_expected, StressVerdict::fails_as_expected,
                                      StressVerdict::untestable_tails, StressVerdict::left_out,
                                      StressVerdict::falls_short};

std::string number(double value, const char* format = "{:.3g}") {
  return std::isnan(value) ? "" : fmt::format(fmt::runtime(format), value);
}

std::string percent(double share) { return std::isnan(share) ? "" : fmt::format("{:.2f} %", 100 * share); }

/// Mean over truth; 1 where both are 0.
double ratio(const Measured& m) {
  return m.truth > 0 ? m.mean / m.truth : m.mean == 0 && m.truth == 0 ? 1 : Measured::none;
}

std::string weight_text(const Measured& m) {
  return !std::isnan(m.largest_weight)  ? number(m.largest_weight)
         : !std::isnan(m.largest_pixel) ? number(m.largest_pixel) + " (pixel)"
                                        : "";
}

std::string error_text(const Measured& m) {
  return !std::isnan(m.relmse)       ? number(m.relmse)
         : !std::isnan(m.difference) ? number(m.difference, "{:.2g}") + " apart"
                                     : "";
}

/// Cells of a result; in the order of `headings`.
const std::vector<std::string> headings{
    "technique",          "verdict", "mean / truth",   "z",      "interval",
    "worst |z| of bound", "NaN",     "largest weight", "relMSE", "seconds a run",
    "first picture"};

std::vector<std::string> cells(const StressResult& r) {
  const Measured& m = r.measured;
  if (r.verdict == StressVerdict::left_out)
    return {r.technique, std::string(verdict_name(r.verdict)), "", "", "", "", "", "", "", "", ""};
  return {r.technique,
          std::string(verdict_name(r.verdict)),
          number(ratio(m), "{:.4f}"),
          number(m.z, "{:+.1f}"),
          percent(m.interval),
          std::isnan(m.tile_z) ? "" : fmt::format("{:.1f} of {:.1f}", m.tile_z, m.bound),
          fmt::format("{}", m.nan_samples),
          weight_text(m),
          error_text(m),
          number(m.seconds, "{:.4f}"),
          number(m.first_picture, "{:.4f}")};
}

Json measured_json(const Measured& m) {
  Json json;
  const auto put = [&](const char* key, double value) { json[key] = finite_or_null(value); };
  put("mean", m.mean), put("truth", m.truth), put("ratio", ratio(m)), put("z", m.z),
      put("interval", m.interval);
  put("worst_z", m.tile_z), put("z_bound", m.bound);
  json["nan_samples"] = m.nan_samples;
  put("largest_weight", m.largest_weight), put("largest_pixel", m.largest_pixel);
  put("relmse", m.relmse), put("variance_times_samples", m.variance), put("difference", m.difference);
  put("seconds_a_run", m.seconds), put("first_picture_seconds", m.first_picture);
  json["runs"] = m.runs, json["lights"] = m.light_count, json["cut"] = m.cut_size;
  return json;
}

std::string verdict_html(const StressResult& r) {
  const std::string_view name = verdict_name(r.verdict);
  return r.verdict == StressVerdict::falls_short ? fmt::format("<strong>{}</strong>", name)
                                                 : std::string(name);
}

std::string anchor(const std::string& id) { return "case-" + id; }

/// Results of a case by verdict, in the order of `verdicts`.
std::vector<size_t> counts_of(const StressCase& c, const std::vector<StressResult>& results) {
  std::vector<size_t> counts;
  for (const StressVerdict verdict : verdicts)
    counts.push_back(
        static_cast<size_t>(std::count_if(results.begin(), results.end(), [&](const StressResult& r) {
          return r.id == c.id && r.verdict == verdict;
        })));
  return counts;
}

/// "17 as expected, 1 left out".
std::string counts_text(const std::vector<size_t>& counts) {
  std::vector<std::string> parts;
  for (size_t i = 0; i < counts.size(); ++i)
    if (counts[i] > 0) parts.push_back(fmt::format("{} {}", counts[i], verdict_name(verdicts[i])));
  return fmt::format("{}", fmt::join(parts, ", "));
}

bool was_tried(const std::vector<size_t>& counts) {
  return std::any_of(counts.begin(), counts.end(), [](size_t count) { return count > 0; });
}

std::string overview_html(const std::vector<StressResult>& results) {
  std::vector<std::string> columns{"case"};
  for (const StressVerdict verdict : verdicts) columns.emplace_back(verdict_name(verdict));
  std::vector<std::vector<std::string>> rows;
  for (const StressCase& c : stress_cases()) {
    const std::vector<size_t> counts = counts_of(c, results);
    if (!was_tried(counts)) continue;
    rows.push_back({fmt::format("<a href=\"#{}\">{} {}</a>", anchor(c.id), c.id, html_text(c.name))});
    for (const size_t count : counts) rows.back().push_back(count > 0 ? fmt::format("{}", count) : "–");
  }
  return html_table(columns, rows);
}

/// A case's section: what was expected, then what each technique gave, folded away where nothing falls short.
std::string case_html(const StressCase& c, const std::vector<StressResult>& results) {
  const std::vector<size_t> counts = counts_of(c, results);
  if (!was_tried(counts)) return "";
  std::vector<std::vector<std::string>> rows;
  std::string notes;
  for (const StressResult& r : results) {
    if (r.id != c.id) continue;
    std::vector<std::string> row;
    for (const std::string& cell : cells(r)) row.push_back(cell.empty() ? "–" : html_text(cell));
    row[1] = verdict_html(r);
    rows.push_back(row);
    if (r.expected != c.bound || !r.reason.empty())
      notes += fmt::format("<li><b>{}</b>: {}{}{}</li>\n", html_text(r.technique), html_text(r.expected),
                           r.reason.empty() ? "" : " — ", html_text(r.reason));
  }
  std::string body = fmt::format(
      "<p>{}.</p>\n<p><b>Expected:</b> {}. Tolerance beyond the interval: {:g}; widest interval: {}.</p>\n",
      html_text(c.inputs), html_text(c.bound), c.tolerance, percent(c.interval));
  if (!notes.empty()) body += "<ul class=\"small\">\n" + notes + "</ul>\n";
  body += fmt::format("<details{}><summary>{}</summary>\n{}</details>\n", counts.back() > 0 ? " open" : "",
                      counts_text(counts), html_table(headings, rows));
  return html_section(anchor(c.id), c.id + " · " + c.name, body);
}

std::string shortfalls_html(const StressReport& report) {
  std::string items;
  for (const StressResult& r : report.results)
    if (r.verdict == StressVerdict::falls_short)
      items += fmt::format("<li><a href=\"#{}\">{} {}</a>, {}: {}</li>\n", anchor(r.id), r.id,
                           html_text(r.name), html_text(r.technique), html_text(r.reason));
  return items.empty() ? "<p>Nothing falls short.</p>\n" : "<ul>\n" + items + "</ul>\n";
}

std::string how_html() {
  return "<p>A technique's mean over independent runs is held against the truth, for the picture's channels "
         "and its tiles, "
         "with a bound on Student's t that all of them keep with a chance of 99.99 %. The discrete target's "
         "truth is the "
         "sum over the same S by brute force, the continuous one's is the path tracer or a known radiance. "
         "The interval is "
         "the half-width at that bound, relative: a wrong mean further away than twice that does not pass. "
         "<b>Untestable tails</b>: an expectation written down beforehand says that no affordable run can "
         "tell, and none "
         "did. <b>Fails as expected</b>: the expectation is a bias, and it is there. Largest weight is 1/P "
         "of the lights "
         "drawn over their number, 1 for even draws; or the largest pixel of a run over the mean.</p>\n";
}

}  // namespace

size_t StressReport::count(StressVerdict verdict) const {
  return static_cast<size_t>(std::count_if(results.begin(), results.end(),
                                           [&](const StressResult& r) { return r.verdict == verdict; }));
}

ExitCode stress_exit_code(const StressReport& report) {
  return report.count(StressVerdict::falls_short) > 0 ? ExitCode::comparison_failed : ExitCode::ok;
}

Json stress_json(const StressReport& report) {
  Json json;
  json["quick"] = report.quick, json["complete"] = report.complete, json["seconds"] = report.seconds;
  for (const StressVerdict verdict : verdicts)
    json["verdicts"][std::string(verdict_name(verdict))] = report.count(verdict);
  for (const auto& [key, value] : report.machine) json["machine"][key] = value;
  json["cases"] = Json::array();
  for (const StressResult& r : report.results) {
    Json row;
    row["id"] = r.id, row["name"] = r.name, row["technique"] = r.technique, row["expected"] = r.expected;
    row["measured"] = r.verdict == StressVerdict::left_out ? Json(nullptr) : measured_json(r.measured);
    row["verdict"] = verdict_name(r.verdict);
    if (!r.reason.empty()) row["reason"] = r.reason;
    json["cases"].push_back(std::move(row));
  }
  return json;
}

std::string stress_page(const StressReport& report) {
  std::string body =
      "<header><p class=\"kicker\">halflight stress</p><h1>The extreme cases</h1><p>Each is an expectation "
      "written down "
      "first, then a scene that tries it on every technique that applies.</p></header>\n";
  Facts facts;
  for (const StressVerdict verdict : verdicts)
    facts.emplace_back(std::string(verdict_name(verdict)), fmt::format("{}", report.count(verdict)));
  facts.emplace_back("seconds", fmt::format("{:.0f}{}, a case on a core of its own", report.seconds,
                                            report.quick ? ", quick" : ""));
  if (!report.complete) body += "<p><strong>Interrupted: this is what was complete.</strong></p>\n";
  body += html_section("verdicts", "Verdicts", html_facts(facts));
  body += html_section("shortfalls", "What falls short", shortfalls_html(report));
  body += html_section("how", "How it is judged", how_html());
  body += html_section("overview", "All cases", overview_html(report.results));
  for (const StressCase& c : stress_cases()) body += case_html(c, report.results);
  return html_page("halflight stress", body + html_section("machine", "Machine", html_facts(report.machine)));
}

std::string stress_table(const StressReport& report) {
  std::vector<std::vector<std::string>> rows{{"case", "technique", "verdict", "mean/truth", "z", "interval",
                                              "NaN", "weight", "relMSE", "s/run", "first"}};
  for (const StressResult& r : report.results) {
    const std::vector<std::string> c = cells(r);
    rows.push_back({r.id + " " + r.name, c[0], c[1], c[2], c[3], c[4], c[6], c[7], c[8], c[9], c[10]});
  }
  std::string text = text_table(rows) + "\n";
  for (const StressResult& r : report.results)
    if (r.verdict == StressVerdict::falls_short)
      text += terminal_safe(fmt::format("falls short: {} {}, {}: {}", r.id, r.name, r.technique, r.reason)) +
              "\n";
  for (const StressVerdict verdict : verdicts)
    text += fmt::format("{}: {}\n", verdict_name(verdict), report.count(verdict));
  return text;
}

std::string stress_list() {
  std::vector<std::vector<std::string>> rows;
  for (const StressCase& c : stress_cases()) rows.push_back({c.id, c.name, c.inputs});
  return text_table(rows);
}

}  // namespace halflight
