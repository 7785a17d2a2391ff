#include "command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <fstream>
#include <map>

namespace halflight {

namespace {

/// One option as it was given, in order.
struct Given {
  const OptionInfo* info;
  std::string value;
};

/// What the words of the command line are, before any value is looked at.
struct Words {
  std::vector<Given> options;
  std::vector<std::string> operands;
};

const CommandInfo* find_command(std::string_view name) {
  for (const CommandInfo& info : command_table())
    if (info.name == name) return &info;
  return nullptr;
}

size_t operand_limit(Command command) {
  switch (command) {
    case Command::error:
      return 2;
    case Command::techniques:
    case Command::scenes:
      return 0;
    default:
      return 1;
  }
}

Error unknown_option(const std::string& word, Command command) {
  const std::string name = word.substr(0, word.find('='));
  const OptionInfo* nearest = nullptr;
  size_t distance = std::max<size_t>(2, name.size() / 4) + 1;
  for (const OptionInfo& info : option_table()) {
    const size_t d = edit_distance(name, "--" + std::string(info.name));
    if (d < distance) nearest = &info, distance = d;
  }
  const std::string_view command_name = command_info(command).name;
  if (nearest && distance == 0)
    return usage_error(fmt::format("`halflight {}` has no option {}", command_name, name));
  std::string message = fmt::format("unknown option '{}'", name);
  if (nearest && nearest->taken_by(command)) message += fmt::format("; did you mean '--{}'?", nearest->name);
  return usage_error(message + fmt::format(" (`halflight {} --help` lists them)", command_name));
}

/// `halflight --size 64x64 render` says what was meant, where it would look like a scene's name.
void check_command_comes_first(const std::vector<std::string>& operands) {
  std::error_code ignored;
  for (const std::string& word : operands)
    if (find_command(word) && !std::filesystem::exists(word, ignored))
      throw usage_error(fmt::format("the command comes first: halflight {} …", word));
}

/// Splits the words by CLI11, with the options this command takes.
Words split_words(Command command, const std::vector<std::string>& arguments) {
  CLI::App app;
  app.set_help_flag();
  app.allow_extras();
  std::map<const CLI::Option*, const OptionInfo*> rows;
  for (const OptionInfo& info : option_table()) {
    if (!info.taken_by(command)) continue;
    const std::string names = info.letter.empty() ? fmt::format("--{}", info.name)
                                                  : fmt::format("-{},--{}", info.letter, info.name);
    CLI::Option* option = nullptr;
    if (info.is_switch())
      option = app.add_flag(names)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    else
      option = app.add_option(names)->expected(1)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
    rows[option] = &info;
  }
  std::vector<std::string> operands;
  app.add_option("operands", operands);

  std::vector<std::string> reversed(arguments.rbegin(), arguments.rend());
  try {
    app.parse(reversed);
  } catch (const CLI::ArgumentMismatch& error) {
    // The message starts with the option's name and goes on in the library's own words.
    const std::string message = error.what();
    throw usage_error(fmt::format("{} expects a value", message.substr(0, message.find(':'))));
  } catch (const CLI::ParseError& error) {
    throw usage_error(error.what());
  }
  Words words;
  words.operands = operands;
  check_command_comes_first(operands);
  for (const std::string& word : app.remaining())
    if (word.size() > 1 && word.front() == '-' && word != "--") throw unknown_option(word, command);
  std::map<const CLI::Option*, size_t> taken;
  for (const CLI::Option* option : app.parse_order())
    if (const auto row = rows.find(option); row != rows.end())
      words.options.push_back({row->second, option->results().at(taken[option]++)});
  return words;
}

void set_operands(Options& options, const Words& words) {
  const size_t limit = operand_limit(options.command);
  const CommandInfo& info = command_info(options.command);
  if (words.operands.size() > limit)
    throw usage_error(fmt::format("unexpected argument '{}'; `halflight {}` takes {}", words.operands[limit],
                                  info.name, limit == 0 ? "no operands" : info.operands));
  if (options.command == Command::error) {
    if (words.operands.size() < 2) throw usage_error("`halflight error` needs an image and its reference");
    options.image = words.operands[0];
    options.reference = words.operands[1];
  } else if (options.command == Command::experiments) {
    if (!words.operands.empty()) options.experiment = words.operands[0];
  } else if (options.command == Command::stress) {
    if (!words.operands.empty()) options.stress_case = words.operands[0];
  } else if (!words.operands.empty()) {
    options.scene = words.operands[0];
    options.scene_given = true;
  }
}

/// A first word that is no command: a scene, or a slip of the keyboard.
void check_scene_or_command(const std::string& word) {
  std::error_code ignored;
  if (std::filesystem::exists(word, ignored) || word.find_first_of("./\\") != std::string::npos) return;
  std::vector<std::string> names;
  for (const CommandInfo& info : command_table()) names.emplace_back(info.name);
  for (const BuiltInScene& scene : built_in_scenes()) names.emplace_back(scene.name);
  if (std::find(names.begin(), names.end(), word) == names.end())
    throw unknown_name("command or scene", word, names);
}

bool asked(const Words& words, std::string_view name) {
  return std::any_of(words.options.begin(), words.options.end(),
                     [&](const Given& g) { return g.info->name == name; });
}

}  // namespace

Options parse_arguments(const std::vector<std::string>& arguments) {
  // The command is the first word; anything else is a scene or an option of the window.
  Options options;
  std::vector<std::string> rest = arguments;
  const CommandInfo* command = arguments.empty() ? nullptr : find_command(arguments.front());
  if (command) rest.erase(rest.begin());
  options.command = command ? command->id : Command::view;
  options.command_given = command != nullptr;

  // Questions about the program are answered whatever else is wrong.
  const Words words = split_words(options.command, rest);
  options.help = asked(words, "help");
  options.version = asked(words, "version");
  if (options.help || options.version) return options;

  if (!command && !words.operands.empty()) check_scene_or_command(words.operands.front());

  // Config first, so that the command line wins.
  for (const Given& given : words.options)
    if (given.info->name == "config") set_option(options, *given.info, given.value);
  if (!options.config.empty()) apply_config(options, options.config);
  for (const Given& given : words.options) set_option(options, *given.info, given.value);
  if (!options.technique_given && options.render.target == Target::discrete)
    options.render.technique = default_discrete_technique;
  if (options.completions.empty()) set_operands(options, words);
  return options;
}

}  // namespace halflight
