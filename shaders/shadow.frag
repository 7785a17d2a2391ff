// Depth is all that is kept. ALPHA_TEST: light passes through the holes of masked and blended materials.
#include "shared_layout.h"
#ifdef ALPHA_TEST
#include "texture_lookup.glsl"
#include "triangles.glsl"

uniform vec4 view_origin, view_right, view_up, view_forward;
uniform int orthographic;
uniform float view_size;
uniform uint alpha_seed;
#endif

void main() {
#ifdef ALPHA_TEST
  vec2 p = (2.0 * gl_FragCoord.xy / view_size - 1.0) * view_right.w;
  vec3 offset = p.x * view_right.xyz + p.y * view_up.xyz;
  vec3 origin = orthographic != 0 ? view_origin.xyz + offset : view_origin.xyz;
  vec3 direction = orthographic != 0 ? view_forward.xyz : normalize(offset + view_forward.xyz);
  Point hit = point_on_line(uint(gl_PrimitiveID), origin, direction);
  if (!blocks(hit, texture_point(hit), alpha_seed)) discard;
#endif
}
