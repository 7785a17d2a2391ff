// Importance sampling from the illumination cut: Wang & Åkerlund 2009, §3.2. One distribution for all pixels,
// q_k ∝ Φ_k, leaves inside a cluster ∝ Φ_i. Unbiased for the sum over S; blind to the BRDF and to distance.
#include "techniques/illumination.h"

#include "lights/cut_importance.h"
#include "techniques/pixel_loop.h"

namespace halflight {

bool build_illumination(const Cut& cut, CutDistribution& distribution) {
  illumination_importance(cut, distribution.importance(cut));
  return distribution.build(cut, {}, 0);
}

namespace {

struct IlluminationSampler {
  const Cut* all;
  const CutDistribution* shared;
  bool drawable;

  bool begin_pixel(const GBufferTexel&, RandomStream&) { return drawable; }
  void draw(RandomStream& random, std::span<LightSample> out) const { shared->draw(*all, random, out); }
  const CutDistribution& distribution() const { return *shared; }
  const Cut& cut() const { return *all; }
};

class Illumination final : public Technique {
 public:
  void prepare(const FrameView& frame) override { drawable_ = build_illumination(*frame.cut, distribution_); }

  PassStats run_pass(const FrameView& frame, const PassRequest& request, Film& film) override {
    return run_sampler_pass<IlluminationSampler>(frame, request, film, [&] { return sampler(frame); });
  }

  std::optional<PixelInspection> inspect(const FrameView& frame, const PassRequest& request,
                                         uint32_t pixel) override {
    return inspect_sampler(sampler(frame), frame, request, pixel);
  }

 private:
  IlluminationSampler sampler(const FrameView& frame) const { return {frame.cut, &distribution_, drawable_}; }

  CutDistribution distribution_;
  bool drawable_ = false;
};

}  // namespace

TechniqueInfo illumination_technique() {
  return {"illumination",
          "Illumination cut as pdf",
          "Wang & Åkerlund 2009, §3.2",
          TargetSupport::both,
          Bias::unbiased,
          {},
          []() -> std::unique_ptr<Technique> { return std::make_unique<Illumination>(); },
          "unbiased for the sum over S; blind to the BRDF and to distance",
          reads_cut};
}

}  // namespace halflight
