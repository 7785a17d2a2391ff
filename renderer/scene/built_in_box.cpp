// Glossy and matt things in an open box, after the third scene of Wang & Åkerlund 2009 (fig. 5 g–i): 20K
// triangles whose only light is a slide thrown high onto one side of the box; what it meets lights the rest.
#include "scene/built_in_lit.h"
#include "scene/built_in_scenes.h"
#include "scene/built_in_slides.h"
#include "scene/built_in_textures.h"

namespace halflight {

namespace {

constexpr Vec3 half_size{1.8f, 1.5f, 2.0f};  // of the box; its floor is y = 0, it opens towards +z

void add_shell(Scene& scene) {
  const float w = 2 * half_size.x, h = 2 * half_size.y, d = 2 * half_size.z;
  const uint32_t white = add_material(scene, phong_material("plaster", {0.80f, 0.77f, 0.72f}, Vec3(0), 1));
  const uint32_t blue = add_material(scene, phong_material("blue paint", {0.34f, 0.50f, 0.64f}, Vec3(0), 1));
  Material boards = phong_material("polished boards", Vec3(0.85f), Vec3(0.14f), 80);
  boards.base_color_texture = add_texture(
      scene, board_texture(512, 8, {0.50f, 0.30f, 0.16f}, {0.26f, 0.14f, 0.07f}, 43), "boards", {1.6f, 2.4f});
  const uint32_t floor = add_material(scene, boards);
  place(scene, rectangle_mesh({-0.5f * w, 0, 0.5f * d}, {w, 0, 0}, {0, 0, -d}), floor);
  place(scene, rectangle_mesh({-0.5f * w, h, -0.5f * d}, {w, 0, 0}, {0, 0, d}), white);
  place(scene, rectangle_mesh({-0.5f * w, 0, -0.5f * d}, {w, 0, 0}, {0, h, 0}), white);
  place(scene, rectangle_mesh({-0.5f * w, 0, 0.5f * d}, {0, 0, -d}, {0, h, 0}), white);
  place(scene, rectangle_mesh({0.5f * w, 0, -0.5f * d}, {0, 0, d}, {0, h, 0}), blue);
}

/// Stands a mesh with its lowest point at `at`.
void stand(Scene& scene, const Mesh& mesh, uint32_t material, Vec3 at, const Mat4& pose = Mat4(1)) {
  place(scene, mesh, material, move(at - Vec3(0, lowest_point(mesh, pose), 0)) * pose);
}

void add_knot(Scene& scene) {
  const uint32_t stone = add_material(scene, phong_material("limestone", {0.66f, 0.61f, 0.54f}, Vec3(0), 1));
  const uint32_t gold =
      add_material(scene, phong_material("gold", {0.26f, 0.13f, 0.035f}, {0.70f, 0.43f, 0.15f}, 50));
  const Vec3 at(0.15f, 0, -0.75f);
  const float yaw = glm::radians(24.0f);
  stand(scene, box_mesh({0.95f, 0.55f, 0.8f}, 0.03f, 4), stone, at, turn(yaw, {0, 1, 0}));
  stand(scene, trefoil_mesh(0.52f, 210, 22), gold, at + Vec3(0, 0.55f, 0),
        turn(-0.35f, {0, 1, 0}) * turn(pi / 6, {0, 0, 1}) * stretch(Vec3(0.215f)));
}

void add_vase(Scene& scene) {
  const uint32_t glaze =
      add_material(scene, phong_material("oxblood glaze", {0.36f, 0.045f, 0.03f}, Vec3(0.22f), 40));
  const std::vector<Vec2> knots{{0.17f, 0.0f},  {0.25f, 0.14f}, {0.335f, 0.42f}, {0.30f, 0.66f},
                                {0.16f, 0.86f}, {0.115f, 1.0f}, {0.17f, 1.13f}};
  std::vector<Vec2> profile{{0, 0}};
  for (const Vec2 p : smooth_curve(knots, 5)) profile.push_back(p);
  profile.push_back({0.16f, 1.135f});
  for (const Vec2 p : {Vec2(0.105f, 1.0f), Vec2(0.14f, 0.86f), Vec2(0.1f, 0.7f), Vec2(0, 0.68f)})
    profile.push_back(p);
  stand(scene, lathe_mesh(profile, 52), glaze, {-0.85f, 0, -0.1f});
}

void add_balls_and_cubes(Scene& scene) {
  const auto ball = [&](const Material& material, float radius, Vec2 at, int columns) {
    stand(scene, superquadric_mesh(Vec3(radius), {1, 1}, columns, columns / 2), add_material(scene, material),
          {at.x, 0, at.y});
  };
  ball(phong_material("teal enamel", {0.03f, 0.13f, 0.14f}, Vec3(0.45f), 100), 0.46f, {1.08f, 0.35f}, 50);
  ball(phong_material("chalk", {0.74f, 0.72f, 0.68f}, Vec3(0), 1), 0.19f, {-0.42f, 0.72f}, 32);
  ball(phong_material("mustard", {0.62f, 0.36f, 0.05f}, Vec3(0.08f), 20), 0.135f, {-0.78f, 0.88f}, 28);
  ball(phong_material("pewter", {0.10f, 0.10f, 0.11f}, Vec3(0.6f), 100), 0.15f, {0.22f, 1.02f}, 32);
  const uint32_t sage = add_material(scene, phong_material("sage", {0.30f, 0.42f, 0.26f}, Vec3(0.05f), 10));
  const uint32_t rose = add_material(scene, phong_material("rose", {0.58f, 0.26f, 0.24f}, Vec3(0.05f), 10));
  stand(scene, box_mesh(Vec3(0.36f), 0.03f, 3), sage, {1.22f, 0, -0.95f}, turn(0.3f, {0, 1, 0}));
  stand(scene, box_mesh(Vec3(0.25f), 0.025f, 3), rose, {1.22f, 0.36f, -0.95f}, turn(-0.4f, {0, 1, 0}));
}

}  // namespace

Scene make_box() {
  Scene scene;
  scene.facts.source = "box";
  add_shell(scene);
  add_knot(scene);
  add_vase(scene);
  add_balls_and_cubes(scene);
  add_projector(scene, aimed_spot("projector", {1.55f, 2.6f, 1.3f}, {-1.8f, 1.62f, -0.25f}, 15.5f, Vec3(180)),
                rose_window_slide(512));
  // Out of the picture, on the near half of the right wall.
  scene.lights.push_back(
      aimed_spot("fill", {-1.2f, 2.7f, 1.9f}, {1.8f, 1.6f, 0.95f}, 14, 200.0f * Vec3(1, 0.92f, 0.80f)));
  add_camera(scene, "main", {0.9f, 1.5f, 6.0f}, {-0.46f, 1.3f, 0}, 31.5f);
  update_bounds(scene);
  return scene;
}

}  // namespace halflight
