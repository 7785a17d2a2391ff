// halflight experiments: the papers' figures.
#include <filesystem>

#include "commands/commands.h"
#include "commands/compare_report.h"
#include "core/parallel.h"
#include "experiments/experiment.h"
#include "text_table.h"

namespace halflight {

namespace {

std::string list() {
  std::vector<std::vector<std::string>> rows;
  for (const Experiment& experiment : experiments())
    rows.push_back(
        {std::string(experiment.name), std::string(experiment.figure), std::string(experiment.shows)});
  return text_table(rows);
}

std::vector<const Experiment*> chosen(const std::string& name) {
  std::vector<const Experiment*> result;
  std::vector<std::string> valid;
  for (const Experiment& experiment : experiments()) {
    valid.emplace_back(experiment.name);
    if (name == "all" || name == experiment.name) result.push_back(&experiment);
  }
  valid.emplace_back("all");
  if (result.empty()) throw unknown_name("experiment", name, valid);
  return result;
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed)
    throw Error(ExitCode::failure, fmt::format("{}: cannot write: {}", folder.string(), failed.message()));
}

}  // namespace

int run_experiments(const Options& options) {
  if (options.experiment.empty()) {
    write_standard_output(list());
    return static_cast<int>(ExitCode::ok);
  }
  const std::vector<const Experiment*> wanted = chosen(options.experiment);
  if (options.output.empty())
    throw usage_error("`halflight experiments NAME` needs -o DIR, a folder for the results");
  check_report_folder(options.output);
  Interruption interruption;
  set_thread_count(options.threads);
  Progress progress(!options.quiet);
  WarningPrinter warnings(options.quiet);
  for (const Experiment* experiment : wanted) {
    if (interruption.requested()) break;
    const ExperimentRun run{options,
                            {interruption, progress, warnings},
                            std::filesystem::path(options.output) / experiment->name};
    make_folder(run.folder);
    ExperimentReport report(run, experiment->name, experiment->figure, experiment->shows);
    Facts machine;
    experiment->run(run, report, machine);
    progress.hide();
    report.finish(machine);
    if (!options.quiet) print_note((run.folder / "index.html").string());
  }
  return static_cast<int>(interruption.requested() ? ExitCode::interrupted : ExitCode::ok);
}

}  // namespace halflight
