#include "trace/light_sampling.h"

#include <array>
#include <span>

#include "core/simd.h"
#include "core/warp.h"
#include "lights/emitters.h"
#include "lights/virtual_light.h"

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

namespace {

/// Per area of the unit square to per solid angle: sin θ dθ dφ with θ = π v, φ = 2π u.
float square_to_solid_angle(float pdf, float v) {
  return pdf / (2 * pi * pi * std::max(std::sin(pi * v), 1e-12f));
}

}  // namespace

IncidentSample EnvironmentSampler::sample(Vec2 u) const { return incident(table_.draw(u)); }

void EnvironmentSampler::sample(std::span<const Vec2> u, std::span<IncidentSample> out) const {
  constexpr size_t most_at_once = 16;
  std::array<PlaneTable::Draw, most_at_once> draws;
  for (size_t begin = 0; begin < u.size(); begin += most_at_once) {
    const size_t count = std::min(u.size() - begin, most_at_once);
    for (size_t i = 0; i < count; ++i) {
      draws[i] = table_.draw(u[begin + i]);
      prefetch(&environment_.map.pixels[draws[i].cell]);
    }
    for (size_t i = 0; i < count; ++i) out[begin + i] = incident(draws[i]);
  }
}

IncidentSample EnvironmentSampler::incident(const PlaneTable::Draw& draw) const {
  const int width = environment_.map.width, row = static_cast<int>(draw.cell) / width;
  const Vec3 wi = environment_direction(environment_, draw.position);
  const float density = square_to_solid_angle(draw.pdf, draw.position.y);
  const Vec3 radiance = environment_.map.at(static_cast<int>(draw.cell) % width, row) * environment_.strength;
  return {wi, infinity, radiance / density, density};
}

float EnvironmentSampler::pdf(Vec3 wi) const { return met(wi).pdf; }

EnvironmentSampler::Met EnvironmentSampler::met(Vec3 wi) const {
  if (empty()) return {Vec3(0), 0};
  const Vec2 uv = environment_uv(environment_, wi);
  return {environment_radiance(environment_, environment_texel(environment_, uv)),
          square_to_solid_angle(table_.pdf(uv), uv.y)};
}

EmitterSampler::EmitterSampler(const Scene& scene, bool wanted) : scene_(scene) {
  if (!wanted) return;
  std::vector<float> powers, areas;
  for (const EmissiveTriangle& emitter : emissive_triangles(scene)) {
    triangles_.push_back(emitter.triangle);
    powers.push_back(emitter.power);
    areas.push_back(emitter.area);
  }
  table_ = DiscreteTable(powers);
  if (table_.empty()) return;
  densities_.assign(scene.triangles.size(), 0.0f);
  for (size_t i = 0; i < triangles_.size(); ++i)
    densities_[triangles_[i]] = static_cast<float>(table_.probability(i) / areas[i]);
  double area = 0;
  for (size_t i = 0; i < triangles_.size(); ++i) {
    area += areas[i];
    for (int corner = 0; corner < 3; ++corner)
      bounds_.extend(scene.vertices[scene.triangles[triangles_[i]][corner]].position);
  }
  near_distance_ = static_cast<float>(std::sqrt(4 * area / pi));
}

EmitterSampler::Point EmitterSampler::point(float choose, Vec2 u) const {
  const uint32_t triangle = triangles_[table_.draw(choose).index];
  return {{triangle, uniform_triangle(u)}, densities_[triangle]};
}

std::optional<IncidentSample> EmitterSampler::sample(Vec3 x, float choose, Vec2 u) const {
  const Point drawn = point(choose, u);
  const Vec3 cross = triangle_cross(scene_, drawn.surface.triangle);
  const float twice_area = glm::length(cross);
  const Vec3 offset = surface_position(scene_, drawn.surface) - x;
  const float distance2 = glm::dot(offset, offset);
  if (!(distance2 > 0) || !(twice_area > 0) || !(drawn.density > 0)) return {};
  const float distance = std::sqrt(distance2);
  const Vec3 wi = offset / distance;
  const float cos_light = -glm::dot(cross, wi) / twice_area;
  const Vec3 radiance = covered_emission(scene_, drawn.surface, cos_light > 0 ? 1 : -1);
  if (max_component(radiance) <= 0) return {};
  return IncidentSample{wi, distance, radiance * (std::abs(cos_light) / (drawn.density * distance2)),
                        area_to_solid_angle(drawn.density, distance, std::abs(cos_light))};
}

double punctual_power(const PunctualLight& light, float scene_radius) {
  const double intensity = luminance(light.intensity);
  constexpr double pi_d = 3.141592653589793;
  switch (light.kind) {
    case PunctualKind::directional:
      return intensity * pi_d * scene_radius * scene_radius;
    case PunctualKind::spot:
      return intensity * 2 * pi_d * (1 - std::cos(static_cast<double>(light.outer_cone)));
    case PunctualKind::point:
      break;
  }
  return intensity * 4 * pi_d;
}

PunctualSampler::PunctualSampler(const Scene& scene, bool wanted) : scene_(scene) {
  if (!wanted) return;
  std::vector<double> powers;
  double strongest = 0;
  for (uint32_t i = 0; i < scene.lights.size(); ++i) {
    if (!(max_component(scene.lights[i].intensity) > 0)) continue;
    lights_.push_back(i);
    powers.push_back(punctual_power(scene.lights[i], 0.5f * scene.bounds.diagonal()));
    strongest = std::max(strongest, powers.back());
  }
  // None so weak that it is never looked at: power says nothing about distance.
  std::vector<float> weights;
  for (const double power : powers)
    weights.push_back(static_cast<float>(std::max(strongest > 0 ? power / strongest : 1.0, 1e-3)));
  table_ = DiscreteTable(weights);
}

std::optional<IncidentSample> PunctualSampler::sample(Vec3 x, Vec3 normal, RandomStream& random) const {
  constexpr size_t handful = 8;
  const bool all = lights_.size() <= handful;
  LightConnection chosen{};
  double total = 0, chosen_target = 0;
  for (size_t i = 0; i < (all ? lights_.size() : handful); ++i) {
    const DiscreteTable::Draw draw =
        all ? DiscreteTable::Draw{static_cast<uint32_t>(i), 1, 0} : table_.draw(random.next());
    const LightConnection link = connect_punctual(scene_.lights[lights_[draw.index]], scene_, x);
    const double target = static_cast<double>(luminance(link.irradiance)) * glm::dot(normal, link.wi);
    if (!(target > 0)) continue;
    // The sum of target / (M P): the normalisation of the target, exact where all lights are candidates.
    const double share = all ? target : target / (handful * static_cast<double>(draw.probability));
    total += share;
    if (random.next() * total < share) chosen = link, chosen_target = target;
  }
  if (!(total > 0)) return {};
  return IncidentSample{chosen.wi, chosen.distance,
                        chosen.irradiance * static_cast<float>(total / chosen_target), infinity};
}

}  // namespace halflight
