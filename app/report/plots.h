// Log-log plots as SVG, by gnuplot.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "report/analysis.h"

namespace halflight {

/// A line with its band, and the power law fitted to it; colour from `series_color`.
struct PlotSeries {
  std::string label;
  std::vector<double> x, y, low, high;  ///< low and high may be NaN: no band there
  std::vector<double> fit_x, fit_y;     ///< empty: no fit
  bool dashed = false;                  ///< previews
};

struct Plot {
  std::string x_label, y_label;
  std::vector<PlotSeries> series;
  std::vector<double> x_ticks;  ///< empty: round numbers
  std::optional<double> floor;  ///< a horizontal line, with `floor_label`
  std::string floor_label;
  bool logarithmic_x = true, logarithmic_y = true;
};

/// "#rrggbb" of the i-th series: told apart by people who see fewer colours, readable on black and white.
std::string series_color(size_t index);

/// One SVG element that scales with its container and takes the text's colour; `name`, a word of letters,
/// digits and _, keeps its inner names apart from those of other plots on the page. Nothing where gnuplot is
/// missing or fails, or there is nothing to draw.
std::optional<std::string> plot_svg(const Plot&, int width, int height, const std::string& name);

/// Whether there is a gnuplot to call.
bool has_gnuplot();

/// relMSE over the race's own axis, or over samples a pixel.
enum class PlotAxis { race, samples };
Plot error_plot(const Race&, const Analysis&, PlotAxis);

}  // namespace halflight
