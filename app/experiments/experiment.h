// The papers' figures as experiments: each is a complete description of what is rendered, and one command.
//
// To add one: a function in the file of its paper and a line in registry.cpp.
#pragma once

#include <filesystem>
#include <span>

#include "commands/compare.h"
#include "commands/json_output.h"
#include "report/html_parts.h"

namespace halflight {

/// What a run was asked for, and what it reports to.
struct ExperimentRun {
  const Options& options;  ///< seeds, threads, back end; `quick` makes everything smaller
  Workbench bench;
  std::filesystem::path folder;  ///< exists

  bool stopped() const { return bench.interruption.requested(); }
  /// One of two values, as --quick says.
  template <class T>
  T choose(T whole, T quick) const {
    return options.quick ? quick : whole;
  }
};

/// Collects what an experiment found; `finish` writes it as index.html and report.json beside the tables' CSV
/// files.
class ExperimentReport {
 public:
  ExperimentReport(const ExperimentRun& run, std::string_view name, std::string_view figure,
                   std::string_view shows);

  /// A paragraph; HTML.
  void text(const std::string& html);
  /// A table: NAME.csv, the page and the JSON hold it. Cells are plain text.
  void table(const std::string& name, const std::string& title, const std::vector<std::string>& headings,
             const std::vector<std::vector<std::string>>& rows);
  /// Rows too many to read: NAME.csv alone, with a line on the page.
  void data(const std::string& name, const std::vector<std::string>& headings,
            const std::vector<std::vector<std::string>>& rows);
  void plot(const std::string& name, const Plot&, const std::string& caption);
  /// A row of pictures that lie in the folder, with their captions.
  void pictures(const std::string& title,
                const std::vector<std::pair<std::string, std::string>>& file_and_caption);
  /// Part of the description of what was rendered.
  void describe(const std::string& key, Json value) { json_["settings"][key] = std::move(value); }

  /// Writes image as NAME.exr and NAME.png (at `ev` stops); returns the PNG's name.
  std::string write_picture(const std::string& name, const ImageRgb& image, float ev = 0) const;

  void finish(const Facts& machine);

 private:
  const ExperimentRun& run_;
  std::string title_, body_;
  Json json_;
};

struct Experiment {
  std::string_view name, figure, shows;
  void (*run)(const ExperimentRun&, ExperimentReport&, Facts& machine);
};

/// All of them, in the papers' order.
std::span<const Experiment> experiments();

}  // namespace halflight
