// GPU Gems 3, chapter 20 (Colbert & Křivánek 2007), listing 20-1: light of the environment, without shadows, from
// samples of each pixel's BRDF in mipmapped dual-paraboloid maps, and from spherical harmonics for the diffuse term.
// Formulas of the lobes: renderer/scene/brdf.cpp; of the maps: renderer/raster/filtered_environment.cpp.
#include "shared_layout.h"
#include "brdf.glsl"
#include "octahedral.glsl"
#include "gbuffer_point.glsl"

layout(local_size_x = DIRECT_LIGHT_GROUP, local_size_y = DIRECT_LIGHT_GROUP) in;

layout(std430, binding = BINDING_POINTS) readonly buffer Points { vec4 points[]; };
layout(std430, binding = BINDING_RESULT) buffer Result { float radiance[]; };
layout(std430, binding = BINDING_FILTERED_LIGHT) readonly buffer Light { GpuFilteredLight light; };
layout(binding = UNIT_FILTERED_MAPS) uniform sampler2DArray maps;

// The pixels of a subset: every `stride`-th one in x and y, in bands of rows.
uniform uint stride, first_pixel_x, first_pixel_y, subset_width, row_count;
// Of the sample points, those in `points`; the first ones start the sums.
uniform uint point_count;
uniform int first_points;

uniform float level_of_set, level_bias, paraboloid_scale, strength, strength_per_sample;
uniform int filter_samples;
uniform vec2 turn;  // cosine and sine of the environment's rotation

/// From the scene's axes to the map's.
vec3 to_map(vec3 d) { return vec3(turn.x * d.x - turn.y * d.z, d.y, turn.y * d.x + turn.x * d.z); }

/// A direction of the specular lobe: f cos / pdf and the density.
struct Draw {
  vec3 wi, weight;
  float pdf;
};

/// 1 - exp(x) for x <= 0: the series where exp(x) would lose the digits of x.
float complement_of_exp(float x) {
  if (x < -0.05) return 1.0 - exp(x);
  return -x * (1.0 + x * (1.0 / 2.0 + x * (1.0 / 6.0 + x * (1.0 / 24.0 + x / 120.0))));
}

/// Basis about a unit vector (Duff et al. 2017), as `basis_around` of core/math.h.
mat3 basis_around(vec3 n) {
  float s = n.z < 0.0 ? -1.0 : 1.0;
  float a = -1.0 / (s + n.z), b = n.x * n.y * a;
  return mat3(vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3(b, s + n.y * n.y * a, -n.y), n);
}

/// Equations 7 to 9; the power cancels in f / pdf. `point`: xi_1, log(1 - xi_1), cosine and sine of 2 pi xi_2.
Draw draw_phong(Brdf brdf, vec3 wo, vec4 point) {
  float n = brdf.roughness.x;
  float cosine = exp(point.y / (n + 1.0)), sine = sqrt(complement_of_exp(2.0 * point.y / (n + 1.0)));
  Draw draw;
  draw.wi = basis_around(vec3(-wo.xy, wo.z)) * vec3(sine * point.zw, cosine);
  draw.pdf = (n + 1.0) / (2.0 * pi) * exp(n / (n + 1.0) * point.y);
  draw.weight = brdf.specular * ((n + 2.0) / (n + 1.0) * draw.wi.z);
  return draw;
}

/// Ashikhmin & Shirley's half vectors, all four quadrants at once.
Draw draw_ashikhmin_shirley(Brdf brdf, vec3 wo, vec4 point) {
  vec2 n = brdf.roughness;
  vec2 direction = normalize(point.zw * sqrt(n.yx + 1.0));
  float power = 1.0 / (dot(n, direction * direction) + 1.0);
  vec3 h = vec3(sqrt(complement_of_exp(2.0 * power * point.y)) * direction, exp(power * point.y));
  float cos_half = dot(wo, h);
  Draw draw;
  draw.wi = 2.0 * cos_half * h - wo;
  if (cos_half <= 0.0) draw.wi.z = 0.0;
  float lobe = exp((1.0 - power) * point.y);
  draw.pdf = sqrt((n.x + 1.0) * (n.y + 1.0)) * lobe / (8.0 * pi * max(cos_half, 1e-20));
  draw.weight = schlick(brdf.specular, 1.0, cos_half) * (draw.wi.z / max(draw.wi.z, wo.z));
  return draw;
}

/// Visible normals on a spherical cap cut at the horizon (Dupuy & Benyoub 2023; Eto & Tokuyoshi 2023).
Draw draw_ggx(Brdf brdf, vec3 wo, vec4 point) {
  vec2 alpha = max(brdf.roughness, vec2(1e-4));
  float a2 = square(min(1.0, min(alpha.x, alpha.y))), s2 = square(1.0 + length(wo.xy));
  float bound = (1.0 - a2) * s2 / (s2 + a2 * square(wo.z));
  vec3 stretched = vec3(alpha * wo.xy, wo.z);
  float size = length(stretched);
  stretched /= size;
  float lowest = bound * stretched.z;
  float z = (1.0 - point.x) * (1.0 + lowest) - lowest;
  vec3 sum = stretched + vec3(sqrt(max(0.0, 1.0 - z * z)) * point.zw, z);
  vec3 h = normalize(vec3(alpha * sum.xy, sum.z));
  float cos_half = dot(wo, h);
  Draw draw;
  draw.wi = 2.0 * cos_half * h - wo;
  float d = square(h.x / alpha.x) + square(h.y / alpha.y) + square(h.z);
  float distribution = 1.0 / (pi * alpha.x * alpha.y * d * d);
  float half_scale = bound * wo.z + size;
  draw.pdf = distribution / (2.0 * half_scale);
  // D cancels in D G / (4 cos cos) * cos / pdf.
  float stretched_i = length(vec3(alpha * draw.wi.xy, draw.wi.z));
  draw.weight = schlick(brdf.specular, brdf.f90, cos_half) *
                (half_scale * draw.wi.z / max(draw.wi.z * size + wo.z * stretched_i, 1e-30));
  return draw;
}

Draw draw_specular(Brdf brdf, vec3 wo, vec4 point) {
  if (brdf.model == MODEL_GGX) return draw_ggx(brdf, wo, point);
  if (brdf.model == MODEL_PHONG) return draw_phong(brdf, wo, point);
  return draw_ashikhmin_shirley(brdf, wo, point);
}

/// Table 20-2, at the level of equation 13 with the distortion of equation 14.
vec3 map_radiance(vec3 u, float pdf) {
  float reach = 1.0 + abs(u.z);
  vec3 place = vec3(0.5 + u.xy / (2.0 * paraboloid_scale * reach), u.z < 0.0 ? 1.0 : 0.0);
  float level = 0.0;
  if (filter_samples != 0) {
    float distortion = square(2.0 * paraboloid_scale * reach);
    level = max(0.0, level_of_set - 0.5 * log2(clamp(pdf, 1e-30, 1e30) * distortion)) + level_bias;
  }
  return textureLod(maps, place, level).rgb;
}

vec3 specular_light(GBufferPoint point) {
  Brdf brdf = point.brdf;
  bool fresnel_only = brdf.model == MODEL_GGX && brdf.f90 > 0.0;
  if (max(max(brdf.specular.r, brdf.specular.g), brdf.specular.b) <= 0.0 && !fresnel_only) return vec3(0.0);
  vec3 sum = vec3(0.0);
  for (uint k = 0u; k < point_count; ++k) {
    Draw draw = draw_specular(brdf, point.wo, points[k]);
    if (!(draw.wi.z > 0.0)) continue;
    sum += draw.weight * map_radiance(to_map(point.to_world * draw.wi), draw.pdf);
  }
  return sum * strength_per_sample;
}

vec3 harmonics(vec4 coefficients[9], vec3 d) {
  vec3 sum = 0.28209479 * coefficients[0].rgb;
  sum += 0.48860251 * (coefficients[1].rgb * d.y + coefficients[2].rgb * d.z + coefficients[3].rgb * d.x);
  sum += 1.09254843 * (coefficients[4].rgb * d.x * d.y + coefficients[5].rgb * d.y * d.z);
  sum += 0.31539157 * coefficients[6].rgb * (3.0 * d.z * d.z - 1.0);
  sum += 1.09254843 * coefficients[7].rgb * d.x * d.z + 0.54627422 * coefficients[8].rgb * (d.x * d.x - d.y * d.y);
  return max(sum, vec3(0.0));
}

/// What Fresnel takes from GGX's diffuse lobe depends on the half vector: its mean under uniform light stands for it.
vec3 diffuse_light(GBufferPoint point) {
  Brdf brdf = point.brdf;
  vec3 normal = to_map(point.to_world[2]);
  vec3 reflectance = brdf.diffuse * strength;
  if (brdf.model == MODEL_ASHIKHMIN_SHIRLEY)
    return reflectance * (vec3(1.0) - brdf.specular) * (1.0 - pow5_of_complement(0.5 * point.wo.z)) *
           harmonics(light.ashikhmin, normal);
  if (brdf.model == MODEL_GGX) {
    float place = clamp(point.wo.z, 0.0, 1.0) * float(SCHLICK_MEANS - 1);
    uint i = min(uint(place), uint(SCHLICK_MEANS - 2));
    float mean = mix(light.schlick_means[i], light.schlick_means[i + 1u], place - float(i));
    reflectance *= vec3(1.0) - mix(brdf.specular, vec3(brdf.f90), mean);
  }
  return reflectance * (1.0 / pi) * harmonics(light.lambert, normal);
}

void main() {
  uvec2 id = gl_GlobalInvocationID.xy;
  if (id.x >= subset_width || id.y >= row_count) return;
  GBufferPoint point = gbuffer_point(ivec2(uvec2(first_pixel_x, first_pixel_y) + stride * id));
  vec3 sum = vec3(0.0);
  uint at = 3u * (id.y * subset_width + id.x);
  if (point.brdf.model != MODEL_NONE && point.wo.z > 0.0) {
    sum = specular_light(point);
    if (first_points != 0) sum += diffuse_light(point);
  }
  for (uint c = 0u; c < 3u; ++c) radiance[at + c] = (first_points != 0 ? 0.0 : radiance[at + c]) + sum[c];
}
