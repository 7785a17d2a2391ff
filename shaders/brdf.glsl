// f_r of the three models; the formulas of renderer/scene/brdf.cpp, where their sources are cited.

const float pi = 3.14159265358979323846;

struct Brdf {
  uint model;
  vec3 diffuse, specular;
  float f90;
  vec2 roughness;
};

float square(float x) { return x * x; }

float pow5_of_complement(float x) {
  float c = clamp(1.0 - x, 0.0, 1.0);
  float c2 = c * c;
  return c2 * c2 * c;
}

vec3 schlick(vec3 f0, float f90, float cos_half) { return f0 + (vec3(f90) - f0) * pow5_of_complement(cos_half); }

/// log(1 − x) for x in [0, 1): the series where 1 − x would lose the digits of x.
float log_of_complement(float x) {
  if (x > 0.05) return log(1.0 - x);
  return -x * (1.0 + x * (1.0 / 2.0 + x * (1.0 / 3.0 + x * (1.0 / 4.0 + x * (1.0 / 5.0 + x / 6.0)))));
}

/// Unit half vector of two local directions, w: its cosine with either.
vec4 half_vector(vec3 wo, vec3 wi) {
  vec3 sum = wo + wi;
  float size = sqrt(max(dot(sum, sum), 1e-30));
  return vec4(sum / size, min(0.5 * size, 1.0));
}

/// D·G₂/(4 cos θ_i cos θ_o), Heitz 2014 eqs. 85 and 99.
float ggx_lobe(vec3 wo, vec3 wi, vec3 h, vec2 alpha) {
  float d = square(h.x / alpha.x) + square(h.y / alpha.y) + square(h.z);
  float distribution = 1.0 / (pi * alpha.x * alpha.y * d * d);
  float stretched_o = length(vec3(alpha * wo.xy, wo.z)), stretched_i = length(vec3(alpha * wi.xy, wi.z));
  return distribution * 0.5 / (wi.z * stretched_o + wo.z * stretched_i);
}

vec3 ggx(Brdf brdf, vec3 wo, vec3 wi) {
  vec4 h = half_vector(wo, wi);
  vec3 fresnel = schlick(brdf.specular, brdf.f90, h.w);
  vec3 diffuse = (vec3(1.0) - fresnel) * brdf.diffuse * (1.0 / pi);
  bool has_specular = max(max(brdf.specular.r, brdf.specular.g), brdf.specular.b) > 0.0 || brdf.f90 > 0.0;
  if (!has_specular) return diffuse;
  return diffuse + fresnel * ggx_lobe(wo, wi, h.xyz, max(brdf.roughness, vec2(1e-4)));
}

vec3 phong(Brdf brdf, vec3 wo, vec3 wi) {
  vec3 difference = wi - vec3(-wo.xy, wo.z);
  float half_square = 0.5 * dot(difference, difference);
  float n = brdf.roughness.x;
  float power = half_square < 1.0 ? exp(n * log_of_complement(half_square)) : 0.0;
  return brdf.diffuse * (1.0 / pi) + brdf.specular * ((n + 2.0) * power / (2.0 * pi));
}

vec3 ashikhmin_shirley(Brdf brdf, vec3 wo, vec3 wi) {
  float matte = 28.0 / (23.0 * pi) * (1.0 - pow5_of_complement(0.5 * wi.z)) * (1.0 - pow5_of_complement(0.5 * wo.z));
  vec3 diffuse = brdf.diffuse * (vec3(1.0) - brdf.specular) * matte;
  if (max(max(brdf.specular.r, brdf.specular.g), brdf.specular.b) <= 0.0) return diffuse;
  vec4 h = half_vector(wo, wi);
  vec2 n = brdf.roughness;
  float sin2 = min(dot(h.xy, h.xy), 1.0 - 1.0 / 16777216.0);
  float log_over_sin2 = sin2 > 1e-12 ? log_of_complement(sin2) / sin2 : -1.0;
  float power = exp(0.5 * dot(n, h.xy * h.xy) * log_over_sin2);
  float density = sqrt((n.x + 1.0) * (n.y + 1.0)) * power / (8.0 * pi * max(h.w, 1e-20));
  return diffuse + schlick(brdf.specular, 1.0, h.w) * (density / max(wi.z, wo.z));
}

/// wo and wi in the local frame; 0 unless both are above the horizon.
vec3 evaluate_brdf(Brdf brdf, vec3 wo, vec3 wi) {
  if (!(wo.z > 0.0 && wi.z > 0.0)) return vec3(0.0);
  if (brdf.model == MODEL_GGX) return ggx(brdf, wo, wi);
  if (brdf.model == MODEL_PHONG) return phong(brdf, wo, wi);
  if (brdf.model == MODEL_ASHIKHMIN_SHIRLEY) return ashikhmin_shirley(brdf, wo, wi);
  return vec3(0.0);
}
