// Numbers a user can set with `--set KEY=VALUE`: one table gives CLI, config files, help and the window's
// sliders.
#pragma once

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace halflight {

struct SettingInfo {
  std::string_view key;  ///< "group.name"; groups are lights, cut and technique ids
  double value;          ///< default; for a choice, its index
  double low, high;      ///< bounds, inclusive
  std::string_view help;
  std::span<const std::string_view> choices{};  ///< named values instead of numbers
};

/// Settings of the light set and the cut, shared by all techniques: lights.count, lights.seed,
/// lights.repulsion, lights.samples, cut.error, cut.sigma, cut.least, cut.most.
std::span<const SettingInfo> shared_settings();
/// Shared settings and those of every technique, in listing order.
std::vector<const SettingInfo*> all_settings();

/// Values a user has set; everything else has its default.
class SettingValues {
 public:
  /// Throws Error (exit code 2) for an unknown key, a value that is no number or choice, or one out of
  /// bounds.
  void set(std::string_view key, std::string_view value);
  /// `key` must exist in the table.
  double get(std::string_view key) const;
  const std::map<std::string, double, std::less<>>& changed() const { return values_; }
  bool operator==(const SettingValues&) const = default;

 private:
  std::map<std::string, double, std::less<>> values_;
};

}  // namespace halflight
