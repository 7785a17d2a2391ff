#include "trace/light_sampling.h"

#include "core/warp.h"
#include "lights/emitters.h"

namespace halflight {

namespace {

std::vector<float> texel_powers(const Environment& environment) {
  std::vector<float> powers;
  if (!environment.present() || environment.strength <= 0) return powers;
  const ImageRgb& map = environment.map;
  // Relative to the brightest texel: powers stay in the range of float for any radiance.
  float brightest = 0;
  for (const Vec3& radiance : map.pixels) brightest = std::max(brightest, luminance(radiance));
  if (brightest <= 0) return powers;
  powers.reserve(map.pixels.size());
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      powers.push_back(luminance(map.at(x, y)) / brightest * texel_solid_angle(environment, y));
  return powers;
}

}  // namespace

EnvironmentSampler::EnvironmentSampler(const Environment& environment, bool wanted)
    : environment_(environment) {
  if (!wanted) return;
  const std::vector<float> powers = texel_powers(environment);
  if (!powers.empty()) table_ = PlaneTable(powers, environment.map.width, environment.map.height);
}

IncidentSample EnvironmentSampler::sample(Vec2 u) const {
  const PlaneTable::Draw draw = table_.draw(u);
  const int width = environment_.map.width, row = static_cast<int>(draw.cell) / width;
  // Uniform over the texel in the unit square; area to solid angle: sin θ dθ dφ with θ = π v, φ = 2π u.
  const float sin_theta = std::sin(pi * draw.position.y);
  const Vec3 wi = environment_direction(environment_, draw.position);
  const float pdf = draw.pdf / (2 * pi * pi * std::max(sin_theta, 1e-12f));
  const Vec3 radiance = environment_.map.at(static_cast<int>(draw.cell) % width, row) * environment_.strength;
  return {wi, infinity, radiance / pdf};
}

EmitterSampler::EmitterSampler(const Scene& scene, bool wanted) : scene_(scene) {
  if (!wanted) return;
  std::vector<float> powers;
  for (const EmissiveTriangle& emitter : emissive_triangles(scene)) {
    triangles_.push_back(emitter.triangle);
    powers.push_back(emitter.power);
  }
  table_ = DiscreteTable(powers);
}

std::optional<IncidentSample> EmitterSampler::sample(Vec3 x, float choose, Vec2 u) const {
  const DiscreteTable::Draw draw = table_.draw(choose);
  const SurfacePoint point{triangles_[draw.index], uniform_triangle(u)};
  const Vec3 cross = triangle_cross(scene_, point.triangle);
  const float twice_area = glm::length(cross);
  const Vec3 offset = surface_position(scene_, point) - x;
  const float distance2 = glm::dot(offset, offset);
  if (!(distance2 > 0) || !(twice_area > 0)) return {};
  const float distance = std::sqrt(distance2);
  const Vec3 wi = offset / distance;
  const float cos_light = -glm::dot(cross, wi) / twice_area;
  const Vec3 radiance = covered_emission(scene_, point, cos_light > 0 ? 1 : -1);
  if (max_component(radiance) <= 0) return {};
  // Density per area is P / A; per solid angle P / A · r² / |cos θ'|.
  const float area_over_probability = 0.5f * twice_area / draw.probability;
  return IncidentSample{wi, distance, radiance * (area_over_probability * std::abs(cos_light) / distance2)};
}

}  // namespace halflight
