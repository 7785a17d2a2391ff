#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "core/tables.h"
#include "core/warp.h"
#include "lights/emitters.h"
#include "lights/light_points.h"

namespace halflight {

namespace {

/// A light a side that emits at a point standing for `area`.
void add_lights(const Scene& scene, SurfacePoint point, float area, std::vector<VirtualLight>& lights) {
  const Vec3 cross = triangle_cross(scene, point.triangle);
  const bool both_sides = scene.materials[scene.triangle_material[point.triangle]].double_sided;
  for (int side = 1; side >= (both_sides ? -1 : 1); side -= 2) {
    VirtualLight light;
    light.position = surface_position(scene, point);
    light.measure = area;
    light.normal = glm::normalize(cross) * static_cast<float>(side);
    light.kind = LightKind::emitter;
    light.radiance = covered_emission(scene, point, side);
    light.source = point.triangle;
    lights.push_back(light);
  }
}

// Solid angle given to a directional light, about the sun's; a power of two, so that E⊥ = L Ω exactly.
constexpr float directional_solid_angle = 0x1p-14f;

VirtualLight directional_point(const PunctualLight& punctual) {
  VirtualLight light;
  light.kind = LightKind::environment;
  light.position = -punctual.direction;
  light.normal = punctual.direction;
  light.measure = directional_solid_angle;
  light.radiance = punctual.intensity / directional_solid_angle;
  return light;
}

VirtualLight punctual_point(const PunctualLight& punctual) {
  VirtualLight light;
  light.kind = LightKind::punctual;
  light.position = punctual.position;
  light.normal = punctual.direction;
  light.measure = 1;
  light.radiance = punctual.intensity;
  return light;
}

/// More triangles than points: systematic choice by power, each chosen one standing for area / expected
/// count.
void add_chosen_lights(const Scene& scene, const std::vector<EmissiveTriangle>& emitters, uint32_t count,
                       uint64_t seed, std::vector<VirtualLight>& lights) {
  std::vector<float> powers;
  for (const EmissiveTriangle& emitter : emitters) powers.push_back(emitter.power);
  const DiscreteTable table(powers);
  for (uint32_t i = 0; i < count; ++i) {
    RandomStream random(i, 0, seed);
    const float u = (static_cast<float>(i) + random.next()) / static_cast<float>(count);
    const auto draw = table.draw(std::min(u, 0x1.fffffep-1f));
    const float area = emitters[draw.index].area / (static_cast<float>(count) * draw.probability);
    add_lights(scene, {emitters[draw.index].triangle, uniform_triangle(random.next2())}, area, lights);
  }
}

}  // namespace

std::vector<VirtualLight> emitter_points(const Scene& scene, const LightPointSettings& settings) {
  const std::vector<EmissiveTriangle> emitters = emissive_triangles(scene);
  const uint64_t seed = hash_combine(settings.seed, 0x656d6974ull);
  std::vector<VirtualLight> lights;
  if (emitters.size() > settings.count) {
    add_chosen_lights(scene, emitters, settings.count, seed, lights);
    return lights;
  }
  // A quarter of |S| resolves the penumbrae of a few emitters; many small ones take what their minimum asks.
  const size_t budget = std::min<size_t>(settings.count / 4, settings.count - emitters.size());
  for (const EmissiveTriangle& emitter : emitters) {
    const auto share = static_cast<size_t>(static_cast<double>(emitter.power) * static_cast<double>(budget));
    const size_t points = std::max<size_t>(share, 1);
    RandomStream random(emitter.triangle, 0, seed);
    const Vec2 shift = random.next2();
    for (size_t j = 0; j < points; ++j) {
      // A rotated lattice (Roberts 2018, R2) fills the triangle evenly; each point alone is uniform.
      const double x = shift.x + static_cast<double>(j) * 0.7548776662466927;
      const double y = shift.y + static_cast<double>(j) * 0.5698402909980532;
      const Vec2 u(static_cast<float>(x - std::floor(x)), static_cast<float>(y - std::floor(y)));
      add_lights(scene, {emitter.triangle, uniform_triangle(u)}, emitter.area / static_cast<float>(points),
                 lights);
    }
  }
  return lights;
}

std::vector<VirtualLight> punctual_points(const Scene& scene) {
  std::vector<VirtualLight> lights;
  for (uint32_t i = 0; i < scene.lights.size(); ++i) {
    const PunctualLight& punctual = scene.lights[i];
    lights.push_back(punctual.kind == PunctualKind::directional ? directional_point(punctual)
                                                                : punctual_point(punctual));
    lights.back().source = i;
  }
  return lights;
}

}  // namespace halflight
