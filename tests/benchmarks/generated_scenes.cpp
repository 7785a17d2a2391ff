#include "benchmarks/generated_scenes.h"

#include <cmath>

#include "scene/built_in_lit.h"

namespace halflight {

namespace {

/// The knot's centre line, t in [0, 1).
Vec3 knot_line(float t) {
  const float a = 2 * pi * t, r = 0.55f + 0.22f * std::cos(3 * a);
  return {r * std::cos(2 * a), 0.22f * std::sin(3 * a), r * std::sin(2 * a)};
}

/// Normals of a closed grid from its faces: neighbours are known, so that nothing has to be welded.
void normals_from_faces(Mesh& mesh) {
  for (const UVec3& t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t.x].position;
    const Vec3 cross = glm::cross(mesh.vertices[t.y].position - a, mesh.vertices[t.z].position - a);
    for (int k = 0; k < 3; ++k) mesh.vertices[t[k]].normal += cross;
  }
  for (Vertex& vertex : mesh.vertices) vertex.normal = glm::normalize(vertex.normal);
}

void add_walls(Scene& scene) {
  const uint32_t white = add_material(scene, plain_material("wall", Vec3(0.7f), 1));
  const uint32_t red = add_material(scene, plain_material("left", {0.6f, 0.2f, 0.15f}, 1));
  const Vec3 size(4, 3, 4), low(-2, 0, -2), high(2, 3, 2);
  place(scene, rectangle_mesh(low, {0, 0, size.z}, {size.x, 0, 0}), white);
  place(scene, rectangle_mesh({low.x, high.y, low.z}, {size.x, 0, 0}, {0, 0, size.z}), white);
  place(scene, rectangle_mesh(low, {size.x, 0, 0}, {0, size.y, 0}), white);
  place(scene, rectangle_mesh({low.x, low.y, high.z}, {0, size.y, 0}, {size.x, 0, 0}), white);
  place(scene, rectangle_mesh(low, {0, size.y, 0}, {0, 0, size.z}), red);
  place(scene, rectangle_mesh({high.x, low.y, low.z}, {0, 0, size.z}, {0, size.y, 0}), white);
}

void add_lamp(Scene& scene) {
  Material lamp = plain_material("lamp", Vec3(0), 1);
  lamp.emission = Vec3(12);
  place(scene, rectangle_mesh({-0.4f, 2.95f, -0.4f}, {0.8f, 0, 0}, {0, 0, 0.8f}), add_material(scene, lamp));
}

}  // namespace

Mesh knot_mesh(size_t triangles) {
  // Quads about as long as wide: the line is some 10 long, the tube 0.9 round.
  const auto rows = static_cast<uint32_t>(std::max(3.0, std::round(std::sqrt(triangles / 22.0))));
  const auto columns = static_cast<uint32_t>(std::max<size_t>(3, (triangles / 2 + rows / 2) / rows));
  Mesh mesh;
  mesh.vertices.reserve(size_t{columns} * rows);
  mesh.triangles.reserve(2 * size_t{columns} * rows);
  for (uint32_t i = 0; i < columns; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(columns);
    const Vec3 centre = knot_line(t), along = glm::normalize(knot_line(t + 1e-3f) - knot_line(t - 1e-3f));
    const Vec3 across = glm::normalize(glm::cross(along, Vec3(0, 1, 0))), up = glm::cross(across, along);
    for (uint32_t j = 0; j < rows; ++j) {
      const float angle = 2 * pi * static_cast<float>(j) / static_cast<float>(rows);
      const float radius = 0.13f + 0.012f * std::sin(8 * angle + 60 * pi * t);
      const Vec3 out = std::cos(angle) * across + std::sin(angle) * up;
      mesh.vertices.push_back({centre + radius * out,
                               Vec3(0),
                               Vec4(0),
                               {Vec2(20 * t, static_cast<float>(j) / static_cast<float>(rows)), Vec2(0)},
                               0xffffffffu});
    }
  }
  const auto index = [&](uint32_t i, uint32_t j) { return i % columns * rows + j % rows; };
  for (uint32_t i = 0; i < columns; ++i)
    for (uint32_t j = 0; j < rows; ++j) {
      mesh.triangles.emplace_back(index(i, j), index(i, j + 1), index(i + 1, j));
      mesh.triangles.emplace_back(index(i + 1, j), index(i, j + 1), index(i + 1, j + 1));
    }
  normals_from_faces(mesh);
  return mesh;
}

Scene empty_room() {
  Scene scene;
  scene.facts.source = "generated room";
  add_walls(scene);
  add_lamp(scene);
  add_camera(scene, "main", {1.7f, 1.7f, 1.8f}, {-0.2f, 1.1f, -0.3f}, 55);
  update_bounds(scene);
  return scene;
}

Scene knot_room(size_t triangles, Growth growth) {
  Scene scene = empty_room();
  const uint32_t gloss = add_material(scene, plain_material("knot", {0.5f, 0.35f, 0.15f}, 0.35f));
  if (growth == Growth::mesh) {
    place(scene, knot_mesh(triangles), gloss, move({0, 1.1f, -0.3f}));
  } else {
    constexpr size_t in_a_copy = 5000;
    const Mesh knot = knot_mesh(in_a_copy);
    const auto copies = std::max<size_t>(1, (triangles + in_a_copy / 2) / in_a_copy);
    const auto side = static_cast<size_t>(std::ceil(std::cbrt(static_cast<double>(copies))));
    const float step = 1.8f / static_cast<float>(side);
    for (size_t i = 0; i < copies; ++i) {
      const Vec3 cell(static_cast<float>(i % side), static_cast<float>(i / side % side),
                      static_cast<float>(i / side / side));
      place(scene, knot, gloss,
            move(Vec3(-0.9f, 0.2f, -1.2f) + step * (cell + 0.5f)) * stretch(Vec3(0.5f * step)));
    }
  }
  update_bounds(scene);
  return scene;
}

Scene bare_knot(size_t triangles) {
  Scene scene;
  scene.facts.source = "generated knot";
  place(scene, knot_mesh(triangles),
        add_material(scene, plain_material("knot", {0.5f, 0.35f, 0.15f}, 0.35f)));
  update_bounds(scene);
  return scene;
}

}  // namespace halflight
