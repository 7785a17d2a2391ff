// The one option table: command line, config files, help, shell completions and the window's labels are made
// of it.
//
// To add an option: a field of `Options` and a row in options.cpp.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "report/race.h"
#include "scene/load.h"
#include "session.h"

namespace halflight {

/// What the program can be asked to do. An option's row says which commands take it.
enum class Command : uint32_t { view, render, compare, experiments, stress, info, error, techniques, scenes };

/// A command's name on the command line, its operands and one line of help.
struct CommandInfo {
  Command id;
  std::string_view name, operands, summary;
};

std::span<const CommandInfo> command_table();
const CommandInfo& command_info(Command);

/// A racer of its own: a technique with settings that differ from the race's.
struct TechniqueVariant {
  std::string name;  ///< in tables and file names
  std::string technique;
  std::vector<std::pair<std::string, std::string>> settings{};
};

/// Everything a user has asked for; the defaults are the program's.
struct Options {
  Command command = Command::view;
  bool command_given = false;  ///< named, rather than the default

  // Operands.
  std::string scene = "bedroom";  ///< a file or a built-in name
  bool scene_given = false;       ///< else a view may name another one
  std::string experiment;         ///< a name or `all`; empty lists them
  std::string stress_case;        ///< a name, an id or `all`
  std::string image, reference;   ///< of `error`; compare: a reference from elsewhere

  // Scene.
  std::optional<std::string> environment;
  std::optional<float> environment_rotation;  ///< radians
  std::optional<float> environment_strength;
  std::string camera;  ///< a name or an index; empty: the scene's first
  std::string view;    ///< FILE or FILE#NAME
  LoadOptions load;

  // Picture and sampling. At least one of `samples`, `seconds` and `until_error` ends a picture.
  RenderSettings render;
  bool size_given = false;
  std::optional<uint32_t> samples;  ///< a pixel
  std::optional<double> seconds;
  std::optional<double> until_error;  ///< estimated relMSE
  std::optional<bool> adaptive;       ///< else only with `until_error`
  int threads = 0;                    ///< 0: all cores
  bool technique_given = false;       ///< `render.technique` was asked for by name

  // Races.
  std::vector<std::string> techniques{"all"};
  std::vector<TechniqueVariant> variants;        ///< race beside them: experiments only
  std::vector<double> budgets{0.5, 1, 2, 4, 8};  ///< seconds, samples a pixel or rays a pixel
  Equal equal = Equal::time;
  uint32_t seeds = 5;
  bool seeds_given = false;    ///< else a stress case has its own
  bool budgets_given = false;  ///< else an experiment has its own
  bool no_discretisation = false;
  bool quick = false;  ///< experiments, stress: small pictures and few samples

  // Display: PNG and window only.
  std::optional<float> ev;
  std::string tonemap = "linear";

  // Output.
  std::string output, json, config;
  std::string trace;    ///< a timeline of stages and tiles
  std::string capture;  ///< view: a PNG of the window's content instead of a window
  bool aovs = false, quiet = false, strict = false;
  bool list_settings = false;                              ///< techniques --settings
  std::string write_folder;                                ///< scenes --write
  std::vector<std::pair<std::string, double>> fail_above;  ///< error: metric and bound

  // Questions about the program itself, answered before anything else.
  bool help = false, version = false;
  std::string completions;  ///< a shell's name
};

/// A row of the table. `set` throws Error (exit code 2) with the reason a value is refused, without the
/// option's name.
struct OptionInfo {
  std::string_view name;          ///< without dashes: the key of a config file
  std::string_view letter;        ///< one-letter form, or empty
  std::string_view metavar;       ///< empty: a switch
  std::string_view default_text;  ///< as help shows it; empty: none
  std::string_view group;         ///< heading in help
  std::string_view label;         ///< in the window
  std::string_view help;          ///< "{choices}" in it stands for the valid values
  uint32_t commands;              ///< bits 1 << Command
  void (*set)(Options&, const std::string& value);
  bool repeatable = false;                          ///< may be given several times
  bool is_path = false;                             ///< in a config file, relative to that file
  std::vector<std::string> (*choices)() = nullptr;  ///< valid values, where they are names
  std::string_view setting = "";                    ///< key of the setting that this is another name for

  bool is_switch() const { return metavar.empty(); }
  bool taken_by(Command command) const { return (commands >> static_cast<uint32_t>(command)) & 1; }
};

std::span<const OptionInfo> option_table();
/// Null when there is none of that name (without dashes).
const OptionInfo* find_option(std::string_view name);

/// The row's help with the valid values in place of "{choices}".
std::string option_help(const OptionInfo&);
/// The default as help shows it; empty: none.
std::string option_default(const OptionInfo&);

/// Sets one option from its text. Throws Error (exit code 2) naming the option and the reason.
void set_option(Options&, const OptionInfo&, const std::string& value);

/// "egl" for Backend::egl and so on; the words of `--backend` and of reports.
std::string_view backend_name(Backend);
std::string_view light_selection_name(LightSelection);
std::string_view target_support_name(TargetSupport);

/// Names of the metrics of `halflight error`, as `--fail-above` takes them.
std::span<const std::string_view> metric_names();

}  // namespace halflight
