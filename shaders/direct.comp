// D_punctual of the G-buffer drawn last: Σ f · cos θ · E · visibility over the punctual lights.
#include "shared_layout.h"
#include "brdf.glsl"
#include "octahedral.glsl"
#include "punctual.glsl"

layout(local_size_x = DIRECT_LIGHT_GROUP, local_size_y = DIRECT_LIGHT_GROUP) in;

layout(std430, binding = BINDING_MATERIALS) readonly buffer Materials { GpuMaterial materials[]; };
layout(std430, binding = BINDING_TRIANGLE_MATERIALS) readonly buffer TriangleMaterials { uint triangle_materials[]; };
layout(std430, binding = BINDING_RESULT) writeonly buffer Result { float radiance[]; };
layout(binding = UNIT_GBUFFER_IDS) uniform usampler2D position_triangle;
layout(binding = UNIT_GBUFFER_VALUES) uniform sampler2D gbuffer_values[GBUFFER_TARGETS - 1];

uniform vec3 eye, ray_back;
uniform int orthographic;
uniform uint picture_width;
// Rows are lit in bands, each with a result buffer's worth of pixels.
uniform uint first_row, row_count;

vec3 shade(ivec2 pixel) {
  uvec4 ids = texelFetch(position_triangle, pixel, 0);
  if (ids.w == NO_TRIANGLE) return vec3(0.0);
  uint material = triangle_materials[ids.w];
  vec4 normal_f90 = texelFetch(gbuffer_values[0], pixel, 0), tangent_r = texelFetch(gbuffer_values[1], pixel, 0);
  vec4 diffuse_r = texelFetch(gbuffer_values[2], pixel, 0), specular_n = texelFetch(gbuffer_values[3], pixel, 0);
  Brdf brdf;
  brdf.model = (materials[material].kinds.z & MATERIAL_UNLIT) != 0u ? MODEL_NONE : materials[material].kinds.x;
  brdf.diffuse = diffuse_r.xyz;
  brdf.specular = specular_n.xyz;
  brdf.f90 = normal_f90.w;
  brdf.roughness = vec2(tangent_r.w, diffuse_r.w);
  if (brdf.model == MODEL_NONE) return vec3(0.0);

  vec3 x = uintBitsToFloat(ids.xyz);
  vec3 geometric_normal = from_octahedron(vec2(specular_n.w, texelFetch(gbuffer_values[4], pixel, 0).w));
  mat3 to_world = mat3(tangent_r.xyz, cross(normal_f90.xyz, tangent_r.xyz), normal_f90.xyz);
  vec3 wo = (orthographic != 0 ? ray_back : normalize(eye - x)) * to_world;
  vec3 sum = vec3(0.0);
  for (uint k = 0u; k < light_count; ++k) {
    GpuLight light = lights[k];
    vec3 wi;
    vec3 e = punctual_irradiance(light, x, wi);
    vec3 local = wi * to_world;
    // Light from below the surface itself does not come through it, whatever the normal map says.
    if (!(dot(geometric_normal, wi) > 0.0 && local.z > 0.0) || max(max(e.r, e.g), e.b) <= 0.0) continue;
    sum += evaluate_brdf(brdf, wo, local) * e * (local.z * visibility(light, x, geometric_normal));
  }
  return sum;
}

void main() {
  uvec2 pixel = gl_GlobalInvocationID.xy;
  if (pixel.x >= picture_width || pixel.y >= row_count) return;
  vec3 sum = shade(ivec2(pixel.x, pixel.y + first_row));
  uint at = 3u * (pixel.y * picture_width + pixel.x);
  for (uint c = 0u; c < 3u; ++c) radiance[at + c] = sum[c];
}
