// Arguments to a command; exceptions to an exit code.
#include <csignal>
#include <exception>
#include <filesystem>
#include <new>
#include <string>
#include <vector>

#include "command_line.h"
#include "commands/commands.h"
#include "commands/json_output.h"
#include "console.h"
#include "core/timeline.h"
#include "help.h"

namespace halflight {

namespace {

namespace fs = std::filesystem;

int run_command(const Options& options) {
  switch (options.command) {
    case Command::view:
      return run_view(options);
    case Command::render:
      return run_render(options);
    case Command::compare:
      return run_compare(options);
    case Command::experiments:
      return run_experiments(options);
    case Command::stress:
      return run_stress(options);
    case Command::info:
      return run_info(options);
    case Command::error:
      return run_error(options);
    case Command::techniques:
      return run_techniques(options);
    case Command::scenes:
      return run_scenes(options);
  }
  return static_cast<int>(ExitCode::usage);
}

/// Two results in one place would leave the later alone.
void check_outputs_apart(const Options& options) {
  const std::pair<std::string_view, std::string_view> outputs[] = {{"--output", options.output},
                                                                   {"--capture", options.capture},
                                                                   {"--json", options.json},
                                                                   {"--trace", options.trace}};
  const auto place = [](std::string_view name) { return fs::weakly_canonical(fs::absolute(name)); };
  for (const auto& [option, name] : outputs)
    for (const auto& [other, its_name] : outputs) {
      if (&other == &option || name.empty() || its_name.empty()) continue;
      std::error_code ignored;
      const bool device = fs::is_other(fs::status(name, ignored));
      if (name == "-" && its_name == "-")
        throw usage_error(
            fmt::format("{} and {}: only one of them can go to standard output", other, option));
      if (name != "-" && its_name != "-" && !device && place(name) == place(its_name))
        throw usage_error(fmt::format("{}: names the same file as {}", other, option));
    }
}

/// The command, with a timeline of it where one is asked for.
int run_traced(const Options& options) {
  check_outputs_apart(options);
  if (options.trace.empty()) return run_command(options);
  check_writable(options.trace);
  const Timeline timeline;
  const int code = run_command(options);
  write_text(options.trace, timeline.json());
  return code;
}

int run(const std::vector<std::string>& arguments) {
  const Options options = parse_arguments(arguments);
  if (options.help)
    write_standard_output(options.command_given ? help_text(options.command) : overview_text());
  else if (options.version)
    write_standard_output("halflight " HALFLIGHT_VERSION "\n");
  else if (!options.completions.empty())
    write_standard_output(completion_script(options.completions));
  else
    return run_traced(options);
  return static_cast<int>(ExitCode::ok);
}

int fail(ExitCode code, std::string_view message) {
  print_error(message);
  return static_cast<int>(code);
}

}  // namespace

}  // namespace halflight

int main(int argc, char** argv) {
  using namespace halflight;
  // A full pipe or disk shows as a failed write, which can be reported.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  try {
    return run(std::vector<std::string>(argv + (argc > 0), argv + argc));
  } catch (const Error& error) {
    return fail(error.code(), error.what());
  } catch (const std::bad_alloc&) {
    return fail(ExitCode::failure, "out of memory");
  } catch (const std::exception& error) {
    return fail(ExitCode::failure, error.what());
  }
}
