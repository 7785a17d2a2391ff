#include "scene/brdf.h"

#include "core/warp.h"

namespace halflight {

namespace {

// A smooth material still has a lobe of finite width, so that densities stay finite and float directions
// resolve it.
constexpr float least_alpha = 1e-4f;

// Where both lobes can carry light, each is chosen at least this often: the albedos are estimates.
constexpr float least_lobe_probability = 0.02f;

float pow5(float x) {
  const float x2 = x * x;
  return x2 * x2 * x;
}

float pow5_of_complement(float x) { return pow5(std::clamp(1 - x, 0.0f, 1.0f)); }

/// Schlick 1994 with glTF's f90: F0 + (f90 − F0)(1 − cos)⁵.
Vec3 schlick(Vec3 f0, float f90, float cos_half) {
  return f0 + (Vec3(f90) - f0) * pow5_of_complement(cos_half);
}

Vec2 ggx_alpha(const Brdf& brdf) { return glm::max(brdf.roughness, Vec2(least_alpha)); }

/// The half vector of two local directions: `h` unit, and its cosine with either, which is half the sum's
/// length.
struct HalfVector {
  Vec3 h;
  float cos_half;
};

HalfVector half_vector(Vec3 wo, Vec3 wi) {
  const Vec3 sum = wo + wi;
  const float length = std::sqrt(std::max(glm::dot(sum, sum), 1e-30f));
  return {sum / length, std::min(0.5f * length, 1.0f)};
}

// ---- GGX (Walter et al. 2007; anisotropic and height-correlated as in Heitz 2014; glTF 2.0 appendix B) ----

/// Anisotropic D (Heitz 2014 eq. 85) from the components of the unit half vector; never from 1 − cos².
float ggx_distribution(Vec3 h, Vec2 alpha) {
  const float d = square(h.x / alpha.x) + square(h.y / alpha.y) + square(h.z);
  return 1 / (pi * alpha.x * alpha.y * d * d);
}

/// |(α_t x, α_b y, z)|: cos θ (1 + 2 Λ) in Smith's terms.
float ggx_stretched_length(Vec3 w, Vec2 alpha) {
  return std::sqrt(square(alpha.x * w.x) + square(alpha.y * w.y) + square(w.z));
}

/// How far below the horizon the reflected directions of visible normals reach, in units of the stretched
/// view cosine (Eto & Tokuyoshi 2023, "Bounded VNDF Sampling for Smith–GGX Reflections").
float ggx_cap_bound(Vec3 wo, Vec2 alpha) {
  const float a2 = square(std::min(1.0f, std::min(alpha.x, alpha.y)));
  const float s2 = square(1 + std::sqrt(square(wo.x) + square(wo.y)));
  return (1 - a2) * s2 / (s2 + a2 * square(wo.z));
}

/// Density of `ggx_sample` per solid angle of wi (Eto & Tokuyoshi 2023).
float ggx_pdf(Vec3 wo, float distribution, Vec2 alpha) {
  return distribution / (2 * (ggx_cap_bound(wo, alpha) * wo.z + ggx_stretched_length(wo, alpha)));
}

/// Reflection about a visible normal: uniform on a spherical cap of the stretched configuration (Dupuy &
/// Benyoub 2023), the cap cut to what can lie above the horizon.
Vec3 ggx_sample(Vec3 wo, Vec2 alpha, Vec2 u) {
  const Vec3 stretched = glm::normalize(Vec3(alpha.x * wo.x, alpha.y * wo.y, wo.z));
  const float lowest = ggx_cap_bound(wo, alpha) * stretched.z;
  const float z = (1 - u.y) * (1 + lowest) - lowest;
  const float r = std::sqrt(std::max(0.0f, 1 - z * z)), phi = 2 * pi * u.x;
  const Vec3 sum = stretched + Vec3(r * std::cos(phi), r * std::sin(phi), z);
  const Vec3 h = glm::normalize(Vec3(alpha.x * sum.x, alpha.y * sum.y, sum.z));
  return 2 * glm::dot(wo, h) * h - wo;
}

/// D·G₂/(4 cos θ_i cos θ_o), height-correlated (Heitz 2014 eq. 99).
float ggx_lobe(Vec3 wo, Vec3 wi, float distribution, Vec2 alpha) {
  return distribution * 0.5f /
         (wi.z * ggx_stretched_length(wo, alpha) + wo.z * ggx_stretched_length(wi, alpha));
}

// ---- Modified Phong (Lafortune & Willems 1994; Křivánek eq. 4) ----

/// cosⁿ of the angle between wi and the mirror direction, from their difference: 1 − cos loses all digits of
/// sharp lobes.
float phong_power(Vec3 wo, Vec3 wi, float exponent) {
  const float half_square = 0.5f * (square(wi.x + wo.x) + square(wi.y + wo.y) + square(wi.z - wo.z));
  return half_square < 1 ? std::exp(exponent * std::log1p(-half_square)) : 0.0f;
}

// ---- Ashikhmin & Shirley 2000 ----

/// (n·h)^((nu (h·u)² + nv (h·v)²)/(1 − (n·h)²)), the limit included where h meets the normal.
float ashikhmin_power(Vec3 h, Vec2 exponents) {
  const float sin2 = std::min(square(h.x) + square(h.y), 1 - 0x1p-24f);
  const float log_over_sin2 = sin2 > 1e-12f ? std::log1p(-sin2) / sin2 : -1.0f;
  return std::exp(0.5f * (exponents.x * square(h.x) + exponents.y * square(h.y)) * log_over_sin2);
}

float ashikhmin_normalisation(Vec2 exponents) { return std::sqrt((exponents.x + 1) * (exponents.y + 1)); }

/// Density of `ashikhmin_sample` per solid angle of wi: that of h over 4 h·k.
float ashikhmin_pdf(const HalfVector& half, Vec2 exponents) {
  return ashikhmin_normalisation(exponents) * ashikhmin_power(half.h, exponents) /
         (8 * pi * std::max(half.cos_half, 1e-20f));
}

/// A half vector, all four quadrants at once: tan φ = √((nu + 1)/(nv + 1)) tan 2πu.
std::optional<Vec3> ashikhmin_sample(Vec3 wo, Vec2 exponents, Vec2 u) {
  const Vec2 scaled(std::cos(2 * pi * u.x) * std::sqrt(exponents.y + 1),
                    std::sin(2 * pi * u.x) * std::sqrt(exponents.x + 1));
  const Vec2 direction = glm::normalize(scaled);
  const float power = 1 / (exponents.x * square(direction.x) + exponents.y * square(direction.y) + 1);
  const float log_complement = std::log1p(-u.y);
  const float sin_theta = std::sqrt(std::max(0.0f, -std::expm1(2 * power * log_complement)));
  const Vec3 h(sin_theta * direction, std::exp(power * log_complement));
  const float cos_half = glm::dot(wo, h);
  if (cos_half <= 0) return std::nullopt;
  return 2 * cos_half * h - wo;
}

/// Their diffuse term without its reflectances.
float ashikhmin_diffuse(float cos_i, float cos_o) {
  return 28 / (23 * pi) * (1 - pow5_of_complement(0.5f * cos_i)) * (1 - pow5_of_complement(0.5f * cos_o));
}

// ---- The two lobes together, in local coordinates, both directions above the horizon ----

float specular_density(const Brdf& brdf, Vec3 wo, Vec3 wi) {
  if (!brdf.has_specular()) return 0;
  switch (brdf.model) {
    case BrdfModel::ggx: {
      const Vec2 alpha = ggx_alpha(brdf);
      return ggx_pdf(wo, ggx_distribution(half_vector(wo, wi).h, alpha), alpha);
    }
    case BrdfModel::phong:
      return (brdf.roughness.x + 1) / (2 * pi) * phong_power(wo, wi, brdf.roughness.x);
    case BrdfModel::ashikhmin_shirley:
      return ashikhmin_pdf(half_vector(wo, wi), brdf.roughness);
    case BrdfModel::none:
      break;
  }
  return 0;
}

std::optional<Vec3> specular_direction(const Brdf& brdf, Vec3 wo, Vec2 u) {
  switch (brdf.model) {
    case BrdfModel::ggx:
      return ggx_sample(wo, ggx_alpha(brdf), u);
    case BrdfModel::phong:
      return basis_around({-wo.x, -wo.y, wo.z}).to_world(cosine_power_lobe(u, brdf.roughness.x));
    case BrdfModel::ashikhmin_shirley:
      return ashikhmin_sample(wo, brdf.roughness, u);
    case BrdfModel::none:
      break;
  }
  return std::nullopt;
}

/// f of each lobe and the specular lobe's density, which share their dear terms.
struct LobeValues {
  Vec3 diffuse, specular;
  float specular_pdf;

  Vec3 f() const { return diffuse + specular; }
};

LobeValues lobe_values(const Brdf& brdf, Vec3 wo, Vec3 wi) {
  switch (brdf.model) {
    case BrdfModel::ggx: {
      if (!brdf.has_specular()) return {brdf.diffuse * (1 / pi), Vec3(0), 0};
      const HalfVector half = half_vector(wo, wi);
      const Vec2 alpha = ggx_alpha(brdf);
      const Vec3 fresnel = schlick(brdf.specular, brdf.f90, half.cos_half);
      const Vec3 diffuse = (Vec3(1) - fresnel) * brdf.diffuse * (1 / pi);
      const float distribution = ggx_distribution(half.h, alpha);
      return {diffuse, fresnel * ggx_lobe(wo, wi, distribution, alpha), ggx_pdf(wo, distribution, alpha)};
    }
    case BrdfModel::phong: {
      const Vec3 diffuse = brdf.diffuse * (1 / pi);
      if (!brdf.has_specular()) return {diffuse, Vec3(0), 0};
      const float n = brdf.roughness.x;
      const float power = phong_power(wo, wi, n) / (2 * pi);
      return {diffuse, brdf.specular * ((n + 2) * power), (n + 1) * power};
    }
    case BrdfModel::ashikhmin_shirley: {
      const Vec3 diffuse = brdf.diffuse * (Vec3(1) - brdf.specular) * ashikhmin_diffuse(wi.z, wo.z);
      if (!brdf.has_specular()) return {diffuse, Vec3(0), 0};
      const HalfVector half = half_vector(wo, wi);
      const float density = ashikhmin_pdf(half, brdf.roughness);
      // Their specular term is the density times F/max(cos θ_i, cos θ_o).
      const Vec3 fresnel = schlick(brdf.specular, 1, half.cos_half);
      return {diffuse, fresnel * (density / std::max(wi.z, wo.z)), density};
    }
    case BrdfModel::none:
      break;
  }
  return {Vec3(0), Vec3(0), 0};
}

/// Fresnel reflectance of a whole rough surface seen at cos θ_o; roughness takes the grazing rise away.
Vec3 rough_fresnel(const Brdf& brdf, float cos_o) {
  const float smoothness = 1 - 0.5f * std::min(1.0f, brdf.roughness.x + brdf.roughness.y);
  return brdf.specular +
         glm::max(Vec3(brdf.f90) - brdf.specular, Vec3(0)) * (smoothness * pow5_of_complement(cos_o));
}

float choose_specular(const Brdf& brdf, float cos_o) {
  if (!brdf.has_specular()) return 0;
  if (max_component(brdf.diffuse) <= 0) return 1;
  Vec3 specular = brdf.specular, diffuse = brdf.diffuse;
  if (brdf.model == BrdfModel::ggx) {
    specular = rough_fresnel(brdf, cos_o);
    diffuse *= Vec3(1) - brdf.specular;
  } else if (brdf.model == BrdfModel::ashikhmin_shirley) {
    specular += (Vec3(1) - specular) * pow5_of_complement(cos_o);
    diffuse *= Vec3(1) - brdf.specular;
  }
  const float specular_luminance = luminance(specular);
  const float sum = specular_luminance + luminance(diffuse);
  if (!(sum > 0)) return 0.5f;
  return std::clamp(specular_luminance / sum, least_lobe_probability, 1 - least_lobe_probability);
}

float mixture_pdf(float choose_probability, float specular_pdf_value, float cos_i) {
  return choose_probability * specular_pdf_value + (1 - choose_probability) * cos_i * (1 / pi);
}

}  // namespace

Vec3 evaluate(const Brdf& brdf, const Basis& basis, Vec3 wo, Vec3 wi) {
  const Vec3 o = basis.to_local(wo), i = basis.to_local(wi);
  if (!(o.z > 0 && i.z > 0)) return Vec3(0);
  return lobe_values(brdf, o, i).f();
}

float pdf(const Brdf& brdf, const Basis& basis, Vec3 wo, Vec3 wi) {
  const Vec3 o = basis.to_local(wo), i = basis.to_local(wi);
  if (!(o.z > 0 && i.z > 0) || brdf.black()) return 0;
  return mixture_pdf(choose_specular(brdf, o.z), specular_density(brdf, o, i), i.z);
}

BrdfValue evaluate_with_pdf(const Brdf& brdf, const Basis& basis, Vec3 wo, Vec3 wi) {
  const Vec3 o = basis.to_local(wo), i = basis.to_local(wi);
  if (!(o.z > 0 && i.z > 0) || brdf.black()) return {Vec3(0), 0};
  const LobeValues values = lobe_values(brdf, o, i);
  return {values.f(), mixture_pdf(choose_specular(brdf, o.z), values.specular_pdf, i.z)};
}

namespace {

/// A direction of the mixture with the lobes' values there.
struct MixtureDraw {
  Vec3 wi;
  LobeValues values;
  float cos_i, specular_share;
  bool is_specular;
};

std::optional<MixtureDraw> draw_mixture(const Brdf& brdf, const Basis& basis, Vec3 wo, float choose, Vec2 u) {
  const Vec3 o = basis.to_local(wo);
  if (!(o.z > 0) || brdf.black()) return std::nullopt;
  const float specular_share = choose_specular(brdf, o.z);
  const bool is_specular = choose < specular_share;
  const std::optional<Vec3> drawn =
      is_specular ? specular_direction(brdf, o, u) : std::optional<Vec3>(cosine_hemisphere(u));
  if (!drawn || !(drawn->z > 0)) return std::nullopt;
  // The values belong to the direction as the caller gets it, rounded to world space.
  const Vec3 wi = glm::normalize(basis.to_world(*drawn));
  const Vec3 i = basis.to_local(wi);
  if (!(i.z > 0)) return std::nullopt;
  return MixtureDraw{wi, lobe_values(brdf, o, i), i.z, specular_share, is_specular};
}

}  // namespace

std::optional<BrdfSample> sample(const Brdf& brdf, const Basis& basis, Vec3 wo, float choose, Vec2 u) {
  const std::optional<MixtureDraw> draw = draw_mixture(brdf, basis, wo, choose, u);
  if (!draw) return std::nullopt;
  const float density = mixture_pdf(draw->specular_share, draw->values.specular_pdf, draw->cos_i);
  if (!(density > 0)) return std::nullopt;
  return BrdfSample{draw->wi, draw->values.f(), density};
}

std::optional<BrdfSample> sample_chosen_lobe(const Brdf& brdf, const Basis& basis, Vec3 wo, float choose,
                                             Vec2 u) {
  const std::optional<MixtureDraw> draw = draw_mixture(brdf, basis, wo, choose, u);
  if (!draw) return std::nullopt;
  const float density = draw->is_specular ? draw->specular_share * draw->values.specular_pdf
                                          : (1 - draw->specular_share) * draw->cos_i * (1 / pi);
  if (!(density > 0)) return std::nullopt;
  return BrdfSample{draw->wi, draw->is_specular ? draw->values.specular : draw->values.diffuse, density};
}

std::optional<Vec3> sample_specular(const Brdf& brdf, const Basis& basis, Vec3 wo, Vec2 u) {
  const Vec3 o = basis.to_local(wo);
  if (!(o.z > 0) || !brdf.has_specular()) return std::nullopt;
  const std::optional<Vec3> drawn = specular_direction(brdf, o, u);
  if (!drawn || !(drawn->z > 0)) return std::nullopt;
  return glm::normalize(basis.to_world(*drawn));
}

float specular_pdf(const Brdf& brdf, const Basis& basis, Vec3 wo, Vec3 wi) {
  const Vec3 o = basis.to_local(wo), i = basis.to_local(wi);
  if (!(o.z > 0 && i.z > 0)) return 0;
  return specular_density(brdf, o, i);
}

float specular_probability(const Brdf& brdf, const Basis& basis, Vec3 wo) {
  return choose_specular(brdf, std::max(0.0f, glm::dot(wo, basis.normal)));
}

float specular_probability(const Brdf& brdf, float cos_o) { return choose_specular(brdf, cos_o); }

float ggx_density_over_distribution(const Brdf& brdf, Vec3 wo) { return ggx_pdf(wo, 1, ggx_alpha(brdf)); }

Vec3 bounce_albedo(const Brdf& brdf) {
  if (brdf.model == BrdfModel::none) return Vec3(0);
  // Fresnel takes from the diffuse lobe what it reflects; Phong's two reflectances are independent.
  const Vec3 passed = brdf.model == BrdfModel::phong ? Vec3(1) : Vec3(1) - brdf.specular;
  return glm::clamp(brdf.diffuse * passed + brdf.specular, Vec3(0), Vec3(1));
}

}  // namespace halflight
