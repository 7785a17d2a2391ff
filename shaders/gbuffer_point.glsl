// A pixel of the G-buffer drawn last, as a pass that lights it needs it.

layout(std430, binding = BINDING_MATERIALS) readonly buffer Materials { GpuMaterial materials[]; };
layout(std430, binding = BINDING_TRIANGLE_MATERIALS) readonly buffer TriangleMaterials { uint triangle_materials[]; };
layout(binding = UNIT_GBUFFER_IDS) uniform usampler2D position_triangle;
layout(binding = UNIT_GBUFFER_VALUES) uniform sampler2D gbuffer_values[GBUFFER_TARGETS - 1];

uniform vec3 eye, ray_back;
uniform int orthographic;

struct GBufferPoint {
  vec3 position, geometric_normal;
  mat3 to_world;  // columns: tangent, bitangent, shading normal
  vec3 wo;        // local
  Brdf brdf;      // MODEL_NONE where nothing is hit, or what is hit reflects nothing
};

GBufferPoint gbuffer_point(ivec2 pixel) {
  GBufferPoint point;
  point.brdf.model = MODEL_NONE;
  uvec4 ids = texelFetch(position_triangle, pixel, 0);
  if (ids.w == NO_TRIANGLE) return point;
  uint material = triangle_materials[ids.w];
  if ((materials[material].kinds.z & MATERIAL_UNLIT) == 0u) point.brdf.model = materials[material].kinds.x;
  if (point.brdf.model == MODEL_NONE) return point;
  vec4 normal_f90 = texelFetch(gbuffer_values[0], pixel, 0), tangent_r = texelFetch(gbuffer_values[1], pixel, 0);
  vec4 diffuse_r = texelFetch(gbuffer_values[2], pixel, 0), specular_n = texelFetch(gbuffer_values[3], pixel, 0);
  point.brdf.diffuse = diffuse_r.xyz;
  point.brdf.specular = specular_n.xyz;
  point.brdf.f90 = normal_f90.w;
  point.brdf.roughness = vec2(tangent_r.w, diffuse_r.w);
  point.position = uintBitsToFloat(ids.xyz);
  point.geometric_normal = from_octahedron(vec2(specular_n.w, texelFetch(gbuffer_values[4], pixel, 0).w));
  point.to_world = mat3(tangent_r.xyz, cross(normal_f90.xyz, tangent_r.xyz), normal_f90.xyz);
  point.wo = (orthographic != 0 ? ray_back : normalize(eye - point.position)) * point.to_world;
  return point;
}
