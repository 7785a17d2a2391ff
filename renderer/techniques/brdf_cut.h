// What BRDF sampling alone sees of S: the cut's clusters without their light. Shared by `brdf` and `mis`.
#pragma once

#include "techniques/counted_cut.h"
#include "techniques/technique.h"

namespace halflight {

/// Settings "brdf.*".
std::span<const SettingInfo> brdf_settings();

struct BrdfCut {
  Cut cut;  ///< the frame's, with equal radiances
  CountedCutParameters parameters{};

  /// Reads the frame's tree, cut and settings.
  void prepare(const FrameView&);
  /// One thread's sampler; valid until the next `prepare`.
  CountedCut sampler() const { return CountedCut(cut, parameters); }
  void count_held(const FrameView&, StageCounters&) const;
};

}  // namespace halflight
