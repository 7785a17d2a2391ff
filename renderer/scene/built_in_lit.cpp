#include "scene/built_in_lit.h"

#include "scene/camera.h"

namespace halflight {

Material phong_material(std::string name, Vec3 diffuse, Vec3 specular, float exponent) {
  Material material;
  material.name = std::move(name);
  material.model = BrdfModel::phong;
  material.diffuse = diffuse, material.phong_specular = specular;
  material.exponents = Vec2(exponent);
  return material;
}

void add_camera(Scene& scene, std::string name, Vec3 eye, Vec3 target, float degrees) {
  Camera camera = look_at(eye, target, {0, 1, 0}, glm::radians(degrees));
  camera.name = std::move(name);
  scene.cameras.push_back(std::move(camera));
}

PunctualLight aimed_spot(std::string name, Vec3 position, Vec3 target, float outer_degrees, Vec3 candela) {
  PunctualLight light;
  light.name = std::move(name);
  light.kind = PunctualKind::spot;
  light.position = position;
  light.direction = glm::normalize(target - position);
  const Vec3 up = std::abs(light.direction.y) < 0.99f ? Vec3(0, 1, 0) : Vec3(0, 0, -1);
  light.up = basis_along(light.direction, up).tangent;
  light.intensity = candela;
  light.outer_cone = glm::radians(outer_degrees);
  light.inner_cone = 0.97f * light.outer_cone;
  return light;
}

void add_projector(Scene& scene, PunctualLight spot, ImageRgb slide) {
  spot.picture = static_cast<int32_t>(scene.pictures.size());
  scene.pictures.push_back(std::move(slide));
  scene.lights.push_back(std::move(spot));
}

float lowest_point(const Mesh& mesh, const Mat4& transform) {
  float low = infinity;
  for (const Vertex& v : mesh.vertices) low = std::min(low, (transform * Vec4(v.position, 1)).y);
  return low;
}

void set_lathe_tangents(Mesh& mesh) {
  for (Vertex& v : mesh.vertices) {
    const float phi = 2 * pi * v.uv[0].x;
    v.tangent = Vec4(-std::sin(phi), 0, -std::cos(phi), 1);
  }
}

Mesh trefoil_mesh(float radius, int along, int around) {
  return grid_mesh({along, around, true, true}, [=](float u, float v) {
    // The knot winds on a torus, whose normal is at right angles to it: a frame that closes.
    const auto point = [](float t) {
      const float out = 2 + std::cos(3 * t);
      return Vec3(out * std::cos(2 * t), out * std::sin(2 * t), std::sin(3 * t));
    };
    const float t = 2 * pi * u, phi = -2 * pi * v, step = 1e-2f;
    const Vec3 normal(std::cos(3 * t) * std::cos(2 * t), std::cos(3 * t) * std::sin(2 * t), std::sin(3 * t));
    const Vec3 ahead = glm::normalize(point(t + step) - point(t - step));
    return point(t) + radius * (std::cos(phi) * normal + std::sin(phi) * glm::cross(ahead, normal));
  });
}

}  // namespace halflight
