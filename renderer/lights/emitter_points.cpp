#include <algorithm>

#include "core/random.h"
#include "core/tables.h"
#include "core/warp.h"
#include "lights/light_points.h"

namespace halflight {

namespace {

/// Luminance of what a triangle emits on average, from four points of it; never quite 0 where the material
/// emits.
float mean_emission(const Scene& scene, uint32_t triangle) {
  constexpr Vec2 places[] = {{1.0f / 3, 1.0f / 3}, {0.6f, 0.2f}, {0.2f, 0.6f}, {0.2f, 0.2f}};
  float sum = 0;
  for (const Vec2 place : places) sum += 0.25f * luminance(surface_emission(scene, {triangle, place}, 1));
  return std::max(sum, 1e-3f * luminance(scene.materials[scene.triangle_material[triangle]].emission));
}

struct Emitters {
  std::vector<uint32_t> triangles;
  std::vector<float> areas, powers;  ///< powers are relative: their sum is about one
};

Emitters find_emitters(const Scene& scene) {
  Emitters emitters;
  std::vector<double> powers;
  double total = 0;
  for (uint32_t i = 0; i < scene.triangles.size(); ++i) {
    const Material& material = scene.materials[scene.triangle_material[i]];
    const float area = 0.5f * glm::length(triangle_cross(scene, i));
    if (!material.emissive() || material.unlit || !(area > 0)) continue;
    emitters.triangles.push_back(i);
    emitters.areas.push_back(area);
    powers.push_back(static_cast<double>(area) * mean_emission(scene, i));
    total += powers.back();
  }
  for (double power : powers)
    emitters.powers.push_back(total > 0 ? static_cast<float>(power / total)
                                        : 1.0f / static_cast<float>(powers.size()));
  return emitters;
}

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
    light.radiance = surface_emission(scene, point, side);
    light.source = point.triangle;
    lights.push_back(light);
  }
}

}  // namespace

std::vector<VirtualLight> emitter_points(const Scene& scene, const LightPointSettings& settings) {
  const Emitters emitters = find_emitters(scene);
  std::vector<VirtualLight> lights;
  const size_t count = emitters.triangles.size(), budget = std::max<size_t>(settings.count / 4, 1);
  const uint64_t seed = hash_combine(settings.seed, 0x656d6974ull);
  if (count == 0) return lights;

  if (count > budget) {
    // More triangles than points: systematic choice by power, each chosen one standing for area / expected
    // count.
    const DiscreteTable table(emitters.powers);
    for (size_t i = 0; i < budget; ++i) {
      RandomStream random(i, 0, seed);
      const float u = (static_cast<float>(i) + random.next()) / static_cast<float>(budget);
      const auto draw = table.draw(std::min(u, 0x1.fffffep-1f));
      const float area = emitters.areas[draw.index] / (static_cast<float>(budget) * draw.probability);
      add_lights(scene, {emitters.triangles[draw.index], uniform_triangle(random.next2())}, area, lights);
    }
    return lights;
  }
  for (size_t i = 0; i < count; ++i) {
    const auto share = static_cast<size_t>(
        std::lround(static_cast<double>(emitters.powers[i]) * static_cast<double>(budget)));
    const size_t points = std::max<size_t>(share, 1);
    RandomStream random(emitters.triangles[i], 0, seed);
    const Vec2 shift = random.next2();
    for (size_t j = 0; j < points; ++j) {
      // A rotated lattice (Roberts 2018, R2) fills the triangle evenly; each point alone is uniform.
      const double x = shift.x + static_cast<double>(j) * 0.7548776662466927;
      const double y = shift.y + static_cast<double>(j) * 0.5698402909980532;
      const Vec2 u(static_cast<float>(x - std::floor(x)), static_cast<float>(y - std::floor(y)));
      add_lights(scene, {emitters.triangles[i], uniform_triangle(u)},
                 emitters.areas[i] / static_cast<float>(points), lights);
    }
  }
  return lights;
}

std::vector<VirtualLight> punctual_points(const Scene& scene) {
  std::vector<VirtualLight> lights;
  for (uint32_t i = 0; i < scene.lights.size(); ++i) {
    const PunctualLight& punctual = scene.lights[i];
    VirtualLight light;
    light.position = punctual.position;
    light.measure = 1;
    light.normal = punctual.direction;
    light.kind = LightKind::punctual;
    light.radiance = punctual.intensity;
    light.source = i;
    lights.push_back(light);
  }
  return lights;
}

}  // namespace halflight
