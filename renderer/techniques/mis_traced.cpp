#include "techniques/mis_traced.h"

namespace halflight {

DrawAllocation::Shares mis_shares(const LightKinds& kinds, MisStrategy strategy, double brdf_share) {
  DrawAllocation::Shares shares{};
  const auto share = [&](DrawKind kind) -> double& { return shares[static_cast<size_t>(kind)]; };
  const bool hits = kinds.environment || kinds.emitters || kinds.surfaces;
  const double rays = strategy == MisStrategy::both ? brdf_share : strategy == MisStrategy::brdf ? 1 : 0;
  const bool lights = rays < 1;
  const int count = (lights && kinds.environment) + (lights && kinds.emitters) + (lights && kinds.surfaces) +
                    kinds.punctual;
  if (hits) share(DrawKind::brdf) = rays;
  if (count == 0) return shares;
  // Punctual light is met by no ray: it takes a draw in two where only BRDF rays are wanted.
  const double each = (lights ? 1 - rays : 1.0) / count;
  if (lights && kinds.environment) share(DrawKind::environment) = each;
  if (lights && kinds.emitters) share(DrawKind::emitters) = each;
  if (lights && kinds.surfaces) share(DrawKind::surfaces) = each;
  if (kinds.punctual) share(DrawKind::punctual) = each;
  return shares;
}

void MisTraced::prepare(const FrameView& frame) {
  lights_ = std::make_unique<LightSources>(*frame.scene, frame.kinds);
  const auto strategy = static_cast<MisStrategy>(static_cast<int>(frame.settings->get("mis.strategy")));
  parameters_.shares = mis_shares(frame.kinds, strategy, frame.settings->get("mis.brdf-share"));
}

PassStats MisTraced::run_pass(const FrameView& frame, const PassRequest& request, Film& film) const {
  return run_traced_pass(frame, request, film, *lights_, parameters_);
}

}  // namespace halflight
