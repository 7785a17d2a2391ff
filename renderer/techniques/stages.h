// The stages of a frame: their names, which of them run, and counters of what they did. The plan, the
// session's counters, reports and tests all go by this one list.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace halflight {

enum class Stage : size_t {
  animation,
  gbuffer,
  antialiasing,
  alpha_filter,
  shadow_maps,
  direct_punctual,
  strata,
  environment_points,
  emitter_points,
  punctual_points,
  surface_points,
  pilot_set,
  light_tree,
  cut,
  near_clusters,
  counted_brdf_rays,
  traced_brdf_rays,
  learned_visibility,
  gpu_environment,
};
inline constexpr size_t stage_count = static_cast<size_t>(Stage::gpu_environment) + 1;

/// A name, and what the stage's calls are.
struct StageInfo {
  std::string_view name, calls;
};

inline constexpr std::array<StageInfo, stage_count> stage_infos{{
    {"animation", "animations posed"},
    {"g-buffer", "G-buffers made"},
    {"antialiasing", "G-buffers made on a moved pixel grid"},
    {"alpha filter", "crossings of a masked or blended triangle looked at"},
    {"shadow maps", "times that all of them were drawn"},
    {"direct punctual light", "G-buffers lit"},
    {"strata", "times they were made"},
    {"environment points", "sets drawn or lit"},
    {"emitter points", "sets drawn or lit"},
    {"punctual points", "sets drawn or lit"},
    {"surface points", "sets drawn or lit"},
    {"pilot set", "sets drawn and lit"},
    {"light tree", "trees built or lit again"},
    {"cut", "cuts refined"},
    {"near clusters", "blocks of pixels that a cut was refined for"},
    {"counted BRDF rays", "rays counted over the cut"},
    {"traced BRDF rays", "rays traced from a pixel's point"},
    {"learned visibility", "blocks of pixels that draws were steered in"},
    {"environment on the GPU", "pictures lit"},
}};

constexpr std::string_view stage_name(Stage stage) { return stage_infos[static_cast<size_t>(stage)].name; }

class StageSet {
 public:
  static constexpr StageSet all() {
    StageSet set;
    set.bits_ = (uint32_t{1} << stage_count) - 1;
    return set;
  }
  constexpr StageSet& add(Stage stage, bool wanted = true) {
    if (wanted) bits_ |= bit(stage);
    return *this;
  }
  constexpr bool has(Stage stage) const { return (bits_ & bit(stage)) != 0; }
  bool operator==(const StageSet&) const = default;

 private:
  static_assert(stage_count < 32);
  static constexpr uint32_t bit(Stage stage) { return uint32_t{1} << static_cast<size_t>(stage); }
  uint32_t bits_ = 0;
};

/// What a stage did and holds.
struct StageCounter {
  uint64_t calls = 0;
  uint64_t bytes = 0;  ///< held now, or during the last pass
  double seconds = 0;  ///< wall time, where it is measured apart
};

class StageCounters {
 public:
  StageCounter& operator[](Stage stage) { return counters_[static_cast<size_t>(stage)]; }
  const StageCounter& operator[](Stage stage) const { return counters_[static_cast<size_t>(stage)]; }
  StageCounters& operator+=(const StageCounters& o) {
    for (size_t i = 0; i < stage_count; ++i) {
      counters_[i].calls += o.counters_[i].calls, counters_[i].bytes += o.counters_[i].bytes;
      counters_[i].seconds += o.counters_[i].seconds;
    }
    return *this;
  }

 private:
  std::array<StageCounter, stage_count> counters_{};
};

}  // namespace halflight
