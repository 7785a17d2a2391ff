// `brdf` in the continuous target: rays that follow the BRDF into the scene, and nothing else (Křivánek §2).
// See brdf.cpp for its source.
//
// Estimate: (1/N) Σ f cos θ L/p over directions of the whole mixture of lobes, or with brdf.estimator =
// chosen-lobe Křivánek's plain one, f_lobe cos θ L/(P_lobe p_lobe). L is the environment, the emission met,
// and light that the surface met returns, estimated afresh. Punctual light that is no handful cannot be met
// by rays and takes every other draw. Unbiased for the integral.
#pragma once

#include <memory>

#include "techniques/traced_loop.h"

namespace halflight {

inline constexpr std::array<std::string_view, 2> brdf_estimator_names{"whole", "chosen-lobe"};

class BrdfTraced {
 public:
  void prepare(const FrameView&);
  PassStats run_pass(const FrameView&, const PassRequest&, Film&) const;

 private:
  std::unique_ptr<LightSources> lights_;
  TracedParameters parameters_;
};

}  // namespace halflight
