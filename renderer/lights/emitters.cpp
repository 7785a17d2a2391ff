#include "lights/emitters.h"

#include "core/parallel.h"
#include "core/warp.h"

namespace halflight {

namespace {

/// Mean luminance that a triangle emits, from points of the R2 lattice (Roberts 2018) where it varies; never
/// so little that a bright spot which they miss would become a rare, huge sample.
float mean_emission(const Scene& scene, uint32_t triangle) {
  constexpr float least_share = 0.01f;
  constexpr int places = 12;
  const Material& material = scene.materials[scene.triangle_material[triangle]];
  const float full = luminance(material.emission);
  if (!material.emission_texture.used() && material.alpha_mode == AlphaMode::opaque) return full;
  float sum = 0;
  for (int i = 0; i < places; ++i) {
    const float x = 0.5f + 0.7548776662f * static_cast<float>(i),
                y = 0.5f + 0.5698402910f * static_cast<float>(i);
    const Vec2 u(x - std::floor(x), y - std::floor(y));
    sum += luminance(covered_emission(scene, {triangle, uniform_triangle(u)}, 1)) / places;
  }
  return std::max(sum, least_share * full);
}

}  // namespace

Vec3 covered_emission(const Scene& scene, SurfacePoint point, int side) {
  return surface_emission(scene, point, side) * surface_alpha(scene, point);
}

std::vector<EmissiveTriangle> emissive_triangles(const Scene& scene) {
  std::vector<EmissiveTriangle> emitters;
  for (uint32_t i = 0; i < scene.triangles.size(); ++i) {
    const Material& material = scene.materials[scene.triangle_material[i]];
    if (!material.emissive() || material.unlit) continue;
    const float area = 0.5f * glm::length(triangle_cross(scene, i));
    if (area > 0) emitters.push_back({i, area, 0});
  }
  std::vector<double> powers(emitters.size());
  parallel_for(0, emitters.size(), 1024, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      powers[i] = static_cast<double>(emitters[i].area) * mean_emission(scene, emitters[i].triangle);
  });
  double total = 0;
  for (const double power : powers) total += power;
  // Emission so weak that its luminance vanishes in float still arrives; so does the dimmest among bright
  // ones.
  const double equal = 1 / std::max(1.0, static_cast<double>(emitters.size()));
  for (size_t i = 0; i < emitters.size(); ++i)
    emitters[i].power = static_cast<float>(total > 0 ? std::max(powers[i] / total, 1e-6 * equal) : equal);
  return emitters;
}

}  // namespace halflight
