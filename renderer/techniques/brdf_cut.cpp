#include "techniques/brdf_cut.h"

#include <array>

#include "techniques/brdf_traced.h"

namespace halflight {

namespace {

constexpr std::array settings{
    SettingInfo{"brdf.brdf-samples", 64, 0, RayBundle::capacity, "counting rays a pixel, N_ρ"},
    SettingInfo{"brdf.tau", 16, 0, 1e6, "weight of the analytic estimate, in rays"},
    SettingInfo{"brdf.alpha", 0.05, 0, 1, "share of draws that ignore the BRDF"},
    SettingInfo{"brdf.estimator", 0, 0, 1,
                "continuous target: value of a ray, of all lobes or of the one it follows",
                brdf_estimator_names},
};

}  // namespace

std::span<const SettingInfo> brdf_settings() { return settings; }

void BrdfCut::prepare(const FrameView& frame) {
  cut = frame.tree->lights.empty() ? Cut() : equal_radiance_cut(*frame.tree, *frame.cut);
  parameters = planned(frame, {static_cast<uint32_t>(frame.settings->get("brdf.brdf-samples")),
                               static_cast<float>(frame.settings->get("brdf.tau")),
                               static_cast<float>(frame.settings->get("brdf.alpha"))});
}

void BrdfCut::count_held(const FrameView& frame, StageCounters& counters) const {
  counters[frame.cut_stage()].bytes += held_bytes(cut);
}

}  // namespace halflight
