// From a point on a triangle to what light sees there: textures, normal map, BRDF parameters, emission,
// alpha. shaders/surface.glsl does the same on the GPU; a test holds the two against each other.
#pragma once

#include "scene/gbuffer.h"
#include "scene/scene.h"

namespace halflight {

/// A point of a triangle: `barycentric` weighs vertices 1 and 2.
struct SurfacePoint {
  uint32_t triangle;
  Vec2 barycentric;
};

/// Texture value at uv after the use's transform, linear RGBA; white where the use is empty. Bilinear (or
/// nearest) at full resolution with OpenGL's texel centres and wrap modes; sRGB texels are decoded before
/// they are filtered.
Vec4 texture_value(const Scene&, const TextureUse&, const Vec2 uv[2]);

/// Ask for what shading a triangle reads, which lies anywhere in memory: its indices and material, then, once
/// those are there, its corners.
void prefetch_triangle(const Scene&, uint32_t triangle);
void prefetch_corners(const Scene&, uint32_t triangle);

/// Position interpolated over the triangle.
Vec3 surface_position(const Scene&, SurfacePoint);

/// Coverage in [0, 1]: 1 for opaque materials, 0 or 1 for masks, base colour alpha for blends.
float surface_alpha(const Scene&, SurfacePoint);

/// Whether the point stands in the way of a ray: alpha against a hash of the point (Wyman & McGuire 2017,
/// hashed alpha testing). With `seed` fixed the scene is one fixed opaque scene; over seeds the mean is
/// blending.
bool surface_blocks(const Scene&, SurfacePoint, uint32_t seed);

/// Radiance emitted at the point towards `side` of the geometric normal (+1 front, −1 back); single-sided
/// materials emit from the front only. Unlit surfaces are seen by the camera but light nothing: 0.
Vec3 surface_emission(const Scene&, SurfacePoint, int side);

/// Everything a pixel keeps about the point, seen from unit direction `wo`. The front side's normals (vertex
/// normal on the winding's side, then the normal texture in the frame T ⟂ N, B = w · N × T) are turned
/// together to wo's side of the triangle; a shading normal n with n·wo < 1e-3 becomes normalize(n + (1e-3 −
/// n·wo) wo). Unlit: no BRDF, the base colour is the emission.
GBufferTexel shade_surface(const Scene&, SurfacePoint, Vec3 wo);

/// BRDF of a material with its textures at the point (normals aside). GGX: F0 of KHR_materials_ior and
/// specular mixed with the base colour by metallic, α = roughness², α_t = mix(α, 1, anisotropy²).
Brdf surface_brdf(const Scene&, SurfacePoint);

}  // namespace halflight
