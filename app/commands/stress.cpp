// halflight stress: the extreme cases.
#include <filesystem>

#include "commands/commands.h"
#include "commands/compare.h"
#include "commands/compare_report.h"
#include "core/parallel.h"
#include "film/image_writers.h"
#include "stress/stress_report.h"
#include "text_table.h"

namespace halflight {

namespace {

std::vector<const StressCase*> chosen(const std::string& name) {
  std::vector<const StressCase*> result;
  std::vector<std::string> valid;
  for (const StressCase& c : stress_cases()) {
    valid.push_back(c.name);
    if (name.empty() || name == "all" || name == c.name || name == c.id) result.push_back(&c);
  }
  valid.emplace_back("all");
  if (result.empty()) throw unknown_name("case", name, valid);
  return result;
}

Facts machine() {
  Messages messages;
  RenderSettings settings;
  settings.backend = Backend::none;
  const Session session(stress_cases().front().scene(), settings, messages);
  return machine_facts(session);
}

}  // namespace

int run_stress(const Options& options) {
  const std::vector<const StressCase*> cases = chosen(options.stress_case);
  if (options.output.empty() && options.stress_case.empty()) {
    write_standard_output(stress_list());
    return static_cast<int>(ExitCode::ok);
  }
  if (options.output.empty())
    throw usage_error("`halflight stress NAME` needs -o DIR, a folder for the results");
  check_report_folder(options.output);
  Interruption interruption;
  interruption.keep_what_there_is();
  set_thread_count(options.threads);
  Progress progress(!options.quiet);
  const std::vector<std::string> wanted =
      options.techniques == std::vector<std::string>{"all"} ? std::vector<std::string>{} : options.techniques;
  StressEffort effort;
  effort.quick = options.quick;
  if (options.seeds_given) effort.most_runs = options.seeds;

  StressReport report;
  report.quick = options.quick, report.machine = machine();
  Stopwatch watch;
  // The pictures are too small for all cores to share one: a case has a core of its own.
  std::vector<std::vector<StressResult>> results(cases.size());
  side_by_side(cases.size(), [&](size_t i) {
    if (interruption.requested()) return;
    results[i] = run_stress_case(*cases[i], effort, wanted, interruption.token(),
                                 [&](const std::string& what) { progress.show(what); });
  });
  for (std::vector<StressResult>& rows : results)
    std::move(rows.begin(), rows.end(), std::back_inserter(report.results));
  progress.hide();
  report.seconds = watch.seconds(), report.complete = !interruption.requested();

  const std::filesystem::path folder(options.output);
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed)
    throw Error(ExitCode::failure, fmt::format("{}: cannot write: {}", folder.string(), failed.message()));
  write_json((folder / "stress.json").string(), stress_json(report));
  write_text_atomically(folder / "stress.html", stress_page(report));
  write_standard_output(stress_table(report));
  return static_cast<int>(report.complete ? stress_exit_code(report) : ExitCode::interrupted);
}

}  // namespace halflight
