// halflight techniques: the registry, and with --settings what --set takes.
#include "commands/commands.h"
#include "commands/json_output.h"
#include "console.h"
#include "text_table.h"

namespace halflight {

namespace {

std::string_view bias_name(Bias bias) { return bias == Bias::unbiased ? "unbiased" : "biased"; }

/// A setting's value in words, where it has words.
std::string value_text(const SettingInfo& info, double value) {
  if (!info.choices.empty()) return std::string(info.choices[static_cast<size_t>(value)]);
  return fmt::format("{:.16g}", value);
}

std::string bounds_text(const SettingInfo& info) {
  if (!info.choices.empty()) return fmt::format("{}", fmt::join(info.choices, " | "));
  return fmt::format("{:.16g} to {:.16g}", info.low, info.high);
}

Json setting_json(const SettingInfo& info) {
  Json json{{"key", info.key}};
  if (info.choices.empty()) {
    json["default"] = info.value, json["low"] = info.low, json["high"] = info.high;
  } else {
    json["default"] = value_text(info, info.value);
    json["choices"] = std::vector<std::string>(info.choices.begin(), info.choices.end());
  }
  json["help"] = info.help;
  return json;
}

std::string technique_lines() {
  std::vector<std::vector<std::string>> rows;
  for (const TechniqueInfo& info : techniques())
    rows.push_back({std::string(info.id), std::string(info.title),
                    std::string(target_support_name(info.target)), std::string(bias_name(info.bias)),
                    std::string(info.source), std::string(info.note)});
  return text_table(rows);
}

std::string setting_lines() {
  std::vector<std::vector<std::string>> rows;
  for (const SettingInfo* info : all_settings())
    rows.push_back({std::string(info->key), value_text(*info, info->value), bounds_text(*info),
                    std::string(info->help)});
  return text_table(rows);
}

Json techniques_json() {
  Json list = Json::array();
  for (const TechniqueInfo& info : techniques()) {
    Json keys = Json::array();
    for (const SettingInfo& setting : info.settings) keys.push_back(setting.key);
    list.push_back({{"id", info.id},
                    {"title", info.title},
                    {"target", target_support_name(info.target)},
                    {"bias", bias_name(info.bias)},
                    {"device", info.device == Device::gpu ? "gpu" : "cpu"},
                    {"source", info.source},
                    {"note", info.note},
                    {"settings", keys}});
  }
  Json settings = Json::array();
  for (const SettingInfo* info : all_settings()) settings.push_back(setting_json(*info));
  return {{"techniques", list}, {"settings", settings}};
}

}  // namespace

int run_techniques(const Options& options) {
  check_writable(options.json);
  if (options.json != "-") write_standard_output(options.list_settings ? setting_lines() : technique_lines());
  if (!options.json.empty()) write_json(options.json, techniques_json());
  return static_cast<int>(ExitCode::ok);
}

}  // namespace halflight
