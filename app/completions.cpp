#include <algorithm>

#include "help.h"

namespace halflight {

namespace {

std::vector<std::string> command_names() {
  std::vector<std::string> names;
  for (const CommandInfo& info : command_table()) names.emplace_back(info.name);
  return names;
}

std::vector<std::string> scene_names() {
  std::vector<std::string> names;
  for (const BuiltInScene& scene : built_in_scenes()) names.emplace_back(scene.name);
  return names;
}

bool takes_scene(const CommandInfo& info) { return info.operands.find("SCENE") != std::string_view::npos; }

/// Values of an option as bash words: names, or files where it takes one.
std::string bash_values(const OptionInfo& info) {
  if (info.choices)
    return fmt::format("COMPREPLY=($(compgen -W '{}' -- \"$cur\"))", fmt::join(info.choices(), " "));
  const bool file = info.is_path || info.metavar == "FILE" || info.metavar == "FOLDER";
  return file ? "COMPREPLY=($(compgen -f -- \"$cur\"))" : "COMPREPLY=()";
}

std::string bash_script() {
  std::string script =
      "# Completions of halflight for bash: eval \"$(halflight --completions bash)\"\n"
      "_halflight() {\n"
      "  local cur=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]} command=${COMP_WORDS[1]}\n"
      "  case $previous in\n";
  for (const OptionInfo& info : option_table())
    if (!info.is_switch())
      script += fmt::format("    --{}{}) {}; return;;\n", info.name,
                            info.letter.empty() ? "" : fmt::format("|-{}", info.letter), bash_values(info));
  script += fmt::format(
      "  esac\n"
      "  local names=''\n"
      "  if [[ $COMP_CWORD == 1 ]]; then names='{}'; fi\n"
      "  case $command in\n",
      fmt::join(command_names(), " "));
  for (const CommandInfo& info : command_table()) {
    std::vector<std::string> words;
    if (takes_scene(info)) words = scene_names();
    for (const OptionInfo& row : option_table())
      if (row.taken_by(info.id)) words.push_back(fmt::format("--{}", row.name));
    script += fmt::format("    {}) names+=' {}';;\n", info.id == Command::view ? "view|*" : info.name,
                          fmt::join(words, " "));
  }
  // The catch-all of `view` comes last, whatever the table's order.
  const size_t view = script.find("    view|*)");
  const size_t end = script.find('\n', view) + 1;
  script += script.substr(view, end - view);
  script.erase(view, end - view);
  return script +
         "  esac\n"
         "  COMPREPLY=($(compgen -W \"$names\" -- \"$cur\"))\n"
         "  if [[ $cur != -* ]]; then COMPREPLY+=($(compgen -f -- \"$cur\")); fi\n"
         "}\n"
         "complete -o filenames -F _halflight halflight\n";
}

std::string fish_script() {
  std::string script = "# Completions of halflight for fish: halflight --completions fish | source\n";
  const std::string any = fmt::format("__fish_seen_subcommand_from {}", fmt::join(command_names(), " "));
  for (const CommandInfo& info : command_table())
    script += fmt::format("complete -c halflight -n 'not {}' -a {} -d '{}'\n", any, info.name, info.summary);
  for (const CommandInfo& info : command_table())
    if (takes_scene(info))
      script += fmt::format("complete -c halflight -n '__fish_seen_subcommand_from {}' -a '{}'\n", info.name,
                            fmt::join(scene_names(), " "));
  for (const OptionInfo& row : option_table()) {
    std::vector<std::string_view> takers;
    for (const CommandInfo& info : command_table())
      if (row.taken_by(info.id)) takers.push_back(info.name);
    std::string help = option_help(row);
    for (size_t at = 0; (at = help.find('\'', at)) != std::string::npos; at += 2) help.replace(at, 1, "\\'");
    std::string condition = fmt::format("__fish_seen_subcommand_from {}", fmt::join(takers, " "));
    if (row.taken_by(Command::view)) condition += fmt::format("; or not {}", any);
    script +=
        fmt::format("complete -c halflight -n '{}' -l {}{}{}{} -d '{}'\n", condition, row.name,
                    row.letter.empty() ? "" : fmt::format(" -s {}", row.letter), row.is_switch() ? "" : " -r",
                    row.choices ? fmt::format(" -f -a '{}'", fmt::join(row.choices(), " ")) : "", help);
  }
  return script;
}

}  // namespace

std::string completion_script(const std::string& shell) {
  if (shell == "bash") return bash_script();
  if (shell == "zsh") return "autoload -U +X bashcompinit && bashcompinit\n" + bash_script();
  if (shell == "fish") return fish_script();
  throw unknown_name("shell", shell, {"bash", "zsh", "fish"});
}

}  // namespace halflight
