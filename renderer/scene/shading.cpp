#include "scene/shading.h"

#include <array>

#include "core/simd.h"

namespace halflight {

namespace {

// Least cosine between the shading normal and wo: what a normal that faces away is bent to.
constexpr float least_view_cosine = 1e-3f;

// ---- Textures ----

/// sRGB's transfer function (IEC 61966-2-1) for each of the 256 codes.
const std::array<float, 256> srgb_to_linear = [] {
  std::array<float, 256> table;
  for (int i = 0; i < 256; ++i) {
    const double c = i / 255.0;
    table[i] = static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
  }
  return table;
}();

/// Texture coordinate in [0, 1] of the base image, as OpenGL's wrap modes fold it.
float wrap_coordinate(float u, Wrap wrap) {
  if (!std::isfinite(u)) return 0;
  switch (wrap) {
    case Wrap::clamp:
      return std::clamp(u, 0.0f, 1.0f);
    case Wrap::mirror: {
      const float folded = u - 2 * std::floor(0.5f * u);
      return folded > 1 ? 2 - folded : folded;
    }
    case Wrap::repeat:
      break;
  }
  return u - std::floor(u);
}

/// Index of a texel at most one beyond the edge: repeated, or the edge's own (which is what mirroring gives
/// too).
int wrap_texel(int i, int size, Wrap wrap) {
  if (wrap != Wrap::repeat) return std::clamp(i, 0, size - 1);
  return i < 0 ? size - 1 : i >= size ? 0 : i;
}

Vec4 texel(const ImageRgba8& image, bool srgb, int x, int y) {
  const uint8_t* p = image.bytes.data() + 4 * (static_cast<size_t>(y) * image.width + x);
  constexpr float scale = 1.0f / 255;
  if (srgb) return {srgb_to_linear[p[0]], srgb_to_linear[p[1]], srgb_to_linear[p[2]], p[3] * scale};
  return Vec4(p[0], p[1], p[2], p[3]) * scale;
}

/// OpenGL's NEAREST and LINEAR: texel centres at half-integers, each texel decoded before it is filtered.
Vec4 look_up(const ImageRgba8& image, const Texture& texture, Vec2 uv) {
  const int w = image.width, h = image.height;
  if (w <= 0 || h <= 0) return Vec4(1);
  const float x = wrap_coordinate(uv.x, texture.wrap_u) * static_cast<float>(w);
  const float y = wrap_coordinate(uv.y, texture.wrap_v) * static_cast<float>(h);
  if (texture.nearest) {
    return texel(image, texture.srgb, wrap_texel(static_cast<int>(x), w, texture.wrap_u),
                 wrap_texel(static_cast<int>(y), h, texture.wrap_v));
  }
  const float left = std::floor(x - 0.5f), top = std::floor(y - 0.5f);
  const float fx = x - 0.5f - left, fy = y - 0.5f - top;
  const int x0 = wrap_texel(static_cast<int>(left), w, texture.wrap_u);
  const int x1 = wrap_texel(static_cast<int>(left) + 1, w, texture.wrap_u);
  const int y0 = wrap_texel(static_cast<int>(top), h, texture.wrap_v);
  const int y1 = wrap_texel(static_cast<int>(top) + 1, h, texture.wrap_v);
  const Vec4 upper = glm::mix(texel(image, texture.srgb, x0, y0), texel(image, texture.srgb, x1, y0), fx);
  const Vec4 lower = glm::mix(texel(image, texture.srgb, x0, y1), texel(image, texture.srgb, x1, y1), fx);
  return glm::mix(upper, lower, fy);
}

// ---- Interpolation ----

/// A triangle's vertices and the point's weights of them.
struct Corners {
  const Vertex *a, *b, *c;
  Vec3 weights;

  template <class Member>
  auto interpolate(Member Vertex::*member) const {
    return weights.x * (a->*member) + weights.y * (b->*member) + weights.z * (c->*member);
  }
};

Corners corners(const Scene& scene, SurfacePoint p) {
  const UVec3 t = scene.triangles[p.triangle];
  return {&scene.vertices[t.x],
          &scene.vertices[t.y],
          &scene.vertices[t.z],
          {1 - p.barycentric.x - p.barycentric.y, p.barycentric.x, p.barycentric.y}};
}

/// RGBA8, red in the lowest byte.
Vec4 unpack_color(uint32_t rgba) {
  return Vec4(rgba & 255, (rgba >> 8) & 255, (rgba >> 16) & 255, rgba >> 24) * (1.0f / 255);
}

/// What the textures are looked up with.
struct TexturePoint {
  Vec2 uv[2];
  Vec4 color;
};

TexturePoint texture_point(const Corners& at) {
  TexturePoint point;
  for (int set = 0; set < 2; ++set) {
    point.uv[set] =
        at.weights.x * at.a->uv[set] + at.weights.y * at.b->uv[set] + at.weights.z * at.c->uv[set];
  }
  constexpr uint32_t white = 0xffffffffu;
  const bool uncolored = (at.a->color & at.b->color & at.c->color) == white;
  point.color = uncolored
                    ? Vec4(1)
                    : at.weights.x * unpack_color(at.a->color) + at.weights.y * unpack_color(at.b->color) +
                          at.weights.z * unpack_color(at.c->color);
  return point;
}

const Material& material_of(const Scene& scene, uint32_t triangle) {
  return scene.materials[scene.triangle_material[triangle]];
}

// ---- Material to BRDF ----

Vec4 base_color(const Scene& scene, const Material& material, const TexturePoint& at) {
  return material.base_color * at.color * texture_value(scene, material.base_color_texture, at.uv);
}

/// Direction of the anisotropy in the tangent plane and its strength (KHR_materials_anisotropy).
struct Anisotropy {
  Vec2 direction{1, 0};
  float strength = 0;
};

Anisotropy anisotropy_at(const Scene& scene, const Material& material, const TexturePoint& at) {
  Anisotropy result;
  if (material.anisotropy == 0) return result;
  result.strength = material.anisotropy;
  if (material.anisotropy_texture.used()) {
    const Vec4 value = texture_value(scene, material.anisotropy_texture, at.uv);
    const Vec2 direction = 2.0f * Vec2(value) - 1.0f;
    const float length = glm::length(direction);
    if (length > 1e-6f) result.direction = direction / length;
    result.strength *= value.z;
  }
  const float c = std::cos(material.anisotropy_rotation), s = std::sin(material.anisotropy_rotation);
  const Vec2 d = result.direction;
  result.direction = {c * d.x - s * d.y, s * d.x + c * d.y};
  return result;
}

/// glTF 2.0 appendix B with KHR_materials_ior, specular and anisotropy.
Brdf ggx_brdf(const Scene& scene, const Material& material, const TexturePoint& at, float anisotropy) {
  const Vec3 base = glm::clamp(Vec3(base_color(scene, material, at)), Vec3(0), Vec3(1));
  const Vec4 metallic_roughness = texture_value(scene, material.metallic_roughness_texture, at.uv);
  const float metallic = std::clamp(material.metallic * metallic_roughness.z, 0.0f, 1.0f);
  const float roughness = std::clamp(material.roughness * metallic_roughness.y, 0.0f, 1.0f);
  const float strength = material.specular * texture_value(scene, material.specular_texture, at.uv).w;
  const Vec3 tint =
      material.specular_color * Vec3(texture_value(scene, material.specular_color_texture, at.uv));
  const float normal_reflectance = square((material.ior - 1) / (material.ior + 1));

  Brdf brdf;
  brdf.model = BrdfModel::ggx;
  brdf.diffuse = base * (1 - metallic);
  brdf.specular = glm::mix(glm::min(normal_reflectance * tint, Vec3(1)) * strength, base, metallic);
  brdf.f90 = glm::mix(strength, 1.0f, metallic);
  const float alpha = square(roughness);
  brdf.roughness = {glm::mix(alpha, 1.0f, square(anisotropy)), alpha};
  return brdf;
}

Brdf brdf_at(const Scene& scene, const Material& material, const TexturePoint& at, float anisotropy) {
  if (material.unlit || material.model == BrdfModel::none) return {};
  if (material.model == BrdfModel::ggx) return ggx_brdf(scene, material, at, anisotropy);
  const Vec4 scale = at.color * texture_value(scene, material.base_color_texture, at.uv);
  Brdf brdf;
  brdf.model = material.model;
  brdf.diffuse = material.diffuse * Vec3(scale);
  brdf.specular = material.phong_specular;
  brdf.roughness = material.exponents;
  return brdf;
}

/// Emission of the front, or of the back where the material has one.
Vec3 emission_at(const Scene& scene, const Material& material, const TexturePoint& at, bool front) {
  if (material.unlit || !material.emissive() || !(front || material.double_sided)) return Vec3(0);
  return material.emission * Vec3(texture_value(scene, material.emission_texture, at.uv));
}

float alpha_at(const Scene& scene, const Material& material, SurfacePoint p) {
  if (material.alpha_mode == AlphaMode::opaque) return 1;
  const float alpha = base_color(scene, material, texture_point(corners(scene, p))).w;
  if (material.alpha_mode == AlphaMode::mask) return alpha >= material.alpha_cutoff ? 1.0f : 0.0f;
  return std::clamp(alpha, 0.0f, 1.0f);
}

// ---- Normals ----

/// Unit vector along v; `otherwise` where v has no direction. Scaled first: squares of tiny lengths vanish in
/// float.
Vec3 unit_or(Vec3 v, Vec3 otherwise) {
  const float scale = max_component(glm::abs(v));
  if (!(scale > 0) || !std::isfinite(scale)) return otherwise;
  return glm::normalize(v / scale);
}

/// Tangent frame of the front side at the point. T is made orthogonal to N; B = w · N × T.
struct SurfaceFrame {
  Vec3 normal, tangent, bitangent;
};

SurfaceFrame surface_frame(const Corners& at, Vec3 geometric_normal) {
  Vec3 normal = unit_or(at.interpolate(&Vertex::normal), geometric_normal);
  // A vertex normal that contradicts the winding is a file's mistake: the winding says which side is the
  // front.
  if (glm::dot(normal, geometric_normal) < 0) normal = -normal;
  const Vec4 tangent = at.interpolate(&Vertex::tangent);
  const Basis basis = tangent.w == 0 ? basis_around(normal) : basis_along(normal, Vec3(tangent));
  return {normal, basis.tangent, tangent.w < 0 ? -basis.bitangent : basis.bitangent};
}

/// Normal of the front side with the normal texture: (x, y) scaled, z as it is (glTF 2.0,
/// normalTextureInfo.scale).
Vec3 mapped_normal(const Scene& scene, const Material& material, const TexturePoint& at,
                   const SurfaceFrame& frame) {
  if (!material.normal_texture.used()) return frame.normal;
  const Vec3 value = 2.0f * Vec3(texture_value(scene, material.normal_texture, at.uv)) - 1.0f;
  const float x = value.x * material.normal_scale, y = value.y * material.normal_scale;
  return unit_or(x * frame.tangent + y * frame.bitangent + value.z * frame.normal, frame.normal);
}

/// The normal itself where it faces `wo`, else the nearest blend with wo that does.
Vec3 bend_towards(Vec3 normal, Vec3 wo) {
  const float cosine = glm::dot(normal, wo);
  if (cosine >= least_view_cosine) return normal;
  return glm::normalize(normal + (least_view_cosine - cosine) * wo);
}

// ---- Hashed alpha ----

/// The finaliser of MurmurHash3 (Appleby): a bijection on 32 bits.
uint32_t mix32(uint32_t v) {
  v ^= v >> 16, v *= 0x85ebca6bu;
  v ^= v >> 13, v *= 0xc2b2ae35u;
  return v ^ (v >> 16);
}

/// Hash of a triangle's point; barycentrics count in steps of 2⁻¹⁶, so that rays which meet at a point mostly
/// agree. On the GPU: the same integer operations on the triangle's index and the interpolated barycentrics.
uint32_t hash_point(SurfacePoint p, uint32_t seed) {
  const auto step = [](float b) { return static_cast<uint32_t>(std::clamp(b, 0.0f, 1.0f) * 65535.0f); };
  uint32_t hash = mix32(seed + 0x9e3779b9u);
  hash = mix32(hash ^ (p.triangle + 0x7f4a7c15u));
  return mix32(hash ^ (step(p.barycentric.x) | step(p.barycentric.y) << 16));
}

}  // namespace

Vec4 texture_value(const Scene& scene, const TextureUse& use, const Vec2 uv[2]) {
  if (!use.used()) return Vec4(1);
  const Texture& texture = scene.textures[use.texture];
  const Vec3 p(uv[use.uv_set], 1);
  return look_up(scene.images[texture.image], texture, {glm::dot(use.row_u, p), glm::dot(use.row_v, p)});
}

void prefetch_triangle(const Scene& scene, uint32_t triangle) {
  prefetch(&scene.triangles[triangle]);
  prefetch(&scene.triangle_material[triangle]);
}

void prefetch_corners(const Scene& scene, uint32_t triangle) {
  const UVec3 corners = scene.triangles[triangle];
  for (int i = 0; i < 3; ++i) prefetch(&scene.vertices[corners[i]]);
}

Vec3 surface_position(const Scene& scene, SurfacePoint p) {
  return corners(scene, p).interpolate(&Vertex::position);
}

float surface_alpha(const Scene& scene, SurfacePoint p) {
  return alpha_at(scene, material_of(scene, p.triangle), p);
}

bool surface_blocks(const Scene& scene, SurfacePoint p, uint32_t seed) {
  const float alpha = surface_alpha(scene, p);
  if (alpha <= 0 || alpha >= 1) return alpha > 0;
  constexpr float scale = 0x1p-24f;
  return static_cast<float>(hash_point(p, seed) >> 8) * scale < alpha;
}

Vec3 surface_emission(const Scene& scene, SurfacePoint p, int side) {
  const Material& material = material_of(scene, p.triangle);
  if (!material.emissive()) return Vec3(0);
  return emission_at(scene, material, texture_point(corners(scene, p)), side > 0);
}

Brdf surface_brdf(const Scene& scene, SurfacePoint p) {
  const Material& material = material_of(scene, p.triangle);
  const TexturePoint at = texture_point(corners(scene, p));
  return brdf_at(scene, material, at, anisotropy_at(scene, material, at).strength);
}

GBufferTexel shade_surface(const Scene& scene, SurfacePoint p, Vec3 wo) {
  const Corners vertices = corners(scene, p);
  const TexturePoint at = texture_point(vertices);
  const Material& material = material_of(scene, p.triangle);

  GBufferTexel texel;
  texel.position = vertices.interpolate(&Vertex::position);
  texel.triangle = p.triangle;
  texel.material = scene.triangle_material[p.triangle];
  texel.wo = wo;

  // Normals of the front side first, then turned together: seen from behind, a surface is its own mirror
  // image.
  const Vec3 geometric_normal = unit_or(triangle_cross(scene, p.triangle), wo);
  const bool front = glm::dot(geometric_normal, wo) >= 0;
  const SurfaceFrame frame = surface_frame(vertices, geometric_normal);
  const Vec3 normal = mapped_normal(scene, material, at, frame);
  texel.geometric_normal = front ? geometric_normal : -geometric_normal;
  texel.shading_normal = bend_towards(front ? normal : -normal, wo);

  const Anisotropy anisotropy = anisotropy_at(scene, material, at);
  const Vec3 axis = anisotropy.direction.x * frame.tangent + anisotropy.direction.y * frame.bitangent;
  texel.tangent = basis_along(texel.shading_normal, axis).tangent;

  texel.brdf = brdf_at(scene, material, at, anisotropy.strength);
  texel.emission = material.unlit ? glm::max(Vec3(base_color(scene, material, at)), Vec3(0))
                                  : emission_at(scene, material, at, front);
  return texel;
}

}  // namespace halflight
