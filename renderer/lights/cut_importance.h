// How much each cluster of a cut may send through a pixel: light × BRDF × solid angle without visibility,
// over all clusters at once (ESTIMATORS: "Analytic product over the cut").
#pragma once

#include <span>

#include "lights/light_tree.h"
#include "scene/gbuffer.h"

namespace halflight {

/// Importances and what the counting of rays adds to them; `padded_size` floats each, in units of the cut's
/// power_unit.
struct ClusterImportance {
  std::span<float> importance;  ///< q̂_k
  std::span<float> guard;       ///< u_k before normalisation: Φ_k/(r_k² + R_k²), at infinity Φ_k
  std::span<float> arriving;    ///< l_k Ω_k(x): 0 where the members face away from x
};

/// Neighbouring points that share importances, about the one they are made for. Cosines are then about what
/// the best-placed of them may have, so that hardly a cluster is 0 which one of them sees; the guard has
/// those.
struct PointSpread {
  Vec3 extent{0};     ///< each axis, to the farthest
  float height = 0;   ///< along the point's shading normal
  float normals = 0;  ///< length of the largest difference between shading normals
};

/// q̂_k = l_k Ω_k [k_s (1 − s) D_k + (k_d/π) cos θ_k], D_k the specular lobe's density filtered by the
/// cluster's extent, and s = `counted` the share of the specular estimate that counting adds for clusters a
/// ray can hit.
void analytic_importance(const Cut&, const GBufferTexel&, float counted, const ClusterImportance&,
                         const PointSpread& = {});

/// The guard alone.
void guard_importance(const Cut&, Vec3 x, std::span<float> guard);

/// Importance of §3.2, the same for every point: Φ_k at infinity; Φ_k over the square of the local lights'
/// extent, so that near and far light compare in any unit of length.
void illumination_importance(const Cut&, std::span<float> importance);

/// Luminance of what the specular lobe reflects in all, seen from the texel's wo.
float specular_strength(const GBufferTexel&);

/// Variance of the specular lobe's directions along its wider axis, radians²: 1/n for a Phong lobe.
float lobe_variance(const Brdf&);

/// Whether there is a specular lobe, with less than `times` the variance of a cluster: K clusters that share
/// the sphere have one of about 1/K radians² each along an axis.
bool has_narrow_lobe(const Brdf&, const Cut&, float times);

}  // namespace halflight
