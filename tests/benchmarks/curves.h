// Curves of a benchmark: a CSV file, and where gnuplot is installed an SVG and a small PNG of it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace halflight {

/// One line of a plot: a column over the second one, of the rows whose first column is `of` (empty: of all).
struct CurveLine {
  int column;  ///< counts from 0
  std::string title;
  std::string of{};
};

/// Rows begin with the name of what they belong to, then x.
struct Curve {
  std::string name;  ///< of the files
  std::string x_label, y_label;
  std::vector<std::string> columns;
  std::vector<std::vector<std::string>> rows;
  std::vector<CurveLine> lines;
};

/// Writes the files, both axes logarithmic; nothing where `folder` is empty. Throws Error (exit code 1).
void write_curve(const std::filesystem::path& folder, const Curve&);

/// Prints the rows under their columns.
void print_curve(const Curve&);

}  // namespace halflight
