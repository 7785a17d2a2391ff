// What the camera sees at a pixel. ALPHA_TEST: materials with holes in them.
#include "shared_layout.h"
#include "texture_lookup.glsl"
#include "triangles.glsl"
#include "surface.glsl"
#include "octahedral.glsl"

// The camera's rays, as `camera_ray`: offset = x · ray_x + y · ray_y for x, y in [−1, 1], y up.
uniform vec3 eye, ray_x, ray_y, ray_back;
uniform vec2 jitter, picture_size;
uniform int orthographic;
uniform uint alpha_seed;

layout(location = 0) out uvec4 position_triangle;
layout(location = 1) out vec4 shading_normal_f90;
layout(location = 2) out vec4 tangent_roughness;
layout(location = 3) out vec4 diffuse_roughness;
layout(location = 4) out vec4 specular_normal;
layout(location = 5) out vec4 emission_normal;

void main() {
  // Rows count from the top: the projection is upside down.
  vec2 pixel = 2.0 * (gl_FragCoord.xy + jitter) / picture_size - 1.0;
  vec3 offset = pixel.x * ray_x - pixel.y * ray_y;
  vec3 origin = orthographic != 0 ? eye + offset : eye;
  vec3 direction = orthographic != 0 ? -ray_back : normalize(offset - ray_back);

  Point p = point_on_line(uint(gl_PrimitiveID), origin, direction);
  TexturePoint at = texture_point(p);
#ifdef ALPHA_TEST
  if (!blocks(p, at, alpha_seed)) discard;
#endif
  Surface surface = shade_surface(p, at, -direction);
  vec2 normal = to_octahedron(surface.geometric_normal);
  position_triangle = uvec4(floatBitsToUint(surface.position), p.triangle);
  shading_normal_f90 = vec4(surface.shading_normal, surface.f90);
  tangent_roughness = vec4(surface.tangent, surface.roughness.x);
  diffuse_roughness = vec4(surface.diffuse, surface.roughness.y);
  specular_normal = vec4(surface.specular, normal.x);
  emission_normal = vec4(surface.emission, normal.y);
}
