// Solid things under an environment, after GPU Gems 3, chapter 20: one glossy sphere (fig. 20-5, 20-8b) and a
// bumpy figure (fig. 20-1 shows a rabbit; here a hare of hammered bronze sits on its plinth).
#include "scene/built_in_lit.h"
#include "scene/built_in_rotunda.h"
#include "scene/built_in_scenes.h"
#include "scene/implicit_mesh.h"

namespace halflight {

namespace {

Vec3 turned(Vec3 p, Vec3 about, float radians, int axis) {
  const float c = std::cos(radians), s = std::sin(radians);
  const Vec3 d = p - about;
  const int a = (axis + 1) % 3, b = (axis + 2) % 3;
  Vec3 r = d;
  r[a] = c * d[a] - s * d[b], r[b] = s * d[a] + c * d[b];
  return about + r;
}

/// One ear, for x > 0: a long leaf, hollow in front.
float ear_distance(Vec3 p) {
  const Vec3 root(0.085f, 1.44f, 0.17f);
  const Vec3 q = turned(turned(p, root, 0.20f, 2), root, 0.34f, 0);
  const float leaf = ellipsoid_distance(q, root + Vec3(0, 0.34f, 0), {0.105f, 0.41f, 0.06f});
  const float hollow = ellipsoid_distance(q, root + Vec3(0.01f, 0.34f, 0.065f), {0.066f, 0.31f, 0.055f});
  return -blend_union(-leaf, hollow, 0.03f);
}

/// The hare, facing +z, its mirror halves met at x = 0.
float hare_distance(Vec3 p) {
  const Vec3 m(std::abs(p.x), p.y, p.z);
  float body = ellipsoid_distance(m, {0, 0.50f, -0.20f}, {0.36f, 0.44f, 0.48f});
  body = blend_union(body, ellipsoid_distance(m, {0, 0.76f, 0.12f}, {0.27f, 0.40f, 0.27f}), 0.22f);
  body = blend_union(body, ellipsoid_distance(m, {0.27f, 0.33f, -0.12f}, {0.17f, 0.30f, 0.35f}), 0.06f);
  body =
      blend_union(body, rod_distance(m, {0.33f, 0.08f, -0.22f}, {0.31f, 0.07f, 0.36f}, 0.095f, 0.08f), 0.07f);
  body =
      blend_union(body, rod_distance(m, {0.14f, 0.66f, 0.26f}, {0.125f, 0.10f, 0.40f}, 0.115f, 0.07f), 0.10f);
  body = blend_union(body, ellipsoid_distance(m, {0.125f, 0.06f, 0.47f}, {0.08f, 0.06f, 0.13f}), 0.06f);
  body = blend_union(body, ellipsoid_distance(m, {0, 0.30f, -0.68f}, {0.13f, 0.14f, 0.14f}), 0.08f);
  float head = rod_distance(m, {0, 0.98f, 0.13f}, {0, 1.24f, 0.22f}, 0.21f, 0.17f);
  head = blend_union(head, ellipsoid_distance(m, {0, 1.32f, 0.30f}, {0.185f, 0.19f, 0.25f}), 0.10f);
  head = blend_union(head, ellipsoid_distance(m, {0, 1.25f, 0.49f}, {0.105f, 0.105f, 0.13f}), 0.10f);
  head = blend_union(head, ellipsoid_distance(m, {0.09f, 1.225f, 0.40f}, {0.10f, 0.09f, 0.13f}), 0.07f);
  head = blend_union(head, ear_distance(m), 0.06f);
  return blend_union(body, head, 0.16f);
}

/// Height of the hammer's work over the smooth figure: round bumps with soft creases between, less on face
/// and ears.
float hammered(Vec3 p) {
  const auto bump = [&](float scale, uint32_t seed) {
    const float n = gradient_noise(scale * p, seed);
    return std::sqrt(n * n + 0.004f);
  };
  const float face = glm::smoothstep(0.14f, 0.36f, glm::length(p - Vec3(0, 1.30f, 0.42f)));
  const float ears = 1 - 0.6f * glm::smoothstep(1.4f, 1.6f, p.y);
  return (0.25f + 0.75f * face) * ears * (0.048f * bump(7.5f, 31) + 0.008f * bump(16, 32));
}

float statue_distance(Vec3 p) {
  const Vec3 m(std::abs(p.x), p.y, p.z);
  float figure = hare_distance(p);
  // Its mound of earth.
  figure = blend_union(figure, ellipsoid_distance(p, {0, -0.02f, -0.08f}, {0.56f, 0.10f, 0.72f}), 0.08f);
  if (std::abs(figure) < 0.15f) figure -= hammered(p);
  const float eye = glm::length(m - Vec3(0.155f, 1.37f, 0.425f)) - 0.042f;
  return blend_union(figure, eye, 0.012f);
}

void add_plinth(Scene& scene) {
  const std::vector<Vec2> profile{{0.74f, -1.6f},  {0.74f, -0.42f}, {0.78f, -0.38f}, {0.80f, -0.32f},
                                  {0.78f, -0.26f}, {0.80f, -0.22f}, {0.88f, -0.17f}, {0.90f, -0.11f},
                                  {0.90f, -0.03f}, {0.885f, 0},     {0, 0}};
  place(scene, lathe_mesh(profile, 96),
        add_material(scene, phong_material("slate", {0.20f, 0.21f, 0.22f}, Vec3(0.06f), 25)));
}

}  // namespace

Scene make_glossy_sphere() {
  Scene scene;
  scene.facts.source = "glossy-sphere";
  Mesh sphere = superquadric_mesh(Vec3(1), {1, 1}, 128, 64);
  for (Vertex& v : sphere.vertices) v.normal = glm::normalize(v.position);
  place(scene, sphere,
        add_material(scene, phong_material("glossy", {0.03f, 0.07f, 0.16f}, Vec3(0.75f), 120)));
  scene.environment = rotunda_environment(768);
  add_camera(scene, "main", {0, 0.35f, 3.9f}, Vec3(0), 38);
  update_bounds(scene);
  return scene;
}

Scene make_bumpy_statue() {
  Scene scene;
  scene.facts.source = "bumpy-statue";
  const Mesh hare = implicit_mesh(statue_distance, {{-0.75f, -0.2f, -1.0f}, {0.75f, 2.5f, 0.85f}}, 0.0185f);
  place(scene, hare,
        add_material(scene, phong_material("bronze", {0.17f, 0.095f, 0.042f}, {0.62f, 0.42f, 0.21f}, 40)),
        turn(0.75f, {0, 1, 0}));
  add_plinth(scene);
  scene.environment = rotunda_environment(768);
  add_camera(scene, "main", {0.3f, 1.35f, 4.4f}, {0.02f, 0.95f, 0}, 31.5f);
  update_bounds(scene);
  return scene;
}

}  // namespace halflight
