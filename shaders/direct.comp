// D_punctual of the G-buffer drawn last: Σ f · cos θ · E · visibility over the punctual lights.
#include "shared_layout.h"
#include "brdf.glsl"
#include "octahedral.glsl"
#include "gbuffer_point.glsl"
#include "punctual.glsl"

layout(local_size_x = DIRECT_LIGHT_GROUP, local_size_y = DIRECT_LIGHT_GROUP) in;

layout(std430, binding = BINDING_RESULT) writeonly buffer Result { float radiance[]; };

uniform uint picture_width;
// Rows are lit in bands, each with a result buffer's worth of pixels.
uniform uint first_row, row_count;

vec3 shade(ivec2 pixel) {
  GBufferPoint point = gbuffer_point(pixel);
  if (point.brdf.model == MODEL_NONE) return vec3(0.0);
  vec3 sum = vec3(0.0);
  for (uint k = 0u; k < light_count; ++k) {
    GpuLight light = lights[k];
    vec3 wi;
    vec3 e = punctual_irradiance(light, point.position, wi);
    vec3 local = wi * point.to_world;
    // Light from below the surface itself does not come through it, whatever the normal map says.
    if (!(dot(point.geometric_normal, wi) > 0.0 && local.z > 0.0) || max(max(e.r, e.g), e.b) <= 0.0) continue;
    sum += evaluate_brdf(point.brdf, point.wo, local) * e *
           (local.z * visibility(light, point.position, point.geometric_normal));
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
