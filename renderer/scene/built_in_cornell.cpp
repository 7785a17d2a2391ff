// The Cornell box: geometry, camera and spectra as Cornell University's Program of Computer Graphics
// published them
// ("The Cornell Box: comparison data", 1998; lengths in millimetres). The measured spectra were weighted with
// the 1931 colour matching functions (fit of Wyman et al. 2013) under D65 and divided by a white's; the
// lamp's three-point spectrum likewise, under equal energy. Primaries are Rec. 709.
#include "scene/built_in_scenes.h"
#include "scene/camera.h"
#include "scene/mesh_builder.h"

namespace halflight {

namespace {

void add_face(Scene& scene, uint32_t material, Vec3 a, Vec3 b, Vec3 c, Vec3 d) {
  Mesh mesh;
  const Vec3 corners[4] = {a, b, c, d};
  const Vec2 uvs[4] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (int i = 0; i < 4; ++i) add_vertex(mesh, corners[i], uvs[i]);
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  smooth_normals(mesh);
  place(scene, mesh, material);
}

/// Upright block over a quadrilateral given as (x, z), in the order of the published top faces.
void add_block(Scene& scene, uint32_t material, const Vec2 (&plan)[4], float height) {
  const auto corner = [&](int i, float y) { return Vec3(plan[i % 4].x, y, plan[i % 4].y); };
  add_face(scene, material, corner(0, height), corner(1, height), corner(2, height), corner(3, height));
  for (int i = 0; i < 4; ++i)
    add_face(scene, material, corner(i, 0), corner(i + 1, 0), corner(i + 1, height), corner(i, height));
}

void add_walls(Scene& scene, uint32_t white, uint32_t green, uint32_t red) {
  add_face(scene, white, {552.8f, 0, 0}, {0, 0, 0}, {0, 0, 559.2f}, {549.6f, 0, 559.2f});
  add_face(scene, white, {549.6f, 0, 559.2f}, {0, 0, 559.2f}, {0, 548.8f, 559.2f}, {556, 548.8f, 559.2f});
  add_face(scene, green, {0, 0, 559.2f}, {0, 0, 0}, {0, 548.8f, 0}, {0, 548.8f, 559.2f});
  add_face(scene, red, {552.8f, 0, 0}, {549.6f, 0, 559.2f}, {556, 548.8f, 559.2f}, {556, 548.8f, 0});
  // The ceiling has the light's opening: four pieces around it.
  const Vec3 outer[4] = {{556, 548.8f, 0}, {556, 548.8f, 559.2f}, {0, 548.8f, 559.2f}, {0, 548.8f, 0}};
  const Vec3 inner[4] = {{343, 548.8f, 227}, {343, 548.8f, 332}, {213, 548.8f, 332}, {213, 548.8f, 227}};
  for (int i = 0; i < 4; ++i)
    add_face(scene, white, outer[i], outer[(i + 1) % 4], inner[(i + 1) % 4], inner[i]);
}

}  // namespace

Scene make_cornell() {
  Scene scene;
  scene.facts.source = "cornell";
  const uint32_t white = add_material(scene, plain_material("white", {0.738f, 0.736f, 0.740f}, 1));
  const uint32_t green = add_material(scene, plain_material("green", {0.071f, 0.398f, 0.087f}, 1));
  const uint32_t red = add_material(scene, plain_material("red", {0.487f, 0.050f, 0.051f}, 1));
  // The measured paints are matte: no dielectric coat.
  for (Material& paint : scene.materials) paint.specular = 0;
  Material lamp = plain_material("light", {0.78f, 0.78f, 0.78f}, 1);
  lamp.specular = 0;
  // The published spectrum has no absolute unit; this strength exposes well as it is.
  lamp.emission = {34.4f, 23.0f, 6.2f};
  const uint32_t light = add_material(scene, lamp);

  add_walls(scene, white, green, red);
  add_face(scene, light, {343, 548.8f, 227}, {343, 548.8f, 332}, {213, 548.8f, 332}, {213, 548.8f, 227});
  add_block(scene, white, {{130, 65}, {82, 225}, {240, 272}, {290, 114}}, 165);
  add_block(scene, white, {{423, 247}, {265, 296}, {314, 456}, {472, 406}}, 330);

  // Focal length 0.035, film 0.025 high.
  Camera camera = look_at({278, 273, -800}, {278, 273, 0}, {0, 1, 0}, 2 * std::atan(0.5f * 0.025f / 0.035f));
  camera.name = "main";
  scene.cameras.push_back(camera);
  update_bounds(scene);
  return scene;
}

}  // namespace halflight
