#include "report/html_parts.h"

#include <fmt/format.h>

#include <algorithm>

#include "report/error_map.h"
#include "report/report_sources.h"

namespace halflight {

namespace {

/// Length of the UTF-8 sequence that starts at `at`; 0 where none does.
size_t sequence_length(std::string_view text, size_t at) {
  const auto byte = [&](size_t i) { return static_cast<unsigned char>(text[i]); };
  const unsigned char first = byte(at);
  if (first < 0x80) return 1;
  const size_t length = first >= 0xc2 && first < 0xe0   ? 2
                        : first >= 0xe0 && first < 0xf0 ? 3
                        : first >= 0xf0 && first < 0xf5 ? 4
                                                        : 0;
  if (length == 0 || at + length > text.size()) return 0;
  for (size_t i = 1; i < length; ++i)
    if ((byte(at + i) & 0xc0) != 0x80) return 0;
  return length;
}

/// The template with each {{name}} replaced, once and from left to right: what is put in is not looked at
/// again.
std::string fill(std::string_view text,
                 const std::vector<std::pair<std::string_view, std::string_view>>& values) {
  std::string result;
  while (true) {
    const size_t open = text.find("{{"), close = text.find("}}", open);
    if (open == std::string_view::npos || close == std::string_view::npos) return result += text;
    result += text.substr(0, open);
    const std::string_view name = text.substr(open + 2, close - open - 2);
    for (const auto& [key, value] : values)
      if (key == name) result += value;
    text.remove_prefix(close + 2);
  }
}

std::string figure(const PanelPicture& picture, int width, int height) {
  return fmt::format(
      "<figure data-label=\"{0}\"><div class=\"view\" style=\"aspect-ratio:{3}/{4}\">"
      "<img alt=\"{0}\" src=\"{1}\" data-picture=\"{1}\" data-error=\"{2}\" width=\"{3}\" height=\"{4}\" "
      "draggable=\"false\"></div>"
      "<figcaption><b>{0}</b> {5}</figcaption></figure>\n",
      html_text(picture.label), html_path(picture.png), html_path(picture.error_png), width, height,
      html_text(picture.caption));
}

std::string choices(const std::vector<PanelPicture>& pictures, size_t chosen) {
  std::string options;
  for (size_t i = 0; i < pictures.size(); ++i)
    options += fmt::format("<option value=\"{}\"{}>{}</option>", i, i == chosen ? " selected" : "",
                           html_text(pictures[i].label));
  return options;
}

std::string wipe(const std::vector<PanelPicture>& pictures, int width, int height) {
  const size_t right = 0, left = std::min<size_t>(1, pictures.size() - 1);
  return fmt::format(
      "<div class=\"wipe\" hidden>\n<div class=\"bar\"><label>left <select class=\"left\">{}</select></label>"
      "<label>right <select class=\"right\">{}</select></label></div>\n"
      "<div class=\"view\" style=\"aspect-ratio:{}/{}\"><img class=\"below\" alt=\"right picture\" "
      "draggable=\"false\">"
      "<div class=\"above\"><img alt=\"left picture\" draggable=\"false\"></div><div "
      "class=\"edge\"></div></div>\n"
      "<input type=\"range\" min=\"0\" max=\"1000\" value=\"500\" aria-label=\"place of the "
      "wipe\">\n</div>\n",
      choices(pictures, left), choices(pictures, right), width, height);
}

}  // namespace

std::string html_text(std::string_view text) {
  std::string result;
  for (size_t at = 0; at < text.size();) {
    const size_t length = sequence_length(text, at);
    const char c = text[at];
    if (length == 0 || (length == 1 && static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t'))
      result += '?';
    else if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '"')
      result += "&quot;";
    else
      result += text.substr(at, length);
    at += std::max<size_t>(length, 1);
  }
  return result;
}

std::string html_path(std::string_view path) {
  std::string result;
  for (const char c : path) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = std::isalnum(byte) || std::string_view("-._~/").find(c) != std::string_view::npos;
    result += plain ? std::string(1, c) : fmt::format("%{:02X}", byte);
  }
  return result;
}

std::string html_page(std::string_view title, const std::string& body) {
  return fill(report_source("report.html"), {{"title", html_text(title)},
                                             {"style", report_source("report.css")},
                                             {"script", report_source("report.js")},
                                             {"body", body}});
}

std::string html_section(std::string_view id, std::string_view title, const std::string& body) {
  return fmt::format("<section id=\"{}\">\n<h2>{}</h2>\n{}</section>\n", id, html_text(title), body);
}

std::string html_facts(const Facts& facts) {
  std::string rows;
  for (const auto& [name, value] : facts)
    rows += fmt::format("<div><dt>{}</dt><dd>{}</dd></div>\n", html_text(name), html_text(value));
  return "<dl>\n" + rows + "</dl>\n";
}

std::string html_plot(const Plot& plot, const std::string& name, std::string_view caption) {
  const int lines = static_cast<int>(plot.series.size()) + (plot.floor ? 1 : 0);
  const auto wide = plot_svg(plot, 960, 480 + 22 * ((lines + 1) / 2), name + "_wide"),
             narrow = plot_svg(plot, 400, 330 + 20 * lines, name + "_narrow");
  const std::string below = fmt::format("<figcaption>{}</figcaption>", html_text(caption));
  if (!wide || !narrow)
    return fmt::format(
        "<figure class=\"plot\"><p class=\"none\">There is no plot: {}. The numbers are in errors.csv and "
        "report.json.</p>{}</figure>\n",
        has_gnuplot() ? "gnuplot found nothing to draw" : "gnuplot is not installed (package gnuplot-nox)",
        below);
  return fmt::format(
      "<figure class=\"plot\"><div class=\"wide\">{}</div><div class=\"narrow\">{}</div>{}</figure>\n", *wide,
      *narrow, below);
}

std::string html_table(const std::vector<std::string>& headings,
                       const std::vector<std::vector<std::string>>& rows) {
  std::string html = "<div class=\"table\"><table>\n<thead><tr>";
  for (const std::string& heading : headings) html += fmt::format("<th scope=\"col\">{}</th>", heading);
  html += "</tr></thead>\n<tbody>\n";
  for (const auto& row : rows) {
    html += "<tr>";
    for (size_t i = 0; i < row.size(); ++i)
      html += i == 0 ? fmt::format("<th scope=\"row\">{}</th>", row[i])
                     : fmt::format("<td data-label=\"{}\">{}</td>", headings[i], row[i]);
    html += "</tr>\n";
  }
  return html + "</tbody></table></div>\n";
}

std::string html_pictures(const std::vector<PanelPicture>& pictures, int width, int height, double scale) {
  if (pictures.empty()) return "<p class=\"none\">There are no pictures.</p>\n";
  std::string figures;
  for (const PanelPicture& picture : pictures) figures += figure(picture, width, height);
  const bool maps =
      std::any_of(pictures.begin(), pictures.end(), [](const auto& p) { return !p.error_png.empty(); });
  std::string html = "<div class=\"pictures\">\n<div class=\"bar tools\" hidden>";
  if (maps)
    html +=
        "<span class=\"switch\"><button type=\"button\" data-show=\"picture\" "
        "aria-pressed=\"true\">pictures</button>"
        "<button type=\"button\" data-show=\"error\" aria-pressed=\"false\">signed error</button></span>";
  html +=
      "<span class=\"switch\"><button type=\"button\" data-zoom=\"in\" aria-label=\"enlarge\">+</button>"
      "<button type=\"button\" data-zoom=\"out\" aria-label=\"make smaller\">−</button>"
      "<button type=\"button\" data-zoom=\"reset\">whole</button></span>"
      "<span class=\"hint\">double-click enlarges, dragging moves: all of them together</span></div>\n";
  if (maps)
    html += fmt::format(
        "<div class=\"scale\"><span>−{0:g} too dark</span><i style=\"background:{1}\"></i><span>too bright "
        "+{0:g}</span><small>(x − r) / √(r² + (0.01 mean r)²) of the luminance</small></div>\n",
        scale, error_gradient());
  return html + "<div class=\"grid\">\n" + figures + "</div>\n" + wipe(pictures, width, height) + "</div>\n";
}

}  // namespace halflight
