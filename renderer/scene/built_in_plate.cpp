// A brushed plate on a table, after the fourth scene of Wang & Åkerlund 2009 (fig. 5 j–m): 1K triangles, an
// anisotropic Phong plate under projected light. The slide, a window at sunset with a far brighter sun, falls
// on the wall behind; the plate draws it out across its grooves.
#include "scene/built_in_lit.h"
#include "scene/built_in_scenes.h"
#include "scene/built_in_slides.h"
#include "scene/built_in_textures.h"

namespace halflight {

namespace {

/// Turned on a lathe: its grooves run round, so that the lobe is narrow along them and wide across.
Material brushed_brass() {
  Material material;
  material.name = "brushed brass";
  material.model = BrdfModel::ashikhmin_shirley;
  material.diffuse = {0.035f, 0.024f, 0.010f};
  material.phong_specular = {0.80f, 0.62f, 0.36f};
  material.exponents = {1000, 10};
  return material;
}

void add_room(Scene& scene) {
  const uint32_t wall = add_material(scene, phong_material("wall", {0.78f, 0.75f, 0.70f}, Vec3(0), 1));
  Material wood = phong_material("table", Vec3(0.9f), Vec3(0.10f), 50);
  wood.base_color_texture = add_texture(
      scene, grain_texture(512, {0.34f, 0.19f, 0.10f}, {0.17f, 0.085f, 0.045f}, 15), "walnut", {0.5f, 1.4f});
  wood.base_color_texture.row_u = {0, 2, 0}, wood.base_color_texture.row_v = {0.7f, 0, 0};
  place(scene, rectangle_mesh({-0.6f, 0, 0.7f}, {1.4f, 0, 0}, {0, 0, -1.15f}), add_material(scene, wood));
  place(scene, rectangle_mesh({-0.6f, 0, -0.45f}, {1.4f, 0, 0}, {0, 0.9f, 0}), wall);
  place(scene, rectangle_mesh({-0.6f, 0, 0.7f}, {0, 0, -1.15f}, {0, 0.9f, 0}), wall);
}

void add_plate(Scene& scene) {
  const std::vector<Vec2> profile{{0.155f, 0},       {0.1935f, 0.0215f}, {0.1955f, 0.0235f},
                                  {0.193f, 0.0255f}, {0.140f, 0.0140f},  {0.132f, 0.0080f},
                                  {0.118f, 0.0060f}, {0, 0.0075f}};
  Mesh plate = lathe_mesh(profile, 54, 0.3f);
  set_lathe_tangents(plate);
  place(scene, plate, add_material(scene, brushed_brass()));
}

void add_fruit(Scene& scene) {
  const uint32_t skin = add_material(scene, phong_material("plum", {0.10f, 0.02f, 0.05f}, Vec3(0.12f), 30));
  place(scene, superquadric_mesh({0.036f, 0.033f, 0.034f}, {1, 1}, 16, 10), skin,
        move({-0.245f, 0.033f, 0.035f}));
}

}  // namespace

Scene make_plate() {
  Scene scene;
  scene.facts.source = "plate";
  add_room(scene);
  add_plate(scene);
  add_fruit(scene);
  add_projector(scene, aimed_spot("sunset", {0.45f, 0.66f, 0.70f}, {0.02f, 0.32f, -0.45f}, 16.5f, Vec3(8)),
                sunset_window_slide(512, 40));
  PunctualLight side = aimed_spot("evening", {0.75f, 0.70f, 0.45f}, {-0.6f, 0.36f, 0.12f}, 16.5f, Vec3(13));
  side.picture = scene.lights[0].picture;
  scene.lights.push_back(side);
  add_camera(scene, "main", {0.10f, 0.40f, 0.62f}, {-0.02f, 0.095f, -0.05f}, 43);
  update_bounds(scene);
  return scene;
}

}  // namespace halflight
