// `mis` in the continuous target: BRDF rays into the scene and light samples under one balance heuristic
// (Křivánek §4). See mis.cpp for its source.
//
// Of N draws a share β (mis.brdf-share, ½: equal N) are BRDF rays, which find every kind of light. The rest
// is shared out evenly among the kinds that the picture holds, each drawn in its own way: the environment
// from latitude-longitude tables, emitters by power and area, light returned by surfaces at points uniform by
// area, all stratified. A draw that met light of kind k is weighed with n_b p_b + n_k p_k, for no other light
// sample can meet that kind. Light that a surface returns is estimated afresh at each point met. Punctual
// light that is no handful is drawn one light at a time, weight 1. Unbiased for the integral.
#pragma once

#include <memory>

#include "techniques/traced_loop.h"

namespace halflight {

/// Which draws are taken: both, or one parent alone with weights of exactly 1, at the same N.
enum class MisStrategy { both, brdf, light };
inline constexpr std::array<std::string_view, 3> mis_strategy_names{"both", "brdf", "light"};

/// Shares of the draws for the light that the frame asks for.
DrawAllocation::Shares mis_shares(const LightKinds&, MisStrategy, double brdf_share);

class MisTraced {
 public:
  void prepare(const FrameView&);
  PassStats run_pass(const FrameView&, const PassRequest&, Film&) const;

 private:
  std::unique_ptr<LightSources> lights_;
  TracedParameters parameters_;
};

}  // namespace halflight
