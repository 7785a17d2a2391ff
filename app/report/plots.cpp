#include "report/plots.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

extern char** environ;

namespace halflight {

namespace {

namespace fs = std::filesystem;

/// Runs gnuplot with these arguments, its output to `output`; whether it ended well.
bool run_gnuplot(std::vector<std::string> arguments, const std::string& output) {
  arguments.insert(arguments.begin(), "gnuplot");
  std::vector<char*> words;
  for (std::string& word : arguments) words.push_back(word.data());
  words.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, output.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
  pid_t child = 0;
  const bool started = posix_spawnp(&child, "gnuplot", &actions, nullptr, words.data(), environ) == 0;
  posix_spawn_file_actions_destroy(&actions);
  int status = 1;
  return started && waitpid(child, &status, 0) == child && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/// A folder that is gone with its content at the end of a scope.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string name = (fs::temp_directory_path() / "halflight-XXXXXX").string();
    if (mkdtemp(name.data())) path_ = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  std::string file(const char* name) const { return (path_ / name).string(); }
  bool there() const { return !path_.empty(); }

 private:
  fs::path path_;
};

/// A string of gnuplot, which has no way to write a single quote in single quotes but to double it.
std::string gnuplot_string(std::string_view text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? "''" : std::string(1, c);
  return result + "'";
}

bool drawable(double x, double y, const Plot& plot) {
  return std::isfinite(x) && std::isfinite(y) && (x > 0 || !plot.logarithmic_x) &&
         (y > 0 || !plot.logarithmic_y);
}

/// Lowest and highest x or y of the lines: neither a band nor a fit stretches the picture.
std::optional<std::pair<double, double>> range_of(const Plot& plot, std::vector<double> PlotSeries::*axis) {
  std::optional<std::pair<double, double>> range;
  for (const PlotSeries& s : plot.series) {
    for (size_t i = 0; i < s.x.size(); ++i) {
      if (!drawable(s.x[i], s.y[i], plot)) continue;
      const double value = (s.*axis)[i];
      range = range ? std::pair(std::min(range->first, value), std::max(range->second, value))
                    : std::pair(value, value);
    }
  }
  return range;
}

std::string data_blocks(const Plot& plot, double lowest) {
  std::string text;
  for (size_t i = 0; i < plot.series.size(); ++i) {
    const PlotSeries& s = plot.series[i];
    text += fmt::format("$line{} << EOD\n", i);
    for (size_t p = 0; p < s.x.size(); ++p)
      if (drawable(s.x[p], s.y[p], plot)) text += fmt::format("{} {}\n", s.x[p], s.y[p]);
    text += fmt::format("EOD\n$band{} << EOD\n", i);
    for (size_t p = 0; p < s.x.size(); ++p)
      if (drawable(s.x[p], s.y[p], plot) && std::isfinite(s.low[p]) && std::isfinite(s.high[p]))
        text += fmt::format("{} {} {}\n", s.x[p], plot.logarithmic_y ? std::max(s.low[p], lowest) : s.low[p],
                            s.high[p]);
    text += fmt::format("EOD\n$fit{} << EOD\n", i);
    for (size_t p = 0; p < s.fit_x.size(); ++p) text += fmt::format("{} {}\n", s.fit_x[p], s.fit_y[p]);
    text += "EOD\n";
  }
  return text;
}

/// Bands below, then fits, then lines with their points.
std::string plot_command(const Plot& plot, bool narrow) {
  constexpr std::array points{7, 5, 9, 13, 11, 6, 4, 8, 12, 10};
  std::vector<std::string> layers;
  for (size_t i = 0; i < plot.series.size(); ++i)
    if (std::isfinite(plot.series[i].low.empty() ? NAN : plot.series[i].low.back()))
      layers.push_back(fmt::format(
          "$band{} using 1:2:3 with filledcurves lc rgb '{}' fs transparent solid 0.18 noborder notitle", i,
          series_color(i)));
  for (size_t i = 0; i < plot.series.size(); ++i)
    if (!plot.series[i].fit_x.empty())
      layers.push_back(
          fmt::format("$fit{} using 1:2 with lines lw 1 dt 3 lc rgb '{}' notitle", i, series_color(i)));
  for (size_t i = 0; i < plot.series.size(); ++i)
    layers.push_back(
        fmt::format("$line{} using 1:2 with linespoints lw {} dt {} pt {} ps {} lc rgb '{}' title {}", i,
                    narrow ? 1.6 : 2, plot.series[i].dashed ? 2 : 1, points[i % points.size()],
                    narrow ? 0.45 : 0.6, series_color(i), gnuplot_string(plot.series[i].label)));
  if (plot.floor)
    layers.push_back(fmt::format("{} with lines lw 1 dt 4 lc rgb '#808080' title {}", *plot.floor,
                                 gnuplot_string(plot.floor_label)));
  return fmt::format("plot {}\n", fmt::join(layers, ", \\\n  "));
}

/// Marks at 1, 2 and 5 of each decade, those at 1 alone over more than three decades; x as numbers, y as
/// powers.
std::string log_ticks(char axis, double low, double high, const std::vector<double>& wanted) {
  const bool dense = high / low < 1100;
  std::vector<std::string> ticks;
  for (const double value : wanted) ticks.push_back(fmt::format("'{}' {}", number_text(value), value));
  for (int decade = static_cast<int>(std::floor(std::log10(low)));
       wanted.empty() && decade <= std::log10(high) + 1; ++decade) {
    for (const int step : {1, 2, 5}) {
      const double value = step * std::pow(10, decade);
      if ((step > 1 && !dense) || value < 0.999 * low || value > 1.001 * high) continue;
      const std::string label = axis == 'x' ? number_text(value) : fmt::format("{}e{}", step, decade);
      ticks.push_back(fmt::format("'{}' {}", label, value));
    }
  }
  return fmt::format("set logscale {0}\nset {0}tics ({1})\n", axis, fmt::join(ticks, ", "));
}

std::string script(const Plot& plot, int width, int height, const std::string& name) {
  const bool narrow = width < 600;
  std::string text = fmt::format(
      "set encoding utf8\n"
      "set terminal svg size {},{} dynamic noenhanced font 'system-ui,sans-serif,{}' name {}\n"
      "set border 3 lc rgb '#808080' lw 0.8\nset tics nomirror scale 0.5 textcolor rgb 'black'\n"
      "set grid xtics ytics lc rgb '#808080' lw 0.4 dt 3\n"
      "set key below left Left reverse maxcols {} samplen 2 spacing 1.15 width 1 height 1\n"
      "set xlabel {} offset 0,0.6\nset ylabel {} offset {},0\n",
      width, height, narrow ? 13 : 14, gnuplot_string(name), narrow ? 1 : 2, gnuplot_string(plot.x_label),
      gnuplot_string(plot.y_label), narrow ? 1.5 : 1);
  const auto x = *range_of(plot, &PlotSeries::x), y = *range_of(plot, &PlotSeries::y);
  if (plot.logarithmic_x) {
    const double low = x.first * 0.93, high = x.second * 1.07;
    text += log_ticks('x', low, high, plot.x_ticks) + fmt::format("set xrange [{}:{}]\n", low, high);
  }
  if (plot.logarithmic_y) {
    const double low = y.first * 0.6, high = y.second * 1.6;
    text += log_ticks('y', low, high, {}) + fmt::format("set yrange [{}:{}]\n", low, high);
  }
  return text + data_blocks(plot, y.first * 1e-3) + plot_command(plot, narrow);
}

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

/// The svg element alone, text in the page's own colour.
std::optional<std::string> svg_element(std::string text, const std::string& name) {
  const size_t begin = text.find("<svg");
  if (begin == std::string::npos || text.find("</svg>") == std::string::npos) return {};
  text.erase(0, begin);
  replace_all(text, "rgb(  0,   0,   0)", "currentColor");
  replace_all(text, "rgb(0,0,0)", "currentColor");
  replace_all(text, "fill=\"black\"", "fill=\"currentColor\"");
  replace_all(text, "stroke=\"black\"", "stroke=\"currentColor\"");
  replace_all(text, "color=\"black\"", "color=\"inherit\"");
  // Marks are defined once a plot under names that every plot uses.
  replace_all(text, "gpPt", name + "-mark");
  replace_all(text, "gpDot", name + "-dot");
  replace_all(text, "textshadow", name + "-shadow");
  replace_all(text, "greybox", name + "-grey");
  return text;
}

}  // namespace

std::string series_color(size_t index) {
  // Between Okabe & Ito's and Tol's sets, at a lightness that stands on white and on near black.
  static constexpr std::array<std::string_view, 12> colors{"#d9541e", "#2a7fd4", "#2b9a5b", "#b0569f",
                                                           "#c08a00", "#3aa6a6", "#7a68d6", "#d1476b",
                                                           "#7c8c1e", "#5b88a6", "#a3704a", "#8a8a8a"};
  return std::string(colors[index % colors.size()]);
}

bool has_gnuplot() {
  static const bool found = run_gnuplot({"--version"}, "/dev/null");
  return found;
}

std::optional<std::string> plot_svg(const Plot& plot, int width, int height, const std::string& name) {
  const ScratchFolder folder;
  if (!range_of(plot, &PlotSeries::y) || !folder.there() || !has_gnuplot()) return {};
  const std::string script_file = folder.file("plot.gnuplot"), svg_file = folder.file("plot.svg");
  std::ofstream(script_file, std::ios::binary) << script(plot, width, height, name);
  if (!run_gnuplot({script_file}, svg_file)) return {};
  std::ostringstream text;
  text << std::ifstream(svg_file, std::ios::binary).rdbuf();
  return svg_element(text.str(), name);
}

Plot error_plot(const Race& race, const Analysis& analysis, PlotAxis axis) {
  Plot plot;
  plot.x_label = axis == PlotAxis::race ? std::string(equal_info(race.equal).axis) : "samples a pixel";
  plot.y_label = "relMSE";
  for (const RacerResult& result : analysis.results) {
    const Racer& racer = race.racers[result.racer];
    PlotSeries series;
    series.label = racer.id;
    series.dashed = racer.preview;
    if (racer.preview) series.label += " (preview, with its bias)";
    if (axis == PlotAxis::race && !racer.preview && result.line)
      series.label += fmt::format(", slope {}", number_text(result.slope.value));
    for (const CurvePoint& p : result.points) {
      series.x.push_back(axis == PlotAxis::race ? p.x : p.spp);
      series.y.push_back(p.error.value);
      series.low.push_back(p.error.low);
      series.high.push_back(p.error.high);
      if (axis != PlotAxis::race || !result.line || racer.preview || p.doubtful) continue;
      series.fit_x.push_back(p.x);
      series.fit_y.push_back(result.line->at(p.x));
    }
    plot.series.push_back(std::move(series));
  }
  if (axis == PlotAxis::race && race.budgets.size() <= 8) plot.x_ticks = race.budgets;
  if (race.reference.relmse.value_or(0) > 0)
    plot.floor = *race.reference.relmse, plot.floor_label = "the reference's own error";
  return plot;
}

}  // namespace halflight
