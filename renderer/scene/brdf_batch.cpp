#include "scene/brdf_batch.h"

#include "core/simd.h"

namespace halflight {

namespace {

/// What the loop needs of the BRDF and wo.
struct Lobe {
  Vec3 wo, f0, diffuse;  ///< diffuse over π
  float f90;
  float alpha_x, alpha_y, inverse_x, inverse_y;
  float scale;        ///< 1/(π α_x α_y); 0 without a specular lobe
  float stretched_o;  ///< |(α_x o_x, α_y o_y, o_z)|
};

// D (Heitz 2014 eq. 85) · G₂/(4 cos θ_i cos θ_o) (eq. 99) · F (Schlick), and the diffuse part that F leaves
// (glTF 2.0 appendix B).
HALFLIGHT_SIMD_CLONES void ggx_loop(const Lobe& lobe, const BrdfBatch& batch) {
  const float *x = batch.x, *y = batch.y, *z = batch.z;
  float *red = batch.red, *green = batch.green, *blue = batch.blue;
  const Lobe l = lobe;
#pragma GCC ivdep
  for (size_t i = 0; i < batch.count; ++i) {
    const float up = z[i] > 1e-20f ? z[i] : 1e-20f;
    const float sx = l.wo.x + x[i], sy = l.wo.y + y[i], sz = l.wo.z + up;
    const float sum2 = sx * sx + sy * sy + sz * sz;
    const float length = std::sqrt(sum2 > 1e-30f ? sum2 : 1e-30f);
    const float half = 0.5f * length, complement = half < 1.0f ? 1.0f - half : 0.0f;
    const float complement2 = complement * complement, grazing = complement2 * complement2 * complement;

    const float inverse = 1.0f / length;
    const float hx = sx * inverse * l.inverse_x, hy = sy * inverse * l.inverse_y, hz = sz * inverse;
    const float d = hx * hx + hy * hy + hz * hz;
    const float ax = l.alpha_x * x[i], ay = l.alpha_y * y[i];
    const float stretched_i = std::sqrt(ax * ax + ay * ay + up * up);
    const float specular = l.scale * 0.5f / (d * d) / (up * l.stretched_o + l.wo.z * stretched_i);

    const float f_r = l.f0.x + (l.f90 - l.f0.x) * grazing, f_g = l.f0.y + (l.f90 - l.f0.y) * grazing,
                f_b = l.f0.z + (l.f90 - l.f0.z) * grazing;
    red[i] = (1.0f - f_r) * l.diffuse.x + f_r * specular;
    green[i] = (1.0f - f_g) * l.diffuse.y + f_g * specular;
    blue[i] = (1.0f - f_b) * l.diffuse.z + f_b * specular;
  }
}

}  // namespace

void evaluate_ggx(const Brdf& brdf, Vec3 wo, const BrdfBatch& batch) {
  Lobe lobe;
  lobe.wo = wo, lobe.f0 = brdf.specular, lobe.f90 = brdf.f90;
  lobe.diffuse = brdf.diffuse * (1 / pi);
  lobe.alpha_x = std::max(brdf.roughness.x, 1e-4f), lobe.alpha_y = std::max(brdf.roughness.y, 1e-4f);
  lobe.inverse_x = 1 / lobe.alpha_x, lobe.inverse_y = 1 / lobe.alpha_y;
  lobe.scale = brdf.has_specular() ? lobe.inverse_x * lobe.inverse_y / pi : 0.0f;
  lobe.stretched_o = std::sqrt(square(lobe.alpha_x * wo.x) + square(lobe.alpha_y * wo.y) + square(wo.z));
  ggx_loop(lobe, batch);
}

}  // namespace halflight
