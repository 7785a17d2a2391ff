#include "scene/brdf_batch.h"

#include <algorithm>

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

/// Křivánek eq. 4; cosⁿ from the difference to the mirror direction, as in `evaluate`.
struct PhongTerms {
  Vec3 wo, diffuse, peak;  ///< k_d/π, k_s (n + 2)/2π
  float exponent;
};

HALFLIGHT_SIMD_CLONES void phong_loop(const PhongTerms& terms, const BrdfBatch& batch) {
  const float *x = batch.x, *y = batch.y, *z = batch.z;
  float *red = batch.red, *green = batch.green, *blue = batch.blue;
  const PhongTerms t = terms;
#pragma GCC ivdep
  for (size_t i = 0; i < batch.count; ++i) {
    const float dx = x[i] + t.wo.x, dy = y[i] + t.wo.y, dz = z[i] - t.wo.z;
    const float half_square = 0.5f * (dx * dx + dy * dy + dz * dz);
    const float power = half_square < 1.0f ? exp_negative(t.exponent * log_of_complement(half_square)) : 0.0f;
    red[i] = t.diffuse.x + t.peak.x * power;
    green[i] = t.diffuse.y + t.peak.y * power;
    blue[i] = t.diffuse.z + t.peak.z * power;
  }
}

/// Ashikhmin & Shirley 2000, as in `evaluate`.
struct AshikhminTerms {
  Vec3 wo, f0, diffuse;  ///< diffuse with its factors that do not depend on wi
  float exponent_x, exponent_y;
  float scale;  ///< √((nu + 1)(nv + 1))/8π; 0 without a specular lobe
};

HALFLIGHT_SIMD_CLONES void ashikhmin_loop(const AshikhminTerms& terms, const BrdfBatch& batch) {
  const float *x = batch.x, *y = batch.y, *z = batch.z;
  float *red = batch.red, *green = batch.green, *blue = batch.blue;
  const AshikhminTerms t = terms;
#pragma GCC ivdep
  for (size_t i = 0; i < batch.count; ++i) {
    const float sx = t.wo.x + x[i], sy = t.wo.y + y[i], sz = t.wo.z + z[i];
    const float sum2 = sx * sx + sy * sy + sz * sz;
    const float length = std::sqrt(sum2 > 1e-30f ? sum2 : 1e-30f), inverse = 1.0f / length;
    const float hx = sx * inverse, hy = sy * inverse;
    const float half = 0.5f * length, complement = half < 1.0f ? 1.0f - half : 0.0f;
    const float complement2 = complement * complement, grazing = complement2 * complement2 * complement;

    const float hx2 = hx * hx, hy2 = hy * hy, flat = hx2 + hy2;
    const float sin2 = flat > 1e-12f ? flat : 1e-12f;
    const float exponent = 0.5f * (t.exponent_x * hx2 + t.exponent_y * hy2);
    const float power = exp_negative(exponent * (log_of_complement(sin2) / sin2));
    const float up = z[i] > t.wo.z ? z[i] : t.wo.z, cos_half = half > 1e-20f ? half : 1e-20f;
    const float specular = t.scale * power / (cos_half * up);

    const float low = 1.0f - 0.5f * z[i], low2 = low * low, diffuse = 1.0f - low2 * low2 * low;
    red[i] = t.diffuse.x * diffuse + (t.f0.x + (1.0f - t.f0.x) * grazing) * specular;
    green[i] = t.diffuse.y * diffuse + (t.f0.y + (1.0f - t.f0.y) * grazing) * specular;
    blue[i] = t.diffuse.z * diffuse + (t.f0.z + (1.0f - t.f0.z) * grazing) * specular;
  }
}

void evaluate_phong(const Brdf& brdf, Vec3 wo, const BrdfBatch& batch) {
  const float n = brdf.roughness.x;
  const Vec3 specular = brdf.has_specular() ? brdf.specular : Vec3(0);
  phong_loop({wo, brdf.diffuse * (1 / pi), specular * ((n + 2) / (2 * pi)), n}, batch);
}

void evaluate_ashikhmin(const Brdf& brdf, Vec3 wo, const BrdfBatch& batch) {
  const Vec2 n = brdf.roughness;
  const float low = 1 - 0.5f * wo.z, seen = 28 / (23 * pi) * (1 - square(square(low)) * low);
  const float scale = brdf.has_specular() ? std::sqrt((n.x + 1) * (n.y + 1)) / (8 * pi) : 0.0f;
  ashikhmin_loop({wo, brdf.specular, brdf.diffuse * (Vec3(1) - brdf.specular) * seen, n.x, n.y, scale},
                 batch);
}

/// Densities of the mixture of both lobes: `specular` × the lobe's own, and the rest by the cosine.
struct MixtureTerms {
  Vec3 wo;
  float specular, diffuse;  ///< with their normalisations; diffuse over π
  float x, y;               ///< GGX: 1/α along both axes; Phong: n; Ashikhmin–Shirley: nu, nv
};

HALFLIGHT_SIMD_CLONES void ggx_density(const MixtureTerms& terms, const BrdfBatch& batch) {
  const float *x = batch.x, *y = batch.y, *z = batch.z;
  float* pdf = batch.pdf;
  const MixtureTerms t = terms;
#pragma GCC ivdep
  for (size_t i = 0; i < batch.count; ++i) {
    const float up = z[i] > 1e-20f ? z[i] : 1e-20f;
    const float sx = t.wo.x + x[i], sy = t.wo.y + y[i], sz = t.wo.z + up;
    const float sum2 = sx * sx + sy * sy + sz * sz, bounded = sum2 > 1e-30f ? sum2 : 1e-30f;
    const float hx = sx * t.x, hy = sy * t.y, d = (hx * hx + hy * hy + sz * sz) / bounded;
    pdf[i] = t.specular / (d * d) + t.diffuse * up;
  }
}

HALFLIGHT_SIMD_CLONES void phong_density(const MixtureTerms& terms, const BrdfBatch& batch) {
  const float *x = batch.x, *y = batch.y, *z = batch.z;
  float* pdf = batch.pdf;
  const MixtureTerms t = terms;
#pragma GCC ivdep
  for (size_t i = 0; i < batch.count; ++i) {
    const float dx = x[i] + t.wo.x, dy = y[i] + t.wo.y, dz = z[i] - t.wo.z;
    const float half_square = 0.5f * (dx * dx + dy * dy + dz * dz);
    const float power = half_square < 1.0f ? exp_negative(t.x * log_of_complement(half_square)) : 0.0f;
    pdf[i] = t.specular * power + t.diffuse * (z[i] > 0.0f ? z[i] : 0.0f);
  }
}

HALFLIGHT_SIMD_CLONES void ashikhmin_density(const MixtureTerms& terms, const BrdfBatch& batch) {
  const float *x = batch.x, *y = batch.y, *z = batch.z;
  float* pdf = batch.pdf;
  const MixtureTerms t = terms;
#pragma GCC ivdep
  for (size_t i = 0; i < batch.count; ++i) {
    const float sx = t.wo.x + x[i], sy = t.wo.y + y[i], sz = t.wo.z + z[i];
    const float sum2 = sx * sx + sy * sy + sz * sz;
    const float length = std::sqrt(sum2 > 1e-30f ? sum2 : 1e-30f), inverse = 1.0f / length;
    const float hx = sx * inverse, hy = sy * inverse, half = 0.5f * length;
    const float hx2 = hx * hx, hy2 = hy * hy, flat = hx2 + hy2;
    const float sin2 = flat > 1e-12f ? flat : 1e-12f;
    const float power = exp_negative(0.5f * (t.x * hx2 + t.y * hy2) * (log_of_complement(sin2) / sin2));
    pdf[i] = t.specular * power / (half > 1e-20f ? half : 1e-20f) + t.diffuse * (z[i] > 0.0f ? z[i] : 0.0f);
  }
}

void mixture_densities(const Brdf& brdf, Vec3 wo, const BrdfBatch& batch) {
  const float specular = specular_probability(brdf, wo.z), n = brdf.roughness.x;
  MixtureTerms terms{wo, specular, (1 - specular) * (1 / pi), n, brdf.roughness.y};
  switch (brdf.model) {
    case BrdfModel::ggx:
      terms.x = 1 / std::max(brdf.roughness.x, 1e-4f), terms.y = 1 / std::max(brdf.roughness.y, 1e-4f);
      terms.specular *= ggx_density_over_distribution(brdf, wo) * terms.x * terms.y / pi;
      return ggx_density(terms, batch);
    case BrdfModel::phong:
      terms.specular *= (n + 1) / (2 * pi);
      return phong_density(terms, batch);
    case BrdfModel::ashikhmin_shirley:
      terms.specular *= std::sqrt((n + 1) * (brdf.roughness.y + 1)) / (8 * pi);
      return ashikhmin_density(terms, batch);
    case BrdfModel::none:
      std::fill_n(batch.pdf, batch.count, 0.0f);
  }
}

}  // namespace

void evaluate_batch(const Brdf& brdf, Vec3 wo, const BrdfBatch& batch) {
  if (batch.pdf) mixture_densities(brdf, wo, batch);
  switch (brdf.model) {
    case BrdfModel::ggx:
      return evaluate_ggx(brdf, wo, batch);
    case BrdfModel::phong:
      return evaluate_phong(brdf, wo, batch);
    case BrdfModel::ashikhmin_shirley:
      return evaluate_ashikhmin(brdf, wo, batch);
    case BrdfModel::none:
      break;
  }
  for (float* channel : {batch.red, batch.green, batch.blue}) std::fill_n(channel, batch.count, 0.0f);
}

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
