// The environment as GPU Gems 3, chapter 20 (Colbert & Křivánek 2007) looks it up: scaled dual-paraboloid
// maps whose mip level follows from a sample's density, and spherical harmonics for diffuse reflection. All
// in the map's own frame: rotation and strength are applied where it is looked up.
#pragma once

#include <array>
#include <vector>

#include "scene/environment.h"

namespace halflight {

/// b of table 20-2: how much of the other hemisphere a map holds around its own.
inline constexpr float paraboloid_scale = 1.2f;

/// A point of the pair of maps: texture coordinates in [0, 1]², and 0 for the map of z ≥ 0, 1 for z < 0.
struct ParaboloidPoint {
  Vec2 st;
  int map;
};

/// Where a unit direction is looked up (table 20-2).
ParaboloidPoint paraboloid_point(Vec3 direction);

/// Unit direction of a point of one map; the inverse of `paraboloid_point` inside the circle of radius 1/2b
/// about the map's centre, which is its own hemisphere.
Vec3 paraboloid_direction(ParaboloidPoint);

/// Solid angle a unit of the map's area stands for at a direction of its own hemisphere (eq. 14):
/// 4 b² (1 + |z|)².
float paraboloid_distortion(Vec3 direction);

/// Eq. 13 with its bias: the mip level of maps of `size`² texels that averages what one of `samples` samples
/// of density `pdf` (per solid angle) stands for, at least 0, plus `bias`.
float filtered_level(int size, uint32_t samples, float pdf, float distortion, float bias);

/// Point i of the Hammersley set of n (eq. 10), in [0, 1)².
Vec2 hammersley(uint32_t i, uint32_t n);

/// Radiance of both maps, `size` texels a side, rows of increasing t.
struct ParaboloidMaps {
  int size = 0;
  std::array<std::vector<Vec4>, 2> texels;
};

/// Resamples the environment's map, each texel the mean of what it covers. `size` is a power of two.
ParaboloidMaps make_paraboloid_maps(const Environment&, int size);

/// Coefficients of the real spherical harmonics up to degree 2 (Ramamoorthi & Hanrahan 2001), ordered
/// l² + l + m.
using SphericalHarmonics = std::array<Vec3d, 9>;

/// The environment map's radiance projected on them.
SphericalHarmonics project_radiance(const Environment&);

/// Convolution with the kernel k(cos θ), 0 below the horizon, of degree l: 2π ∫₀¹ k(z) P_l(z) dz.
std::array<double, 3> zonal_convolution(double (*kernel)(double cosine));

/// ∫ L(ω) k(n·ω) dω as harmonics of n.
SphericalHarmonics convolve(const SphericalHarmonics& radiance, const std::array<double, 3>& kernel);

/// The basis at a unit direction.
std::array<float, 9> harmonics_at(Vec3 direction);

/// k(cos θ) of the diffuse terms: Lambert's cosine, and Ashikhmin & Shirley's (their eq. 5 without what
/// depends on the view) times it.
double lambert_kernel(double cosine);
double ashikhmin_kernel(double cosine);

/// Mean over a cosine-weighted hemisphere of (1 − cos of the half angle)⁵ seen at cosine μ: what Schlick's
/// Fresnel term takes of uniform light from the diffuse lobe. Entry i of n is μ = i/(n − 1).
std::array<float, 32> schlick_means();

}  // namespace halflight
