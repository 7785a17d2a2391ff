// BRDFs for many directions at once, as arrays that vectorise: the same f as `evaluate` to rounding
// (scene/brdf.h).
#pragma once

#include <cstddef>

#include "scene/brdf.h"

namespace halflight {

/// Directions in the BRDF's local frame, and f's channels for them; `count` is a multiple of 16 of readable,
/// writable floats.
struct BrdfBatch {
  const float *x, *y, *z;
  float *red, *green, *blue;
  size_t count;
  float* pdf = nullptr;  ///< where wanted: the density of `sample`, as `evaluate_with_pdf` has it
};

/// f(wi, wo) of a GGX material without the cosine; `wo` is local with z > 0. Where wi.z ≤ 0 the result is
/// finite and means nothing.
void evaluate_ggx(const Brdf&, Vec3 wo, const BrdfBatch&);

/// The same of any model.
void evaluate_batch(const Brdf&, Vec3 wo, const BrdfBatch&);

}  // namespace halflight
