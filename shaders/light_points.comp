// Irradiance from the punctual lights on both sides of every surface point.
#include "shared_layout.h"
#include "punctual.glsl"

layout(local_size_x = LIGHT_POINT_GROUP) in;

layout(std430, binding = BINDING_POINTS) readonly buffer Points { GpuPoint points[]; };
layout(std430, binding = BINDING_RESULT) writeonly buffer Result { float irradiance[]; };

uniform uint point_count;

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= point_count) return;
  vec3 x = points[i].position.xyz, n = points[i].normal.xyz;
  vec3 front = vec3(0.0), back = vec3(0.0);
  for (uint k = 0u; k < light_count; ++k) {
    GpuLight light = lights[k];
    vec3 wi;
    vec3 e = punctual_irradiance(light, x, wi);
    float cosine = dot(n, wi);
    if (cosine == 0.0 || max(max(e.r, e.g), e.b) <= 0.0) continue;
    e *= abs(cosine) * visibility(light, x, cosine > 0.0 ? n : -n);
    if (cosine > 0.0)
      front += e;
    else
      back += e;
  }
  for (uint c = 0u; c < 3u; ++c) {
    irradiance[6u * i + c] = front[c];
    irradiance[6u * i + 3u + c] = back[c];
  }
}
