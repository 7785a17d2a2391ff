// Reflection at a point: modified Phong, Ashikhmin–Shirley and glTF's GGX behind one small value.
// All directions point away from the surface and are in world space; `cos` factors are never inside f.
#pragma once

#include <optional>

#include "core/math.h"
#include "scene/material.h"

namespace halflight {

/// The parameters of one point's BRDF; plain data, filled by raster and rays alike. Reflectances lie in [0,
/// 1].
struct Brdf {
  BrdfModel model = BrdfModel::none;
  Vec3 diffuse{0};   ///< k_d: diffuse reflectance (GGX: base colour × (1 − metallic))
  Vec3 specular{0};  ///< k_s: reflectance at normal incidence (F0; Phong: k_s)
  float f90 = 1;     ///< GGX: reflectance at grazing incidence
  Vec2 roughness{
      1};  ///< GGX: (α_t, α_b) in [0, 1], taken as at least 1e-4; Phong: n = x; Ashikhmin–Shirley: (nu, nv)

  /// Phong and Ashikhmin–Shirley with k_s = 0 have no specular lobe, not even its Fresnel rise at grazing
  /// angles.
  bool has_specular() const { return max_component(specular) > 0 || (model == BrdfModel::ggx && f90 > 0); }
  bool black() const { return model == BrdfModel::none || (max_component(diffuse) <= 0 && !has_specular()); }
};

/// A direction drawn from a BRDF.
struct BrdfSample {
  Vec3 wi;
  Vec3 f;     ///< whole BRDF (both lobes), without the cosine
  float pdf;  ///< per solid angle, of the whole mixture
};

/// f_r(wi, wo) per steradian, zero unless both are on the upper side of the basis normal. Sources: Křivánek
/// eq. 4 (Phong); Ashikhmin & Shirley 2000, both terms; glTF 2.0 appendix B (GGX; (1 − F) taken a component
/// at a time).
Vec3 evaluate(const Brdf& brdf, const Basis& basis, Vec3 wo, Vec3 wi);

/// Density of `sample` per solid angle: lobes chosen in proportion to `specular_probability`. Zero below the
/// horizon; its integral over the hemisphere is one less the share of draws that fail.
float pdf(const Brdf& brdf, const Basis& basis, Vec3 wo, Vec3 wi);

/// `evaluate` and `pdf` at once, which share their dear terms.
struct BrdfValue {
  Vec3 f;
  float pdf;
};
BrdfValue evaluate_with_pdf(const Brdf& brdf, const Basis& basis, Vec3 wo, Vec3 wi);

/// Draws from the mixture of both lobes; nothing when the draw falls below the horizon.
/// `choose` picks the lobe, `u` the direction; all uniform in [0, 1).
std::optional<BrdfSample> sample(const Brdf& brdf, const Basis& basis, Vec3 wo, float choose, Vec2 u);

/// As `sample`, but the lobe that was chosen stands for itself only: f is that lobe's and pdf its density
/// times its probability of being chosen (Křivánek §2.4). The mean of f cos θ L / pdf is the same.
std::optional<BrdfSample> sample_chosen_lobe(const Brdf& brdf, const Basis& basis, Vec3 wo, float choose,
                                             Vec2 u);

/// Draws a direction of the specular lobe alone (what Wang & Åkerlund's counting rays follow); nothing below
/// the horizon.
std::optional<Vec3> sample_specular(const Brdf& brdf, const Basis& basis, Vec3 wo, Vec2 u);

/// Density of `sample_specular` per solid angle.
float specular_pdf(const Brdf& brdf, const Basis& basis, Vec3 wo, Vec3 wi);

/// Probability of choosing the specular lobe, from estimates of the two albedos' luminances; constant for a
/// given wo. 0 or 1 only where a lobe is absent.
float specular_probability(const Brdf& brdf, const Basis& basis, Vec3 wo);

/// The same of a view cosine.
float specular_probability(const Brdf& brdf, float cos_o);

/// GGX: density of `sample_specular` over the distribution of normals D, for a local wo.
float ggx_density_over_distribution(const Brdf& brdf, Vec3 wo);

/// Angle-independent albedo used for the one bounce: diffuse + specular reflectance at normal incidence, ≤ 1.
/// What the Fresnel term reflects there (GGX, Ashikhmin–Shirley) does not reach the diffuse lobe.
Vec3 bounce_albedo(const Brdf& brdf);

}  // namespace halflight
