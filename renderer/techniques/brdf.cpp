// BRDF sampling alone: what Wang & Åkerlund 2009, §5 race against.
//
// Discrete target: members of S are drawn with q_k ∝ k_s ŝ_k + (k_d/π) cos θ_k Ω_k, without l_k; ŝ_k is
// counted over an analytic prior as in `bidirectional`, and a share α of the draws is ∝ A_k/(r_k² + R_k²), so
// that no lit member has probability 0. Leaves inside a cluster ∝ A_i, lit or not. Estimate: (1/N) Σ f cos θ
// L Ω V/P. Unbiased for the sum over S. Continuous target: brdf_traced.h.
#include "techniques/brdf_cut.h"
#include "techniques/brdf_traced.h"
#include "techniques/pixel_loop.h"

namespace halflight {

namespace {

class BrdfSampling final : public Technique {
 public:
  void prepare(const FrameView& frame) override {
    if (frame.target == Target::continuous)
      traced_.prepare(frame);
    else
      brdf_cut_.prepare(frame);
  }

  PassStats run_pass(const FrameView& frame, const PassRequest& request, Film& film) override {
    if (frame.target == Target::continuous) return traced_.run_pass(frame, request, film);
    return run_sampler_pass<CountedCut>(frame, request, film, [&] { return brdf_cut_.sampler(); });
  }

  void count_held(const FrameView& frame, StageCounters& counters) const override {
    if (frame.target == Target::discrete) brdf_cut_.count_held(frame, counters);
  }

  std::optional<PixelInspection> inspect(const FrameView& frame, const PassRequest& request,
                                         uint32_t pixel) override {
    if (frame.target == Target::continuous) return std::nullopt;
    FrameView blind = frame;
    blind.cut = &brdf_cut_.cut;
    return inspect_sampler(brdf_cut_.sampler(), blind, request, pixel);
  }

 private:
  BrdfCut brdf_cut_;
  BrdfTraced traced_;
};

StageSet own_stages(const SettingValues& values, Target target, const LightKinds& kinds) {
  if (target == Target::continuous) return StageSet().add(Stage::traced_brdf_rays, kinds.met_by_rays());
  return StageSet().add(Stage::cut).add(Stage::counted_brdf_rays, values.get("brdf.brdf-samples") > 0);
}

}  // namespace

TechniqueInfo brdf_technique() {
  return {"brdf",
          "BRDF alone",
          "Wang & Åkerlund 2009, §5",
          TargetSupport::both,
          Bias::unbiased,
          brdf_settings(),
          []() -> std::unique_ptr<Technique> { return std::make_unique<BrdfSampling>(); },
          "unbiased for the sum over S or the integral; blind to the light",
          own_stages,
          true};
}

}  // namespace halflight
