#include "commands/compare_report.h"
#include "experiments/experiment.h"
#include "film/image_writers.h"
#include "film/tonemap.h"

namespace halflight {

namespace {

std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? "\"\"" : std::string(1, c);
  return quoted + "\"";
}

std::string csv_line(const std::vector<std::string>& cells) {
  std::string line;
  for (size_t i = 0; i < cells.size(); ++i) {
    if (i > 0) line += ',';
    line += csv_cell(cells[i]);
  }
  line += '\n';
  return line;
}

void write_csv(const std::filesystem::path& file, const std::vector<std::string>& headings,
               const std::vector<std::vector<std::string>>& rows) {
  std::string csv = csv_line(headings);
  for (const auto& row : rows) csv += csv_line(row);
  write_text_atomically(file, csv);
}

}  // namespace

ExperimentReport::ExperimentReport(const ExperimentRun& run, std::string_view name, std::string_view figure,
                                   std::string_view shows)
    : run_(run), title_(name) {
  body_ =
      fmt::format("<header><p class=\"kicker\">halflight experiments</p><h1>{}</h1><p>{}: {}.</p></header>\n",
                  html_text(name), html_text(figure), html_text(shows));
  json_["experiment"] = name, json_["figure"] = figure, json_["shows"] = shows;
  json_["quick"] = run.options.quick;
}

void ExperimentReport::text(const std::string& html) { body_ += "<p>" + html + "</p>\n"; }

void ExperimentReport::table(const std::string& name, const std::string& title,
                             const std::vector<std::string>& headings,
                             const std::vector<std::vector<std::string>>& rows) {
  write_csv(run_.folder / (name + ".csv"), headings, rows);
  std::vector<std::vector<std::string>> cells;
  Json list = Json::array();
  for (const auto& row : rows) {
    Json object;
    for (size_t i = 0; i < row.size(); ++i) object[headings[i]] = row[i];
    list.push_back(object);
    cells.emplace_back();
    for (const std::string& cell : row) cells.back().push_back(html_text(cell));
  }
  json_["tables"][name] = list;
  body_ += html_section(name, title, html_table(headings, cells));
}

void ExperimentReport::data(const std::string& name, const std::vector<std::string>& headings,
                            const std::vector<std::vector<std::string>>& rows) {
  write_csv(run_.folder / (name + ".csv"), headings, rows);
  text(fmt::format("{} rows in <a href=\"{}.csv\">{}.csv</a>.", rows.size(), html_path(name),
                   html_text(name)));
}

void ExperimentReport::plot(const std::string& name, const Plot& plot, const std::string& caption) {
  body_ += html_plot(plot, name, caption);
}

void ExperimentReport::pictures(const std::string& title,
                                const std::vector<std::pair<std::string, std::string>>& file_and_caption) {
  std::string row = "<div style=\"display:flex;flex-wrap:wrap;gap:12px\">";
  for (const auto& [file, caption] : file_and_caption)
    row += fmt::format(
        "<figure style=\"flex:1 1 200px;max-width:420px\"><img src=\"{}\" alt=\"{}\" style=\"width:100%\">"
        "<figcaption>{}</figcaption></figure>",
        html_path(file), html_text(caption), html_text(caption));
  body_ += html_section("pictures-" + std::to_string(body_.size()), title, row + "</div>");
}

std::string ExperimentReport::write_picture(const std::string& name, const ImageRgb& image, float ev) const {
  ImageMetadata metadata;
  metadata.text = {{"software", "halflight " HALFLIGHT_VERSION}, {"experiment", title_}};
  write_exr(run_.folder / (name + ".exr"), image, metadata);
  write_png(run_.folder / (name + ".png"), display_image(image, ev, find_tone_map("linear")), metadata);
  return name + ".png";
}

void ExperimentReport::finish(const Facts& machine) {
  for (const auto& [key, value] : machine) json_["machine"][key] = value;
  json_["interrupted"] = run_.stopped();
  if (run_.stopped()) text("<strong>Interrupted: this is what was complete.</strong>");
  body_ += html_section("machine", "Machine", html_facts(machine));
  write_json((run_.folder / "report.json").string(), json_);
  write_text_atomically(run_.folder / "index.html", html_page(title_, body_));
}

}  // namespace halflight
