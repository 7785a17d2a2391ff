// The illumination cut as a distribution (Wang & Åkerlund 2009, §3.2), for techniques that build on it.
#pragma once

#include "lights/cut_distribution.h"

namespace halflight {

/// q_k ∝ Φ_k, leaves ∝ Φ_i: the same for every pixel. False when no light is lit.
bool build_illumination(const Cut&, CutDistribution&);

}  // namespace halflight
