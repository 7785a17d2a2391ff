// Scenes of a few triangles with known answers.
#pragma once

#include "scene/scene.h"

namespace halflight {

/// Adds the quadrilateral corner, corner + u, corner + u + v, corner + v; its front is towards u × v.
inline void add_patch(Scene& scene, Vec3 corner, Vec3 u, Vec3 v, uint32_t material = 0) {
  const auto first = static_cast<uint32_t>(scene.vertices.size());
  const Vec3 n = glm::normalize(glm::cross(u, v));
  const Vec2 uvs[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  int i = 0;
  for (const Vec3 p : {corner, corner + u, corner + u + v, corner + v})
    scene.vertices.push_back({p, n, Vec4(0), {uvs[i], uvs[i]}, 0xffffffffu}), ++i;
  for (const UVec3 t : {UVec3(0, 1, 2), UVec3(0, 2, 3)}) {
    scene.triangles.push_back(t + first);
    scene.triangle_material.push_back(material);
  }
  update_bounds(scene);
}

/// A grey diffuse material: modified Phong without a lobe.
inline Material diffuse_material(Vec3 reflectance) {
  Material material;
  material.model = BrdfModel::phong;
  material.diffuse = reflectance;
  return material;
}

/// A floor of edge `size` about the origin facing +y.
inline Scene floor_scene(float size, Vec3 reflectance = Vec3(0.5f)) {
  Scene scene;
  scene.materials.push_back(diffuse_material(reflectance));
  add_patch(scene, {-size / 2, 0, size / 2}, {size, 0, 0}, {0, 0, -size});
  return scene;
}

/// A map of one radiance everywhere.
inline Environment constant_environment(Vec3 radiance, int width = 64) {
  return make_environment(ImageRgb(width, width / 2, radiance), "constant", EnvironmentLayout::latlong);
}

}  // namespace halflight
