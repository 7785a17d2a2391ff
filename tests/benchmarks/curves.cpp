#include "benchmarks/curves.h"

#include <fmt/format.h>

#include <cstdlib>

#include "film/image_writers.h"

namespace halflight {

namespace {

std::string gnuplot_script(const Curve& curve) {
  std::string script = fmt::format(
      "set datafile separator ','\nset logscale xy\nset format x '%.0s%c'\nset grid\nset key outside bottom "
      "center\n"
      "set xlabel '{}'\nset ylabel '{}'\n",
      curve.x_label, curve.y_label);
  std::string plot = "plot ";
  for (const CurveLine& line : curve.lines) {
    const std::string y = line.of.empty()
                              ? fmt::format("{}", line.column + 1)
                              : fmt::format("(strcol(1) eq '{}' ? ${} : 1/0)", line.of, line.column + 1);
    plot += fmt::format("{}'{}.csv' skip 1 using 2:{} with linespoints lw 2 pt 7 ps 0.6 title '{}'",
                        &line == &curve.lines.front() ? "" : ", ", curve.name, y, line.title);
  }
  for (const auto& [terminal, ending] : {std::pair("svg size 560,400 font 'sans,13'", "svg"),
                                         std::pair("pngcairo size 480,340 font 'sans,9'", "png")})
    script += fmt::format("set terminal {}\nset output '{}.{}'\n{}\n", terminal, curve.name, ending, plot);
  return script;
}

}  // namespace

void write_curve(const std::filesystem::path& folder, const Curve& curve) {
  if (folder.empty()) return;
  std::string csv = fmt::format("{}\n", fmt::join(curve.columns, ","));
  for (const auto& row : curve.rows) csv += fmt::format("{}\n", fmt::join(row, ","));
  write_text_atomically(folder / (curve.name + ".csv"), csv);
  write_text_atomically(folder / (curve.name + ".gp"), gnuplot_script(curve));
  const std::string command =
      fmt::format("cd '{}' && gnuplot '{}.gp' 2>/dev/null", folder.string(), curve.name);
  if (std::system(command.c_str()) != 0)
    fmt::print("({}: gnuplot drew no picture; the CSV is there)\n", curve.name);
}

void print_curve(const Curve& curve) {
  std::vector<size_t> widths;
  for (const std::string& column : curve.columns) widths.push_back(column.size());
  for (const auto& row : curve.rows)
    for (size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  const auto print_row = [&](const std::vector<std::string>& row) {
    for (size_t i = 0; i < row.size(); ++i) fmt::print("  {:>{}}", row[i], widths[i]);
    fmt::print("\n");
  };
  print_row(curve.columns);
  for (const auto& row : curve.rows) print_row(row);
  std::fflush(stdout);
}

}  // namespace halflight
