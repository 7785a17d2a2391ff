// Materials and their textures; the formulas of renderer/scene/shading.cpp. Filtering is done here in full precision:
// hardware filters weigh with 8 bits, and masks and normal maps would then differ from what the rays see.

layout(std430, binding = BINDING_MATERIALS) readonly buffer Materials { GpuMaterial materials[]; };
layout(std430, binding = BINDING_SRGB_TABLE) readonly buffer SrgbTable { float srgb_to_linear[]; };
layout(binding = 0) uniform sampler2D material_textures[MATERIAL_TEXTURES];

/// What the textures of a point are looked up with.
struct TexturePoint {
  uint material;
  vec2 uv0, uv1;
  vec4 color;         // of the vertices, times the base colour texture
};

/// Texture coordinate in [0, 1] of the base image, as OpenGL's wrap modes fold it.
float wrap_coordinate(float u, uint wrap) {
  if (isnan(u) || isinf(u)) return 0.0;
  if (wrap == WRAP_CLAMP) return clamp(u, 0.0, 1.0);
  if (wrap == WRAP_REPEAT) return u - floor(u);
  float folded = u - 2.0 * floor(0.5 * u);
  return folded > 1.0 ? 2.0 - folded : folded;
}

/// Index of a texel at most one beyond the edge: repeated, or the edge's own (which is what mirroring gives too).
int wrap_texel(int i, int size, uint wrap) {
  if (wrap != WRAP_REPEAT) return clamp(i, 0, size - 1);
  return i < 0 ? size - 1 : i >= size ? 0 : i;
}

vec4 texel(sampler2D image, bool srgb, int x, int y) {
  vec4 value = texelFetch(image, ivec2(x, y), 0);
  if (!srgb) return value;
  ivec3 codes = ivec3(value.rgb * 255.0 + 0.5);
  return vec4(srgb_to_linear[codes.r], srgb_to_linear[codes.g], srgb_to_linear[codes.b], value.a);
}

/// Value of one of the material's textures, linear.
vec4 texture_value(sampler2D image, int slot, TexturePoint at) {
  uvec4 mode = materials[at.material].textures[slot].look_up;
  vec3 p = vec3(mode.x == 0u ? at.uv0 : at.uv1, 1.0);
  vec2 uv = vec2(dot(materials[at.material].textures[slot].row_u.xyz, p),
                 dot(materials[at.material].textures[slot].row_v.xyz, p));
  bool srgb = (mode.y & TEXTURE_SRGB) != 0u;
  uint wrap_u = mode.z, wrap_v = mode.w;
  ivec2 size = textureSize(image, 0);
  float x = wrap_coordinate(uv.x, wrap_u) * float(size.x), y = wrap_coordinate(uv.y, wrap_v) * float(size.y);
  if ((mode.y & TEXTURE_NEAREST) != 0u)
    return texel(image, srgb, wrap_texel(int(x), size.x, wrap_u), wrap_texel(int(y), size.y, wrap_v));
  float left = floor(x - 0.5), top = floor(y - 0.5);
  float fx = x - 0.5 - left, fy = y - 0.5 - top;
  int x0 = wrap_texel(int(left), size.x, wrap_u), x1 = wrap_texel(int(left) + 1, size.x, wrap_u);
  int y0 = wrap_texel(int(top), size.y, wrap_v), y1 = wrap_texel(int(top) + 1, size.y, wrap_v);
  vec4 upper = mix(texel(image, srgb, x0, y0), texel(image, srgb, x1, y0), fx);
  vec4 lower = mix(texel(image, srgb, x0, y1), texel(image, srgb, x1, y1), fx);
  return mix(upper, lower, fy);
}

// TEXTURE_MASK has a bit for each texture that the materials of the draw have: a program holds no other look-ups, because
// a software rasteriser runs both sides of every branch. The value of a texture that is not there is white.
#define HAS_TEXTURE(slot) ((TEXTURE_MASK & (1 << slot)) != 0)
#define MATERIAL_VALUE(slot, at) (HAS_TEXTURE(slot) ? texture_value(material_textures[slot], slot, at) : vec4(1.0))

vec4 base_color(TexturePoint at) { return materials[at.material].base_color * at.color; }
