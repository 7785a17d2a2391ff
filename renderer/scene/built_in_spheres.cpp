#include "scene/built_in_spheres.h"

#include <fmt/format.h>

#include "scene/built_in_environments.h"
#include "scene/built_in_lit.h"
#include "scene/built_in_scenes.h"

namespace halflight {

namespace {

Mesh round_ball(int columns, int rows) {
  Mesh ball = superquadric_mesh(Vec3(1), {1, 1}, columns, rows);
  for (Vertex& v : ball.vertices) v.normal = glm::normalize(v.position);
  return ball;
}

/// A sheet that rises behind the balls in a quarter circle, so that no edge divides the picture.
Mesh backdrop() {
  const std::vector<Vec2> bends{{9, 0},        {2, 0},        {-3.2f, 0},   {-5.0f, 0.35f},
                                {-6.2f, 1.6f}, {-6.6f, 3.2f}, {-6.8f, 6.5f}};
  const std::vector<Vec2> profile = smooth_curve(bends, 8);
  const float last = static_cast<float>(profile.size() - 1);
  Mesh sheet = grid_mesh({24, static_cast<int>(last)}, [&](float u, float v) {
    const Vec2 at = profile[static_cast<size_t>(std::lround(v * last))];
    return Vec3(28 * (u - 0.5f), std::max(at.y, 0.0f), at.x);  // the curve swings a little below
  });
  smooth_normals(sheet, 3);
  return sheet;
}

}  // namespace

Scene make_phong_sphere(float exponent, const Environment& environment) {
  Scene scene;
  scene.facts.source = fmt::format("phong-sphere-{:g}", exponent);
  place(scene, round_ball(128, 64),
        add_material(scene, phong_material("phong", Vec3(0.2f), Vec3(0.7f), exponent)));
  scene.environment = environment;
  add_camera(scene, "main", {0, 0.35f, 3.9f}, Vec3(0), 38);
  update_bounds(scene);
  return scene;
}

Scene make_spheres() {
  Scene scene;
  scene.facts.source = "spheres";
  place(scene, backdrop(),
        add_material(scene, phong_material("paper", Vec3(0.34f, 0.335f, 0.33f), Vec3(0), 1)));
  // Three times as sharp from each to the next; all reflect the same at normal incidence.
  const float exponents[] = {1, 3, 10, 30, 100, 300, 1000, 3000};
  const Vec3 tints[] = {{0.85f, 0.42f, 0.20f}, {0.80f, 0.80f, 0.82f}};
  const Mesh ball = round_ball(64, 32);
  for (int i = 0; i < 8; ++i) {
    const int row = i / 4, column = i % 4;
    const Vec3 tint = tints[row];
    const Material material =
        phong_material(fmt::format("n = {:g}", exponents[i]), 0.25f * tint, 0.72f * tint, exponents[i]);
    const Vec3 place_of(2.3f * (static_cast<float>(column) - 1.5f), 1, row == 0 ? -1.5f : 1.5f);
    place(scene, ball, add_material(scene, material), move(place_of));
  }
  scene.environment = make_built_in_environment("studio");
  add_camera(scene, "main", {0, 8.2f, 11.0f}, {0, 0.45f, 0.15f}, 33.5f);
  update_bounds(scene);
  return scene;
}

}  // namespace halflight
