// What C++ and GLSL both know: binding points and the layout of structures in storage buffers (std430). Read by both.
#ifndef HALFLIGHT_SHARED_LAYOUT_H
#define HALFLIGHT_SHARED_LAYOUT_H

#ifdef __cplusplus
#include <cstddef>
#include <glm/glm.hpp>

namespace halflight::gpu {
using glm::ivec4;
using glm::mat4;
using glm::uvec2;
using glm::uvec4;
using glm::vec4;
using uint = unsigned int;
#endif

// Storage buffers.
#define BINDING_VERTICES 0
#define BINDING_INDICES 1
#define BINDING_TRIANGLES 2
#define BINDING_MATERIALS 3
#define BINDING_SRGB_TABLE 4
#define BINDING_LIGHTS 5
#define BINDING_SHADOW_VIEWS 6
#define BINDING_PICTURES 7
#define BINDING_POINTS 8
#define BINDING_RESULT 9
#define BINDING_TRIANGLE_MATERIALS 10
#define BINDING_FILTERED_LIGHT 11

// Texture units. The first seven are the material's textures, in the order of MATERIAL_*.
#define MATERIAL_BASE_COLOR 0
#define MATERIAL_METALLIC_ROUGHNESS 1
#define MATERIAL_NORMAL 2
#define MATERIAL_EMISSION 3
#define MATERIAL_SPECULAR 4
#define MATERIAL_SPECULAR_COLOR 5
#define MATERIAL_ANISOTROPY 6
#define MATERIAL_TEXTURES 7
#define UNIT_SHADOW_MAPS 7
#define UNIT_SHADOW_CUBES 8
#define UNIT_GBUFFER_IDS 9
#define UNIT_GBUFFER_VALUES 10  // and the four units that follow
#define UNIT_FILTERED_MAPS 15

// Targets of the G-buffer; the first is RGBA32UI (bits of the position, triangle), the others RGBA32F:
// shading normal, f90 | tangent, roughness.x | diffuse, roughness.y | specular, octahedral normal.x | emission, .y
#define GBUFFER_TARGETS 6
#define NO_TRIANGLE 0xffffffffu

// GpuTextureUse::look_up.y
#define TEXTURE_SRGB 1u
#define TEXTURE_NEAREST 2u
// GpuTextureUse::look_up.z and w
#define WRAP_REPEAT 0u
#define WRAP_MIRROR 1u
#define WRAP_CLAMP 2u

// GpuMaterial::kinds.x
#define MODEL_NONE 0u
#define MODEL_GGX 1u
#define MODEL_PHONG 2u
#define MODEL_ASHIKHMIN_SHIRLEY 3u
// GpuMaterial::kinds.y
#define ALPHA_OPAQUE 0u
#define ALPHA_MASK 1u
#define ALPHA_BLEND 2u
// GpuMaterial::kinds.z
#define MATERIAL_DOUBLE_SIDED 1u
#define MATERIAL_UNLIT 2u

// GpuLight::kinds.x
#define LIGHT_POINT 0u
#define LIGHT_SPOT 1u
#define LIGHT_DIRECTIONAL 2u

// 32-bit words of a Vertex.
#define VERTEX_WORDS 15u
#define VERTEX_NORMAL 3u
#define VERTEX_TANGENT 6u
#define VERTEX_UV 10u
#define VERTEX_COLOR 14u

// Lights with at least so many views are seen by the six faces of a cube: +x, −x, +y, −y, +z, −z.
#define CUBE_FACES 6u

#define LIGHT_POINT_GROUP 64
#define DIRECT_LIGHT_GROUP 8

struct GpuTextureUse {
  vec4 row_u;     // uv' = (row_u · (u, v, 1), row_v · (u, v, 1))
  vec4 row_v;
  uvec4 look_up;  // uv set, TEXTURE_* flags, wraps along u and v
};

struct GpuMaterial {
  vec4 base_color;
  vec4 diffuse;         // w: metallic
  vec4 phong_specular;  // w: roughness
  vec4 specular_color;  // w: specular
  vec4 emission;        // w: alpha cutoff
  vec4 exponents;       // z: anisotropy, w: its rotation
  vec4 others;          // index of refraction, normal scale
  uvec4 kinds;          // model, alpha mode, flags
  GpuTextureUse textures[MATERIAL_TEXTURES];
};

struct GpuLight {
  vec4 position;   // w: range, −1 where there is none
  vec4 direction;  // the way the light travels; w: slope of the cone's ramp
  vec4 up;         // w: cosine of the outer cone
  vec4 intensity;  // w: 1 / tan of the outer cone, for the picture
  uvec4 kinds;     // LIGHT_*, first pixel of the picture, its width, its height (0: no picture)
  uvec4 shadow;    // first GpuShadowView, their number (0: casts no shadow)
};

// One shadow map: a layer of an array. Depth d = near / z (perspective), 1 − z / far (orthographic).
struct GpuShadowView {
  vec4 origin;   // w: near plane, perspective; far plane, orthographic
  vec4 right;    // w: half width seen at z = 1 (perspective), or at all (orthographic)
  vec4 up;
  vec4 forward;
  uvec4 place;   // layer, 1 in the array of cube faces, 1 when orthographic, texels a side
};

// A surface point to light.
struct GpuPoint {
  vec4 position;
  vec4 normal;
};

// Light of the environment on what reflects diffusely, by the normal in the environment map's frame: nine spherical
// harmonics for each of the two diffuse terms.
#define SCHLICK_MEANS 32
struct GpuFilteredLight {
  vec4 lambert[9];    // irradiance
  vec4 ashikhmin[9];  // the same weighed with the part of their diffuse term that depends on the light
  float schlick_means[SCHLICK_MEANS];  // by the cosine of the view: `schlick_means` of filtered_environment.h
};

#ifdef __cplusplus
static_assert(sizeof(GpuFilteredLight) == 18 * 16 + SCHLICK_MEANS * 4);
static_assert(sizeof(GpuTextureUse) == 48);
static_assert(sizeof(GpuMaterial) == 8 * 16 + MATERIAL_TEXTURES * 48);
static_assert(sizeof(GpuLight) == 96);
static_assert(sizeof(GpuShadowView) == 80);
static_assert(sizeof(GpuPoint) == 32);
static_assert(offsetof(GpuMaterial, textures) == 128);
}  // namespace halflight::gpu
#endif

#endif
