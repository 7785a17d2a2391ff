// The scene's triangles as storage buffers: which one a fragment shows, and where on it the ray through the fragment
// lies. Attributes are weighed with these barycentrics, not with the rasteriser's, which stand on a grid of 1/256 pixel.

layout(std430, binding = BINDING_VERTICES) readonly buffer Vertices { uint vertex_words[]; };
layout(std430, binding = BINDING_INDICES) readonly buffer Indices { uint corner_indices[]; };
layout(std430, binding = BINDING_TRIANGLES) readonly buffer Triangles { uvec2 triangle_facts[]; };

// Of this draw: its first triangle in the buffers, and the first vertex of the range bound.
uniform uint first_triangle, first_vertex;

/// A point of a triangle.
struct Point {
  uint triangle;  // index in the scene
  uint material;
  uvec3 corners;  // first word of each vertex
  vec3 weights;
};

vec3 vertex_vec3(uint corner, uint word) {
  uint at = corner + word;
  return vec3(uintBitsToFloat(vertex_words[at]), uintBitsToFloat(vertex_words[at + 1u]),
              uintBitsToFloat(vertex_words[at + 2u]));
}

vec2 vertex_vec2(uint corner, uint word) {
  uint at = corner + word;
  return vec2(uintBitsToFloat(vertex_words[at]), uintBitsToFloat(vertex_words[at + 1u]));
}

vec3 interpolate_vec3(Point p, uint word) {
  return p.weights.x * vertex_vec3(p.corners.x, word) + p.weights.y * vertex_vec3(p.corners.y, word) +
         p.weights.z * vertex_vec3(p.corners.z, word);
}

vec2 interpolate_vec2(Point p, uint word) {
  return p.weights.x * vertex_vec2(p.corners.x, word) + p.weights.y * vertex_vec2(p.corners.y, word) +
         p.weights.z * vertex_vec2(p.corners.z, word);
}

/// Barycentric weights of vertices 1 and 2 where the line meets the triangle's plane (Möller & Trumbore 1997), moved
/// into the triangle: a fragment's centre may lie just outside of what the ray sees.
vec2 line_barycentrics(vec3 origin, vec3 direction, vec3 a, vec3 b, vec3 c) {
  vec3 ab = b - a, ac = c - a, from = origin - a;
  vec3 p = cross(direction, ac);
  float determinant = dot(ab, p);
  if (determinant == 0.0) return vec2(1.0 / 3.0);
  vec2 weights = vec2(dot(from, p), dot(direction, cross(from, ab))) / determinant;
  if (isnan(weights.x + weights.y) || isinf(weights.x + weights.y)) return vec2(1.0 / 3.0);
  weights = clamp(weights, 0.0, 1.0);
  return weights / max(1.0, weights.x + weights.y);
}

/// The point of the fragment's triangle that a line shows.
Point point_on_line(uint primitive, vec3 origin, vec3 direction) {
  uint triangle = first_triangle + primitive;
  Point p;
  p.triangle = triangle_facts[triangle].x;
  p.material = triangle_facts[triangle].y;
  p.corners = (uvec3(corner_indices[3u * triangle], corner_indices[3u * triangle + 1u],
                     corner_indices[3u * triangle + 2u]) - first_vertex) * VERTEX_WORDS;
  vec2 b = line_barycentrics(origin, direction, vertex_vec3(p.corners.x, 0u), vertex_vec3(p.corners.y, 0u),
                             vertex_vec3(p.corners.z, 0u));
  p.weights = vec3(1.0 - b.x - b.y, b);
  return p;
}

TexturePoint texture_point(Point p) {
  TexturePoint at;
  at.material = p.material;
  at.uv0 = interpolate_vec2(p, VERTEX_UV);
  at.uv1 = interpolate_vec2(p, VERTEX_UV + 2u);
  uint a = vertex_words[p.corners.x + VERTEX_COLOR], b = vertex_words[p.corners.y + VERTEX_COLOR];
  uint c = vertex_words[p.corners.z + VERTEX_COLOR];
  at.color = (a & b & c) == 0xffffffffu ? vec4(1.0)
                                        : p.weights.x * unpackUnorm4x8(a) + p.weights.y * unpackUnorm4x8(b) +
                                              p.weights.z * unpackUnorm4x8(c);
  at.color *= MATERIAL_VALUE(MATERIAL_BASE_COLOR, at);
  return at;
}

/// The finaliser of MurmurHash3 (Appleby).
uint mix32(uint v) {
  v ^= v >> 16;
  v *= 0x85ebca6bu;
  v ^= v >> 13;
  v *= 0xc2b2ae35u;
  return v ^ (v >> 16);
}

/// Whether the point stands in the way: `surface_blocks` of scene/shading.h.
bool blocks(Point p, TexturePoint at, uint seed) {
  uint mode = materials[p.material].kinds.y;
  if (mode == ALPHA_OPAQUE) return true;
  float alpha = base_color(at).a;
  if (mode == ALPHA_MASK) return alpha >= materials[p.material].emission.w;
  if (alpha <= 0.0 || alpha >= 1.0) return alpha > 0.0;
  uvec2 steps = uvec2(clamp(p.weights.yz, 0.0, 1.0) * 65535.0);
  uint hash = mix32(seed + 0x9e3779b9u);
  hash = mix32(hash ^ (p.triangle + 0x7f4a7c15u));
  hash = mix32(hash ^ (steps.x | steps.y << 16));
  return float(hash >> 8) * (1.0 / 16777216.0) < alpha;
}
