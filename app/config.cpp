#include <nlohmann/json.hpp>

#include "command_line.h"
#include "scene/built_in_environments.h"
#include "scene/image_files.h"

namespace halflight {

namespace {

using nlohmann::json;

constexpr uint64_t largest_config = 1 << 20;
constexpr int deepest_config = 8;

json read_config(const std::filesystem::path& path) {
  const std::vector<uint8_t> bytes = read_file(path, largest_config);
  const auto shallow = [&](int depth, json::parse_event_t, json&) {
    if (depth > deepest_config) throw input_error(path.string(), "", "nested too deeply for a config file");
    return true;
  };
  try {
    json config = json::parse(bytes.begin(), bytes.end(), shallow);
    if (!config.is_object()) throw input_error(path.string(), "", "a config file holds one JSON object");
    return config;
  } catch (const json::exception& error) {
    throw input_error(path.string(), "", fmt::format("not JSON ({})", without_identifier(error.what())));
  }
}

/// A JSON scalar as the command line would spell it.
std::string scalar_text(const json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (value.is_boolean() || value.is_number()) return value.dump();
  throw usage_error(fmt::format("expects a string, number or boolean, not {}", value.type_name()));
}

std::string resolve(const std::filesystem::path& config, const std::string& file) {
  if (file == "-" || file.empty() || std::filesystem::path(file).is_absolute()) return file;
  return (config.parent_path() / file).string();
}

std::string resolve_scene(const std::filesystem::path& config, const std::string& name) {
  for (const BuiltInScene& scene : built_in_scenes())
    if (scene.name == name) return name;
  return resolve(config, name);
}

/// A built-in environment stays a name, unless a file of that name lies beside the config.
std::string resolve_environment(const std::filesystem::path& config, const std::string& name) {
  const std::string file = resolve(config, name);
  std::error_code fault;
  for (const BuiltInEnvironment& environment : built_in_environments())
    if (environment.name == name && !std::filesystem::exists(file, fault)) return name;
  return file;
}

void apply_scalar(Options& options, const OptionInfo& info, const json& value,
                  const std::filesystem::path& path) {
  const std::string text = scalar_text(value);
  if (info.name == "environment")
    info.set(options, resolve_environment(path, text));
  else
    info.set(options, info.is_path ? resolve(path, text) : text);
}

void apply_value(Options& options, const OptionInfo& info, const json& value,
                 const std::filesystem::path& path) {
  if (info.repeatable && value.is_object()) {
    for (const auto& [key, item] : value.items()) info.set(options, key + "=" + scalar_text(item));
  } else if (info.repeatable && value.is_array()) {
    for (const json& item : value) apply_scalar(options, info, item, path);
  } else {
    apply_scalar(options, info, value, path);
  }
}

bool only_on_the_command_line(const OptionInfo& info) {
  return info.name == "config" || info.name == "help" || info.name == "version" || info.name == "completions";
}

}  // namespace

void apply_config(Options& options, const std::filesystem::path& path) {
  const json config = read_config(path);
  for (const auto& [key, value] : config.items()) {
    const OptionInfo* info = find_option(key);
    try {
      if (key == "scene") {
        options.scene = resolve_scene(path, scalar_text(value));
        options.scene_given = true;
      } else if (!info || only_on_the_command_line(*info)) {
        std::vector<std::string> names{"scene"};
        for (const OptionInfo& row : option_table())
          if (!only_on_the_command_line(row)) names.emplace_back(row.name);
        throw unknown_name("key", key, names);
      } else {
        apply_value(options, *info, value, path);
      }
    } catch (const Error& error) {
      throw input_error(path.string(), key, error.what());
    }
  }
}

}  // namespace halflight
