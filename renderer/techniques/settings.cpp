#include "techniques/settings.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "core/errors.h"
#include "techniques/technique.h"

namespace halflight {

namespace {

constexpr std::array shared_table{
    SettingInfo{"lights.count", 32768, 1, 1e6,
                "points placed for each kind of light; a surface point is a light on each side"},
    SettingInfo{"lights.seed", 0, 0, 9007199254740992.0, "positions of S in the discrete target"},
    SettingInfo{"lights.repulsion", 4, 0, 64,
                "steps that push surface points apart, of at most 131072 points; 0: stratified points"},
    SettingInfo{
        "lights.samples", 16, 0, 4096,
        "shadow rays that light a surface point from environment and emitters; of more points than 32768 "
        "each gets fewer, at least one"},
    SettingInfo{"cut.error", 0.05, 0, 1e6, "relative error a cluster of the cut may keep"},
    SettingInfo{"cut.sigma", 0, 0, 1e30,
                "above 0: the paper's absolute error per cluster instead (it uses 5)"},
    SettingInfo{"cut.least", 64, 1, 1e6, "clusters at least, for each kind of light"},
    SettingInfo{"cut.most", 1024, 1, 1e6,
                "clusters at most, for each kind of light (and not fewer than cut.least)"},
};

const SettingInfo& find_setting(std::string_view key) {
  const std::vector<const SettingInfo*> all = all_settings();
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const SettingInfo* info) { return info->key == key; });
  if (found != all.end()) return **found;
  std::vector<std::string> valid;
  for (const SettingInfo* info : all) valid.emplace_back(info->key);
  throw unknown_name("setting", key, valid);
}

double parse_choice(const SettingInfo& info, std::string_view value) {
  const auto found = std::find(info.choices.begin(), info.choices.end(), value);
  if (found != info.choices.end()) return static_cast<double>(found - info.choices.begin());
  throw unknown_name(fmt::format("value of {}", info.key), value, {info.choices.begin(), info.choices.end()});
}

double parse_number(const SettingInfo& info, std::string_view value) {
  double number = 0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (error != std::errc() || end != value.data() + value.size() || !std::isfinite(number))
    throw usage_error(fmt::format("{}: '{}' is not a number", info.key, value));
  if (number < info.low || number > info.high)
    throw usage_error(fmt::format("{}: {} is outside {} to {}", info.key, value, info.low, info.high));
  return number;
}

}  // namespace

std::span<const SettingInfo> shared_settings() { return shared_table; }

std::vector<const SettingInfo*> all_settings() {
  std::vector<const SettingInfo*> all;
  for (const SettingInfo& info : shared_settings()) all.push_back(&info);
  for (const TechniqueInfo& technique : techniques())
    for (const SettingInfo& info : technique.settings) all.push_back(&info);
  return all;
}

void SettingValues::set(std::string_view key, std::string_view value) {
  const SettingInfo& info = find_setting(key);
  const double number = info.choices.empty() ? parse_number(info, value) : parse_choice(info, value);
  if (number == info.value)
    values_.erase(std::string(key));
  else
    values_[std::string(key)] = number;
}

double SettingValues::get(std::string_view key) const {
  const auto found = values_.find(key);
  return found != values_.end() ? found->second : find_setting(key).value;
}

}  // namespace halflight
