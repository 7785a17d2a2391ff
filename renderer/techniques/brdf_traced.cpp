#include "techniques/brdf_traced.h"

#include "techniques/mis_traced.h"

namespace halflight {

void BrdfTraced::prepare(const FrameView& frame) {
  lights_ = std::make_unique<LightSources>(*frame.scene, frame.kinds);
  parameters_.shares = mis_shares(frame.kinds, MisStrategy::brdf, 1);
  parameters_.brdf_estimator =
      static_cast<BrdfEstimator>(static_cast<int>(frame.settings->get("brdf.estimator")));
}

PassStats BrdfTraced::run_pass(const FrameView& frame, const PassRequest& request, Film& film) const {
  return run_traced_pass(frame, request, film, *lights_, parameters_);
}

}  // namespace halflight
