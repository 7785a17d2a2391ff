// Rooms of a few patches in which the light that rays find is known by quadrature.
#pragma once

#include "support/traced_scene.h"

namespace halflight {

inline std::vector<Brdf> test_brdfs() {
  return {diffuse_brdf(Vec3(0.7f)),
          {BrdfModel::phong, Vec3(0.3f), Vec3(0.5f), 1, Vec2(20)},
          {BrdfModel::ggx, Vec3(0.5f), Vec3(0.1f), 1, Vec2(0.4f)},
          {BrdfModel::ashikhmin_shirley, Vec3(0.2f), Vec3(0.4f), 1, Vec2(10, 30)}};
}

/// A floor and a wall that meet, and a lamp above that faces both; nothing hides anything.
struct Corner {
  static constexpr int wall_cells = 48, lamp_cells = 16;
  Scene scene;
  Vec3 wall_corner{0, 0, 0}, wall_u{0, 0, 1}, wall_v{0, 1, 0};
  Vec3 lamp_corner{0.3f, 1.3f, 0.05f}, lamp_u{0, 0, 0.9f}, lamp_v{0.6f, -0.3f, 0};
  float albedo = 0.6f, emission = 5;

  Corner() {
    scene.materials.push_back(diffuse_material(Vec3(0)));       // black floor: it returns nothing
    scene.materials.push_back(diffuse_material(Vec3(albedo)));  // wall
    Material lamp = diffuse_material(Vec3(0));
    lamp.emission = Vec3(emission);
    scene.materials.push_back(lamp);
    add_patch(scene, {0, 0, 0}, {0, 0, 1}, {1, 0, 0});
    add_patch(scene, wall_corner, wall_v, wall_u, 1);
    add_patch(scene, lamp_corner, lamp_v, lamp_u, 2);
  }
  Vec3 wall_normal() const { return glm::normalize(glm::cross(wall_v, wall_u)); }
  Vec3 lamp_normal() const { return glm::normalize(glm::cross(lamp_v, lamp_u)); }

  /// Irradiance from the lamp.
  double irradiance(Vec3 x, Vec3 n) const {
    const double area = glm::length(glm::cross(lamp_u, lamp_v)) / (lamp_cells * lamp_cells);
    double sum = 0;
    for (int i = 0; i < lamp_cells; ++i)
      for (int j = 0; j < lamp_cells; ++j) {
        const Vec3 d = lamp_corner + ((i + 0.5f) * lamp_u + (j + 0.5f) * lamp_v) / float(lamp_cells) - x;
        const double r2 = glm::dot(d, d), r = std::sqrt(r2);
        sum += std::max(0.0, glm::dot(n, d) / r) * std::max(0.0, -glm::dot(lamp_normal(), d) / r) / r2;
      }
    return sum * area * emission;
  }
  double direct(const GBufferTexel& x) const {
    const double area = glm::length(glm::cross(lamp_u, lamp_v)) / (lamp_cells * lamp_cells);
    double sum = 0;
    for (int i = 0; i < lamp_cells; ++i)
      for (int j = 0; j < lamp_cells; ++j)
        sum += transported(x, lamp_corner + ((i + 0.5f) * lamp_u + (j + 0.5f) * lamp_v) / float(lamp_cells),
                           lamp_normal());
    return sum * area * emission;
  }
  double one_bounce(const GBufferTexel& x) const {
    const double area = 1.0 / (wall_cells * wall_cells);
    double sum = 0;
    for (int i = 0; i < wall_cells; ++i)
      for (int j = 0; j < wall_cells; ++j) {
        const Vec3 y = wall_corner + ((i + 0.5f) * wall_u + (j + 0.5f) * wall_v) / float(wall_cells);
        sum += transported(x, y, wall_normal()) * irradiance(y, wall_normal());
      }
    return sum * area * albedo / pi;
  }

 private:
  static double transported(const GBufferTexel& x, Vec3 y, Vec3 n) {
    const Vec3 d = y - x.position;
    const double r2 = glm::dot(d, d);
    const Vec3 wi = glm::normalize(d);
    return evaluate(x.brdf, x.basis(), x.wo, wi).y * std::max(0.0f, glm::dot(x.shading_normal, wi)) *
           std::max(0.0, double(-glm::dot(n, wi))) / r2;
  }
};

inline std::vector<GBufferTexel> corner_pixels() {
  std::vector<GBufferTexel> pixels;
  for (const Brdf& brdf : test_brdfs())
    pixels.push_back(seen_point({0.5f, 0, 0.45f}, {0, 1, 0}, brdf, {0.7f, 0.6f, 0.1f}));
  return pixels;
}

/// Everything at once: emitter, environment through an open side, punctual lights, one bounce, a blocker.
inline Scene full_room() {
  Scene scene = Corner().scene;
  scene.materials[0] = diffuse_material(Vec3(0.5f, 0.4f, 0.3f));
  add_patch(scene, {0.6f, 0.2f, 0.3f}, {0, 0, 0.3f}, {0.2f, 0.1f, 0}, 1);
  ImageRgb map(32, 16, Vec3(0.3f, 0.5f, 0.8f));
  map.at(20, 4) = Vec3(40);
  scene.environment = make_environment(map, "sky", EnvironmentLayout::latlong);
  for (int i = 0; i < 12; ++i) {
    PunctualLight light;
    light.position = {0.2f + 0.05f * i, 0.6f + 0.02f * i, 0.9f - 0.06f * i};
    light.intensity = Vec3(0.05f + 0.01f * i);
    scene.lights.push_back(light);
  }
  return scene;
}

inline constexpr LightKinds all_kinds{true, true, true, true};

}  // namespace halflight
