// From a point on a triangle to what the G-buffer keeps of it: `shade_surface` of renderer/scene/shading.cpp, where the
// sources are cited.

const float least_view_cosine = 1e-3;

struct Surface {
  vec3 position, geometric_normal, shading_normal, tangent, emission;
  vec3 diffuse, specular;
  float f90;
  vec2 roughness;
};

/// Unit vector along v; `otherwise` where v has no direction. Scaled first: squares of tiny lengths vanish in float.
vec3 unit_or(vec3 v, vec3 otherwise) {
  float scale = max(max(abs(v.x), abs(v.y)), abs(v.z));
  if (!(scale > 0.0) || isinf(scale)) return otherwise;
  return normalize(v / scale);
}

/// Duff et al. 2017, as `basis_around` of core/math.h.
vec3 tangent_around(vec3 n) {
  float s = n.z < 0.0 ? -1.0 : 1.0;
  float a = -1.0 / (s + n.z);
  return vec3(1.0 + s * n.x * n.x * a, s * n.x * n.y * a, -s * n.x);
}

/// `t` made orthogonal to the unit normal; any tangent where that degenerates.
vec3 tangent_along(vec3 normal, vec3 t) {
  vec3 orthogonal = t - normal * dot(t, normal);
  float length2 = dot(orthogonal, orthogonal);
  if (!(length2 > 1e-12 * dot(t, t))) return tangent_around(normal);
  return orthogonal / sqrt(length2);
}

/// Tangent frame of the front side; columns T, B = w · N × T, N.
mat3 surface_frame(Point p, vec3 geometric_normal) {
  vec3 normal = unit_or(interpolate_vec3(p, VERTEX_NORMAL), geometric_normal);
  if (dot(normal, geometric_normal) < 0.0) normal = -normal;
  vec3 tangent = interpolate_vec3(p, VERTEX_TANGENT);
  uint word = VERTEX_TANGENT + 3u;
  float handedness = p.weights.x * uintBitsToFloat(vertex_words[p.corners.x + word]) +
                     p.weights.y * uintBitsToFloat(vertex_words[p.corners.y + word]) +
                     p.weights.z * uintBitsToFloat(vertex_words[p.corners.z + word]);
  vec3 t = handedness == 0.0 ? tangent_around(normal) : tangent_along(normal, tangent);
  vec3 b = cross(normal, t);
  return mat3(t, handedness < 0.0 ? -b : b, normal);
}

vec3 mapped_normal(TexturePoint at, mat3 frame) {
  if (!HAS_TEXTURE(MATERIAL_NORMAL)) return frame[2];
  vec3 value = 2.0 * MATERIAL_VALUE(MATERIAL_NORMAL, at).xyz - 1.0;
  vec2 xy = value.xy * materials[at.material].others.y;
  return unit_or(xy.x * frame[0] + xy.y * frame[1] + value.z * frame[2], frame[2]);
}

/// Direction of the anisotropy in the tangent plane; z: its strength.
vec3 anisotropy_at(TexturePoint at) {
  float strength = materials[at.material].exponents.z, rotation = materials[at.material].exponents.w;
  if (strength == 0.0) return vec3(1.0, 0.0, 0.0);
  vec2 d = vec2(1.0, 0.0);
  if (HAS_TEXTURE(MATERIAL_ANISOTROPY)) {
    vec3 value = MATERIAL_VALUE(MATERIAL_ANISOTROPY, at).xyz;
    vec2 direction = 2.0 * value.xy - 1.0;
    float size = length(direction);
    if (size > 1e-6) d = direction / size;
    strength *= value.z;
  }
  float c = cos(rotation), s = sin(rotation);
  return vec3(c * d.x - s * d.y, s * d.x + c * d.y, strength);
}

void set_ggx(inout Surface surface, TexturePoint at, vec3 colour, float anisotropy) {
  GpuMaterial material = materials[at.material];
  vec3 base = clamp(colour, 0.0, 1.0);
  vec4 metallic_roughness = MATERIAL_VALUE(MATERIAL_METALLIC_ROUGHNESS, at);
  float metallic = clamp(material.diffuse.w * metallic_roughness.z, 0.0, 1.0);
  float roughness = clamp(material.phong_specular.w * metallic_roughness.y, 0.0, 1.0);
  float strength = material.specular_color.w * MATERIAL_VALUE(MATERIAL_SPECULAR, at).a;
  vec3 tint = material.specular_color.rgb * MATERIAL_VALUE(MATERIAL_SPECULAR_COLOR, at).rgb;
  float root = (material.others.x - 1.0) / (material.others.x + 1.0);
  surface.diffuse = base * (1.0 - metallic);
  surface.specular = mix(min(root * root * tint, vec3(1.0)) * strength, base, metallic);
  surface.f90 = mix(strength, 1.0, metallic);
  float alpha = roughness * roughness;
  surface.roughness = vec2(mix(alpha, 1.0, anisotropy * anisotropy), alpha);
}

void set_brdf(inout Surface surface, TexturePoint at, float anisotropy) {
  surface.diffuse = vec3(0.0);
  surface.specular = vec3(0.0);
  surface.f90 = 1.0;
  surface.roughness = vec2(1.0);
  uint model = materials[at.material].kinds.x;
  if ((materials[at.material].kinds.z & MATERIAL_UNLIT) != 0u || model == MODEL_NONE) return;
  if (model == MODEL_GGX) {
    set_ggx(surface, at, base_color(at).rgb, anisotropy);
    return;
  }
  surface.diffuse = materials[at.material].diffuse.rgb * at.color.rgb;
  surface.specular = materials[at.material].phong_specular.rgb;
  surface.roughness = materials[at.material].exponents.xy;
}

vec3 emission_at(TexturePoint at, bool front) {
  uint flags = materials[at.material].kinds.z;
  if ((flags & MATERIAL_UNLIT) != 0u) return max(base_color(at).rgb, vec3(0.0));
  vec3 emission = materials[at.material].emission.rgb;
  bool emits = max(max(emission.r, emission.g), emission.b) > 0.0;
  if (!emits || !(front || (flags & MATERIAL_DOUBLE_SIDED) != 0u)) return vec3(0.0);
  return emission * MATERIAL_VALUE(MATERIAL_EMISSION, at).rgb;
}

Surface shade_surface(Point p, TexturePoint at, vec3 wo) {
  Surface surface;
  surface.position = interpolate_vec3(p, 0u);

  // Normals of the front side first, then turned together: seen from behind, a surface is its own mirror image.
  vec3 a = vertex_vec3(p.corners.x, 0u);
  vec3 ab = vertex_vec3(p.corners.y, 0u) - a, ac = vertex_vec3(p.corners.z, 0u) - a;
  vec3 geometric_normal = unit_or(cross(ab, ac), wo);
  bool front = dot(geometric_normal, wo) >= 0.0;
  mat3 frame = surface_frame(p, geometric_normal);
  vec3 normal = mapped_normal(at, frame);
  if (!front) normal = -normal;
  surface.geometric_normal = front ? geometric_normal : -geometric_normal;
  float cosine = dot(normal, wo);
  surface.shading_normal =
      cosine >= least_view_cosine ? normal : normalize(normal + (least_view_cosine - cosine) * wo);

  vec3 anisotropy = anisotropy_at(at);
  surface.tangent = tangent_along(surface.shading_normal, anisotropy.x * frame[0] + anisotropy.y * frame[1]);
  set_brdf(surface, at, anisotropy.z);
  surface.emission = emission_at(at, front);
  return surface;
}
