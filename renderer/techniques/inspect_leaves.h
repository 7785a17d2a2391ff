// `Technique::inspect` for samplers that tell the probability of one leaf at a time.
#pragma once

#include "techniques/pixel_loop.h"

namespace halflight {

/// A sampler whose draws of n have their own probabilities: P(i) is the expected number of draws of i, over
/// n.
template <class S>
concept TellsLeaves = LightSampler<S> && requires(const S& sampler, uint32_t leaf, uint32_t n) {
  { sampler.probability(leaf, n) } -> std::same_as<double>;
};

/// What a draw with probability P is weighed with.
inline float weight_of(double probability) { return static_cast<float>(1 / probability); }

template <TellsLeaves Sampler>
PixelInspection inspect_leaves(Sampler& sampler, const FrameView& frame, const PassRequest& request,
                               uint32_t pixel) {
  PixelInspection result;
  result.probability.assign(frame.tree->lights.size(), 0.0);
  result.weight.assign(frame.tree->lights.size(), 0.0f);
  RandomStream random = pixel_stream(frame, request, pixel);
  if (!sampler.begin_pixel(frame.gbuffer->texels[pixel], random)) return result;
  result.draws.resize(request.samples);
  sampler.draw(random, result.draws);
  for (uint32_t i = 0; i < frame.tree->lights.size(); ++i) {
    result.probability[i] = sampler.probability(i, request.samples);
    if (result.probability[i] > 0) result.weight[i] = weight_of(result.probability[i]);
  }
  return result;
}

}  // namespace halflight
