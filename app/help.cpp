#include "help.h"

#include <algorithm>
#include <vector>

namespace halflight {

namespace {

constexpr size_t columns = 100;
constexpr size_t help_column = 34;

/// `text` in lines of at most `columns`, each after the first indented to `indent`; the first starts at
/// `start`.
std::string wrap(std::string_view text, size_t start, size_t indent) {
  std::string result;
  size_t at = start;
  while (!text.empty()) {
    const size_t space = std::min(text.find(' '), text.size());
    const std::string_view word = text.substr(0, space);
    if (at > indent && at + 1 + word.size() > columns) {
      result += '\n' + std::string(indent, ' ');
      at = indent;
    } else if (at > indent) {
      result += ' ', ++at;
    }
    result += word;
    at += word.size();
    text.remove_prefix(std::min(space + 1, text.size()));
  }
  return result;
}

std::string entry(const std::string& left, const std::string& right) {
  std::string line = left;
  if (line.size() + 2 > help_column)
    line += '\n' + std::string(help_column, ' ');
  else
    line.resize(help_column, ' ');
  return line + wrap(right, help_column, help_column) + '\n';
}

std::string option_entry(const OptionInfo& info) {
  std::string left = info.letter.empty() ? "      " : fmt::format("  -{}, ", info.letter);
  left += fmt::format("--{}", info.name);
  if (!info.is_switch()) left += fmt::format(" {}", info.metavar);
  std::string right = option_help(info);
  if (const std::string text = option_default(info); !text.empty())
    right += fmt::format(" (default: {})", text);
  if (info.repeatable) right += "; may be repeated";
  return entry(left, right);
}

std::string operand_help(Command command) {
  switch (command) {
    case Command::view:
    case Command::render:
    case Command::compare:
    case Command::info: {
      std::vector<std::string> names;
      for (const BuiltInScene& scene : built_in_scenes()) names.emplace_back(scene.name);
      return entry("  SCENE", fmt::format("a .gltf or .glb file, or a built-in scene: {} (default: bedroom)",
                                          fmt::join(names, ", ")));
    }
    case Command::experiments:
      return entry("  NAME", "an experiment that `halflight experiments` lists, or `all`");
    case Command::stress:
      return entry("  NAME",
                   "a case that `halflight stress` lists, by name or number, or `all` (default: all)");
    case Command::error:
      return entry("  IMAGE", "the picture: .exr, .hdr or .png") +
             entry("  REFERENCE", "what it should be, of the same size");
    default:
      return "";
  }
}

std::string usage_line(const CommandInfo& info) {
  return fmt::format("halflight {}{}{}", info.name, info.operands.empty() ? "" : " ", info.operands);
}

}  // namespace

std::string overview_text() {
  std::string text =
      "halflight: many-light rendering for lighting design, on screen while it converges\n\n"
      "Usage: halflight [SCENE]                 open the window (same as `halflight view`)\n"
      "       halflight COMMAND [options]\n\n"
      "Commands\n";
  for (const CommandInfo& info : command_table())
    text += entry("  " + usage_line(info).substr(10), std::string(info.summary));
  text += "\nProgram\n";
  for (const OptionInfo& info : option_table())
    if (info.taken_by(Command::view) && info.group == find_option("help")->group) text += option_entry(info);
  text +=
      "\nExit codes: 0 fine, 1 failed while running, 2 wrong usage, 3 bad input, 4 no OpenGL, 5 a "
      "comparison\n"
      "asked for has failed, 130 interrupted.\n"
      "`halflight COMMAND --help` lists a command's options.\n";
  return text;
}

std::string help_text(Command command) {
  const CommandInfo& info = command_info(command);
  std::string text =
      fmt::format("Usage: {} [options]\n\n{}{}.\n", usage_line(info),
                  static_cast<char>(std::toupper(info.summary.front())), info.summary.substr(1));
  if (const std::string operands = operand_help(command); !operands.empty()) text += '\n' + operands;
  std::vector<std::string_view> groups;
  for (const OptionInfo& row : option_table())
    if (row.taken_by(command) && std::find(groups.begin(), groups.end(), row.group) == groups.end())
      groups.push_back(row.group);
  for (const std::string_view group : groups) {
    text += fmt::format("\n{}\n", group);
    for (const OptionInfo& row : option_table())
      if (row.group == group && row.taken_by(command)) text += option_entry(row);
  }
  return text;
}

}  // namespace halflight
