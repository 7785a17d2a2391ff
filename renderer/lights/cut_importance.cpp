#include "lights/cut_importance.h"

#include "core/simd.h"

namespace halflight {

namespace {

/// The cut's arrays as pointers, and the point: what the loops below read.
struct View {
  const float *centre_x, *centre_y, *centre_z, *normal_x, *normal_y, *normal_z;
  const float *extent_x, *extent_y, *extent_z, *thickness;
  const float *power, *radius, *local, *normal_spread, *softening, *has_extent;
  float *importance, *guard, *arriving;
  Vec3 x;
  Basis basis;
  Vec3 wo;        ///< local
  float diffuse;  ///< luminance of k_d, over π
  float counted;  ///< share of the specular estimate left to counting
  PointSpread spread;
  float spread_radius;
};

/// A cluster from x.
struct Seen {
  Vec3 w;          ///< unit, towards its centre
  float arriving;  ///< Φ_k c'/(r² + a c'): l_k Ω_k, with c' widened by the box's extent
  float cosine;    ///< at x, the mean over the box: above 0 where any of it is above the horizon
  float reach;     ///< R/r
  float guard;
};

/// v or 0. Arithmetic: with a comparison more compilers see paths through a loop, and give up on vectors.
HALFLIGHT_INLINE float positive_part(float v) { return 0.5f * (v + std::abs(v)); }

/// v in [0, 1].
HALFLIGHT_INLINE float clamp_to_unit(float v) { return positive_part(v < 1.0f ? v : 1.0f); }

/// Mean of max(0, c + t) over t in [−e, e], at most 1: (c + e)²/4e where that reaches on both sides of 0.
HALFLIGHT_INLINE float mean_cosine(float c, float e) {
  const float above = positive_part((c < e ? c : e) + e);
  const float mean = above * above * (0.25f / (e + 1e-20f)) + positive_part(c - e);
  return mean < 1.0f ? mean : 1.0f;
}

HALFLIGHT_INLINE Seen see_cluster(const View& v, size_t k) {
  const float dx = v.centre_x[k] - v.x.x * v.local[k];
  const float dy = v.centre_y[k] - v.x.y * v.local[k];
  const float dz = v.centre_z[k] - v.x.z * v.local[k];
  const float length2 = dx * dx + dy * dy + dz * dz;
  const float r2 = length2 > 1e-36f ? length2 : 1e-36f;
  const float inverse_r = 1.0f / std::sqrt(r2);
  Seen seen;
  seen.w = Vec3(dx * inverse_r, dy * inverse_r, dz * inverse_r);
  seen.reach = (v.radius[k] + v.spread_radius * v.local[k]) * inverse_r + 2.0f * v.spread.normals;
  const float spread = inverse_r * v.local[k];
  const float ex = v.extent_x[k] * inverse_r, ey = v.extent_y[k] * inverse_r, ez = v.extent_z[k] * inverse_r;
  const float nx = v.normal_x[k], ny = v.normal_y[k], nz = v.normal_z[k];
  const float faces = nx * seen.w.x + ny * seen.w.y + nz * seen.w.z;
  const float wide_light = std::abs(nx) * (ex + v.spread.extent.x * spread) +
                           std::abs(ny) * (ey + v.spread.extent.y * spread) +
                           std::abs(nz) * (ez + v.spread.extent.z * spread);
  const float cos_light = clamp_to_unit(v.normal_spread[k] + wide_light - faces);
  // No cosine exceeds what the farthest member along the normal gives: a flat cluster in the point's own
  // plane gives nothing, however near it is and however it is turned (LightNode::extent_along).
  const Vec3 n = v.basis.normal;
  const float turned = std::abs(n.x * nx + n.y * ny + n.z * nz);
  const float box = std::abs(n.x) * ex + std::abs(n.y) * ey + std::abs(n.z) * ez;
  const float plate =
      (turned * v.thickness[k] + std::sqrt(positive_part(1.0f - turned * turned)) * v.radius[k]) * inverse_r;
  const float wide = (box < plate ? box : plate) + v.spread.height * spread + v.spread.normals;
  seen.cosine = mean_cosine(n.x * seen.w.x + n.y * seen.w.y + n.z * seen.w.z, wide);
  seen.arriving = v.power[k] * cos_light / (r2 + v.softening[k] * cos_light);
  seen.guard = v.power[k] / (r2 + v.radius[k] * v.radius[k] * v.local[k]);
  return seen;
}

HALFLIGHT_SIMD_CLONES void guard_loop(const View& v, size_t count) {
#pragma GCC ivdep
  for (size_t k = 0; k < count; ++k) v.guard[k] = see_cluster(v, k).guard;
}

HALFLIGHT_SIMD_CLONES void diffuse_loop(const View& v, size_t count) {
#pragma GCC ivdep
  for (size_t k = 0; k < count; ++k) {
    const Seen seen = see_cluster(v, k);
    v.guard[k] = seen.guard;
    v.arriving[k] = seen.arriving;
    v.importance[k] = seen.arriving * (v.diffuse * seen.cosine);
  }
}

struct PhongLobe {
  Vec3 axis;        ///< mirror direction of wo, world space
  float sharpness;  ///< λ = n
  float scale;      ///< k_s (n + 2)/2π
};

// A cluster as a spherical Gaussian of sharpness κ = 2 (r/R)²: 1/e of its peak at the edge of its bounds.
constexpr float least_sharpness = 0.5f, most_sharpness = 1e8f;

/// Product of two spherical Gaussians, the second normalised: ∫ e^{λ(ω·R − 1)} κ e^{κ(ω·μ − 1)}/(2π (1 −
/// e^{−2κ})) dω in its stable form (ESTIMATORS).
HALFLIGHT_INLINE float filtered_gaussian(Vec3 axis, float lambda, Vec3 mean, float kappa) {
  const float sx = lambda * axis.x + kappa * mean.x, sy = lambda * axis.y + kappa * mean.y,
              sz = lambda * axis.z + kappa * mean.z;
  const float dx = axis.x - mean.x, dy = axis.y - mean.y, dz = axis.z - mean.z;
  const float length = std::sqrt(sx * sx + sy * sy + sz * sz);
  const float d = length > 1e-3f ? length : 1e-3f;
  const float exponent = -lambda * (kappa / (d + lambda + kappa)) * (dx * dx + dy * dy + dz * dz);
  return exp_negative(exponent) * (kappa / d) * (1.0f - exp_negative(-2.0f * d)) /
         (1.0f - exp_negative(-2.0f * kappa));
}

HALFLIGHT_SIMD_CLONES void phong_loop(const View& v, const PhongLobe& lobe, size_t count) {
#pragma GCC ivdep
  for (size_t k = 0; k < count; ++k) {
    const Seen seen = see_cluster(v, k);
    v.guard[k] = seen.guard;
    v.arriving[k] = seen.arriving;
    const float reach2 = seen.reach * seen.reach;
    const float wide = 2.0f / (reach2 > 2e-8f ? reach2 : 2e-8f);
    const float kappa = wide > least_sharpness ? wide : least_sharpness;
    const float specular = lobe.scale * filtered_gaussian(lobe.axis, lobe.sharpness, seen.w, kappa);
    const float prior = 1.0f - v.counted * v.has_extent[k];
    v.importance[k] = seen.arriving * seen.cosine * (v.diffuse + prior * specular);
  }
}

/// A lobe of half vectors: the GGX distribution, and Ashikhmin–Shirley's with the GGX of the same curvature.
struct HalfVectorLobe {
  float width_x, width_y;    ///< α²/(1 − α²) along both axes
  float f0, f_rise;          ///< Schlick: F0 and f90 − F0, luminances
  float half_cosine_weight;  ///< 1: density of reflected directions is D/4(h·wo); 0: of visible normals
  float masking;             ///< α² of Smith's masking towards the light
};

// The lobe's importance goes in three steps over some clusters at a time. One loop would be so long that the
// processor holds one pass through it and no more, and waits for its chain of roots and divisions.

/// Some clusters seen from x.
struct SeenBlock {
  static constexpr size_t size = 64;
  alignas(64) float x[size], y[size], z[size], reach[size], cosine[size];
};

HALFLIGHT_SIMD_CLONES void see_block(const View& v, size_t first, size_t count, SeenBlock& block) {
#pragma GCC ivdep
  for (size_t i = 0; i < count; ++i) {
    const Seen seen = see_cluster(v, first + i);
    v.guard[first + i] = seen.guard;
    v.arriving[first + i] = seen.arriving;
    block.x[i] = seen.w.x, block.y[i] = seen.w.y, block.z[i] = seen.w.z;
    block.reach[i] = seen.reach, block.cosine[i] = seen.cosine;
  }
}

/// Their half vectors h, the cosines of those with wo, and the filtered lobe's M = diag(P) + (2/κ) J Jᵀ in
/// the plane of h.xy, J the derivative of h by the light's direction (Tokuyoshi et al. 2024). J Jᵀ = (I − h
/// hᵀ − e eᵀ)/|w + wo|² there, e the part of w across h; 2/κ = (R/r)².
struct HalfVectors {
  alignas(64) float x[SeenBlock::size], y[SeenBlock::size], z[SeenBlock::size], cosine[SeenBlock::size];
  alignas(64) float m_xx[SeenBlock::size], m_xy[SeenBlock::size], m_yy[SeenBlock::size];
};

HALFLIGHT_SIMD_CLONES void half_vector_block(const View& v, const HalfVectorLobe& its_lobe, size_t count,
                                             const SeenBlock& block, HalfVectors& half) {
  const Vec3 t = v.basis.tangent, b = v.basis.bitangent, n = v.basis.normal, o = v.wo;
  const HalfVectorLobe lobe = its_lobe;
#pragma GCC ivdep
  for (size_t i = 0; i < count; ++i) {
    const Vec3 w(block.x[i], block.y[i], block.z[i]);
    const float ix = w.x * t.x + w.y * t.y + w.z * t.z, iy = w.x * b.x + w.y * b.y + w.z * b.z,
                iz = w.x * n.x + w.y * n.y + w.z * n.z;
    const float sx = ix + o.x, sy = iy + o.y, sz = iz + o.z;
    const float sum2 = sx * sx + sy * sy + sz * sz;
    const float inverse = 1.0f / std::sqrt(sum2 > 1e-6f ? sum2 : 1e-6f);
    const float hx = sx * inverse, hy = sy * inverse, hz = sz * inverse;
    const float along = ix * hx + iy * hy + iz * hz;
    const float ex = ix - along * hx, ey = iy - along * hy;
    const float reach = block.reach[i] < 2.0f ? block.reach[i] : 2.0f;
    const float filter = reach * reach * inverse * inverse;
    half.x[i] = hx, half.y[i] = hy, half.z[i] = hz;
    half.cosine[i] = clamp_to_unit(hx * o.x + hy * o.y + hz * o.z);
    half.m_xx[i] = lobe.width_x + filter * (1.0f - hx * hx - ex * ex);
    half.m_yy[i] = lobe.width_y + filter * (1.0f - hy * hy - ey * ey);
    half.m_xy[i] = -filter * (hx * hy + ex * ey);
  }
}

/// α'² = (M + det M I)/n with n = 1 + tr M + det M, whose determinant is det M/n; with the quadratic form of
/// α'⁻² multiplied out, D = det M √det M √n/(π q²), q = hᵀ adj(M + det M I) h + h_z² det M.
HALFLIGHT_SIMD_CLONES void lobe_block(const View& v, const HalfVectorLobe& its_lobe, size_t first,
                                      size_t count, const SeenBlock& block, const HalfVectors& half) {
  const Vec3 o = v.wo;
  const HalfVectorLobe lobe = its_lobe;
  const float *arriving = v.arriving + first, *has_extent = v.has_extent + first;
  float* importance = v.importance + first;
  const float diffuse = v.diffuse, counted = v.counted;
#pragma GCC ivdep
  for (size_t i = 0; i < count; ++i) {
    const float hx = half.x[i], hy = half.y[i], hz = half.z[i], cos_half = half.cosine[i];
    const float m_xx = half.m_xx[i], m_yy = half.m_yy[i], m_xy = half.m_xy[i];
    const float det_m = m_xx * m_yy - m_xy * m_xy, least = lobe.width_x * lobe.width_y;
    const float det = det_m > least ? det_m : least;
    const float norm = 1.0f + m_xx + m_yy + det;
    const float a_xx = m_xx + det, a_yy = m_yy + det;
    const float q = a_yy * hx * hx - 2.0f * m_xy * hx * hy + a_xx * hy * hy + hz * hz * det;
    const float stretched2 =
        (o.x * o.x * a_xx + 2.0f * o.x * o.y * m_xy + o.y * o.y * a_yy) / norm + o.z * o.z;
    const float visible = 2.0f * (o.z + std::sqrt(stretched2)), reflected = 4.0f * cos_half;
    const float jacobian = visible + lobe.half_cosine_weight * (reflected - visible);
    const float complement = 1.0f - cos_half, complement2 = complement * complement;
    const float fresnel = lobe.f0 + lobe.f_rise * complement2 * complement2 * complement;
    const float det_over_q = det / q;
    const float density = det_over_q * det_over_q * std::sqrt(norm / det) * fresnel /
                          (pi * (jacobian > 1e-4f ? jacobian : 1e-4f));

    const float cosine = block.cosine[i];
    const float masked =
        2.0f * cosine / (cosine + std::sqrt(lobe.masking + (1.0f - lobe.masking) * cosine * cosine));
    const float prior = masked * (1.0f - counted * has_extent[i]);
    importance[i] = arriving[i] * (diffuse * cosine + prior * density);
  }
}

void half_vector_loop(const View& v, const HalfVectorLobe& lobe, size_t count) {
  SeenBlock block;
  HalfVectors half;
  for (size_t first = 0; first < count; first += SeenBlock::size) {
    const size_t size = std::min(SeenBlock::size, count - first);
    see_block(v, first, size, block);
    half_vector_block(v, lobe, size, block, half);
    lobe_block(v, lobe, first, size, block, half);
  }
}

View make_view(const Cut& cut, Vec3 x) {
  View v{};
  v.centre_x = cut.centre_x.data(), v.centre_y = cut.centre_y.data(), v.centre_z = cut.centre_z.data();
  v.normal_x = cut.normal_x.data(), v.normal_y = cut.normal_y.data(), v.normal_z = cut.normal_z.data();
  v.extent_x = cut.extent_x.data(), v.extent_y = cut.extent_y.data(), v.extent_z = cut.extent_z.data();
  v.thickness = cut.thickness.data();
  v.power = cut.power.data(), v.radius = cut.radius.data(), v.local = cut.local.data();
  v.normal_spread = cut.normal_spread.data(), v.softening = cut.softening.data();
  v.has_extent = cut.has_extent.data();
  v.x = x;
  return v;
}

/// α²/(1 − α²), bounded where α reaches 1.
float projected_width(float alpha) {
  const float a2 = square(std::max(alpha, 1e-4f));
  return a2 / std::max(1 - a2, 1e-4f);
}

/// The widths whose distribution falls like (n·h)^e near its peak: (1 + x²/P)⁻² against e^{−e x²/2}.
float width_of_exponent(float exponent) { return std::clamp(4 / (exponent + 1), 1e-8f, 1e4f); }

HalfVectorLobe half_vector_lobe(const Brdf& brdf) {
  constexpr float least_masking = 1e-3f;  // 0 below the horizon, near 1 a few degrees above it
  // Less than the lobe's own: of a cluster whose mean cosine is small some members may stand higher, and are
  // not to be missed.
  constexpr float share_of_masking = 0.25f;
  const float f0 = luminance(brdf.specular);
  if (brdf.model == BrdfModel::ggx)
    return {projected_width(brdf.roughness.x),
            projected_width(brdf.roughness.y),
            f0,
            std::max(brdf.f90 - f0, 0.0f),
            0,
            std::max(share_of_masking * brdf.roughness.x * brdf.roughness.y, least_masking)};
  return {width_of_exponent(brdf.roughness.x),
          width_of_exponent(brdf.roughness.y),
          f0,
          std::max(1 - f0, 0.0f),
          1,
          least_masking};
}

float diffuse_luminance(const Brdf& brdf) {
  const Vec3 passed = brdf.model == BrdfModel::phong ? Vec3(1) : Vec3(1) - brdf.specular;
  return std::max(0.0f, luminance(brdf.diffuse * passed));
}

}  // namespace

void analytic_importance(const Cut& cut, const GBufferTexel& texel, float counted,
                         const ClusterImportance& out, const PointSpread& spread) {
  View v = make_view(cut, texel.position);
  v.importance = out.importance.data(), v.guard = out.guard.data(), v.arriving = out.arriving.data();
  v.basis = texel.basis(), v.wo = v.basis.to_local(texel.wo);
  v.diffuse = diffuse_luminance(texel.brdf) / pi;
  v.counted = counted;
  v.spread = spread, v.spread_radius = glm::length(spread.extent);
  const size_t count = cut.padded_size();
  if (!texel.brdf.has_specular()) return diffuse_loop(v, count);
  if (texel.brdf.model == BrdfModel::phong) {
    const float n = std::max(texel.brdf.roughness.x, 1e-3f);
    const Vec3 mirror = v.basis.to_world({-v.wo.x, -v.wo.y, v.wo.z});
    return phong_loop(v, {mirror, n, luminance(texel.brdf.specular) * (n + 2) / (2 * pi)}, count);
  }
  half_vector_loop(v, half_vector_lobe(texel.brdf), count);
}

void guard_importance(const Cut& cut, Vec3 x, std::span<float> guard) {
  View v = make_view(cut, x);
  v.guard = guard.data();
  guard_loop(v, cut.padded_size());
}

void illumination_importance(const Cut& cut, std::span<float> importance) {
  const float extent = 0.5f * local_bounds(cut).diagonal();
  const float local_scale = extent > 0 ? 1 / square(extent) : 1.0f;
  for (size_t k = 0; k < cut.padded_size(); ++k)
    importance[k] = cut.power[k] * (cut.local[k] == 0 ? 1.0f : local_scale);
}

float specular_strength(const GBufferTexel& texel) {
  const Brdf& brdf = texel.brdf;
  const float f0 = luminance(brdf.specular);
  if (brdf.model == BrdfModel::phong) return f0;
  const float f90 = brdf.model == BrdfModel::ggx ? brdf.f90 : 1.0f;
  const float complement = std::clamp(1 - glm::dot(texel.shading_normal, texel.wo), 0.0f, 1.0f);
  return f0 + std::max(f90 - f0, 0.0f) * square(square(complement)) * complement;
}

float lobe_variance(const Brdf& brdf) {
  const float widest = std::max(brdf.roughness.x, brdf.roughness.y);
  switch (brdf.model) {
    case BrdfModel::ggx:
      return 2 * square(widest);
    case BrdfModel::phong:
      return 1 / (brdf.roughness.x + 1);
    case BrdfModel::ashikhmin_shirley:
      return 4 / (std::min(brdf.roughness.x, brdf.roughness.y) + 1);
    case BrdfModel::none:
      break;
  }
  return infinity;
}

bool has_narrow_lobe(const Brdf& brdf, const Cut& cut, float times) {
  return brdf.has_specular() && lobe_variance(brdf) * static_cast<float>(cut.size) < times;
}

}  // namespace halflight
