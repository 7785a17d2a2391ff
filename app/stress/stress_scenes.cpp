#include "stress/stress_scenes.h"

#include "scene/camera.h"

namespace halflight {

Material matte(Vec3 reflectance) { return phong(reflectance, Vec3(0), 1); }

Material glowing(Vec3 radiance) {
  Material material = matte(Vec3(0));
  material.emission = radiance;
  return material;
}

Material phong(Vec3 diffuse, Vec3 specular, float exponent) {
  Material material;
  material.model = BrdfModel::phong;
  material.diffuse = diffuse, material.phong_specular = specular;
  material.exponents = Vec2(exponent);
  return material;
}

void add_sheet(Scene& scene, Vec3 corner, Vec3 a, Vec3 b, uint32_t material) {
  place(scene, rectangle_mesh(corner, a, b), material);
  update_bounds(scene);
}

Environment even_sky(Vec3 radiance) {
  return make_environment(ImageRgb(32, 16, radiance), "even sky", EnvironmentLayout::latlong);
}

Environment sky_with_suns(Vec3 sky, const std::vector<Sun>& suns) {
  ImageRgb map(64, 32, sky);
  for (const Sun& sun : suns) map.at(sun.x, sun.y) = sun.radiance;
  return make_environment(std::move(map), "sky", EnvironmentLayout::latlong);
}

namespace {

Camera studio_camera() { return look_at({0.12f, 1.05f, 1.55f}, {0.02f, 0.12f, -0.3f}, {0, 1, 0}, 0.72f); }

}  // namespace

Scene open_floor(const Material& floor, const Environment& sky) {
  Scene scene;
  scene.facts.source = "stress";
  add_sheet(scene, {-2, 0, 2}, {4, 0, 0}, {0, 0, -4}, add_material(scene, floor));
  scene.environment = sky;
  scene.cameras = {look_at({0.1f, 0.9f, 0.8f}, {0.05f, 0, -0.05f}, {0, 1, 0}, 0.7f)};
  return scene;
}

Scene studio(const Material& floor) {
  Scene scene;
  scene.facts.source = "stress";
  add_sheet(scene, {-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, add_material(scene, floor));
  add_sheet(scene, {-1.2f, 0.12f, -1.15f}, {2.4f, 0, 0}, {0, 1.5f, 0},
            add_material(scene, matte({0.6f, 0.5f, 0.4f})));
  add_sheet(scene, {-0.3f, 1.4f, -0.1f}, {0.6f, 0, 0}, {0, 0, 0.4f}, add_material(scene, glowing({6, 5, 4})));
  add_sheet(scene, {0.22f, 0.45f, 0.1f}, {0.4f, 0.06f, 0.1f}, {-0.05f, 0.1f, -0.35f},
            add_material(scene, matte(Vec3(0.3f))));
  ImageRgb map(32, 16);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      map.at(x, y) = y < 8 ? Vec3(0.3f, 0.4f, 0.6f) * (1 + 0.1f * static_cast<float>(y)) : Vec3(0.15f);
  map.at(19, 4) = Vec3(18, 16, 12);
  scene.environment = make_environment(std::move(map), "soft sky", EnvironmentLayout::latlong);
  scene.cameras = {studio_camera()};
  return scene;
}

PunctualLight point_light(Vec3 position, Vec3 intensity) {
  PunctualLight light;
  light.position = position;
  light.intensity = intensity;
  return light;
}

Scene scaled_lengths(Scene scene, float factor) {
  for (Vertex& vertex : scene.vertices) vertex.position *= factor;
  for (Camera& camera : scene.cameras) camera.position *= factor, camera.half_height *= factor;
  for (PunctualLight& light : scene.lights) {
    light.position *= factor, light.range *= factor;
    if (light.kind != PunctualKind::directional) light.intensity *= factor * factor;
  }
  update_bounds(scene);
  return scene;
}

Scene scaled_radiance(Scene scene, float factor) {
  for (Material& material : scene.materials) material.emission *= factor;
  for (PunctualLight& light : scene.lights) light.intensity *= factor;
  scene.environment.strength *= factor;
  return scene;
}

Scene moved(Scene scene, Vec3 by) {
  for (Vertex& vertex : scene.vertices) vertex.position += by;
  for (Camera& camera : scene.cameras) camera.position += by;
  for (PunctualLight& light : scene.lights) light.position += by;
  update_bounds(scene);
  return scene;
}

}  // namespace halflight
