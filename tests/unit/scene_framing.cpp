// The view a scene without a camera gets: objects from outside, rooms from inside, open boxes through their
// open side.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>

#include "scene/camera.h"
#include "scene/load.h"

using namespace halflight;

namespace {

/// Adds a quad of two triangles with the front on the side of edge_u × edge_v.
void add_quad(Scene& scene, Vec3 corner, Vec3 edge_u, Vec3 edge_v) {
  const auto base = static_cast<uint32_t>(scene.vertices.size());
  for (const Vec3 p : {corner, corner + edge_u, corner + edge_u + edge_v, corner + edge_v}) {
    Vertex v{};
    v.position = p;
    v.normal = glm::normalize(glm::cross(edge_u, edge_v));
    scene.vertices.push_back(v);
  }
  scene.triangles.push_back({base, base + 1, base + 2});
  scene.triangles.push_back({base, base + 2, base + 3});
  scene.triangle_material.insert(scene.triangle_material.end(), 2, 0);
}

/// A box with faces to the outside, or to the inside; `open` leaves out the side at +z.
Scene make_box(Vec3 low, Vec3 size, bool inside, bool open) {
  Scene scene;
  scene.materials.resize(1);
  const Vec3 x(size.x, 0, 0), y(0, size.y, 0), z(0, 0, size.z), high = low + size;
  // Edges in the order whose cross product points into the box.
  const auto side = [&](Vec3 corner, Vec3 u, Vec3 v) {
    inside ? add_quad(scene, corner, u, v) : add_quad(scene, corner, v, u);
  };
  side(low, z, x);                // floor
  side(high, -x, -z);             // ceiling: x × z = −y
  side(low, y, z);                // left
  side(high, -z, -y);             // right: z × y = −x
  side(low, x, y);                // back
  if (!open) side(high, -y, -x);  // front: y × x = −z
  update_bounds(scene);
  return scene;
}

void transform(Scene& scene, float scale, Vec3 offset) {
  for (Vertex& v : scene.vertices) v.position = v.position * scale + offset;
  update_bounds(scene);
}

bool inside(const Aabb& box, Vec3 p) {
  return glm::all(glm::greaterThan(p, box.low)) && glm::all(glm::lessThan(p, box.high));
}

const Camera& framed(Scene& scene) {
  Messages messages;
  complete_camera(scene, messages);
  return scene.cameras.at(0);
}

/// Largest distance of a vertex from the centre of a 4:3 picture in half pictures; > 1 is outside, infinity
/// behind.
float greatest_offset(const Scene& scene, const Camera& camera) {
  const float half_height = std::tan(0.5f * camera.vertical_fov);
  float greatest = 0;
  for (const Vertex& v : scene.vertices) {
    const Vec3 p = v.position - camera.position;
    const float depth = -glm::dot(p, camera.back);
    if (depth <= 0) return infinity;
    greatest = std::max({greatest, std::abs(glm::dot(p, camera.right)) / (depth * half_height * 4 / 3),
                         std::abs(glm::dot(p, camera.up)) / (depth * half_height)});
  }
  return greatest;
}

}  // namespace

TEST(SceneFraming, a_camera_of_the_file_stays) {
  Scene scene = make_box(Vec3(0), Vec3(1), false, false);
  scene.cameras.push_back(look_at({3, 3, 3}, {0, 0, 0}, {0, 1, 0}, 1));
  EXPECT_EQ(framed(scene).position, Vec3(3));
  EXPECT_FALSE(scene.facts.added_camera);
}

TEST(SceneFraming, an_empty_scene_gets_a_camera) {
  Scene scene;
  EXPECT_TRUE(framed(scene).generated);
  EXPECT_TRUE(scene.facts.added_camera);
  EXPECT_TRUE(is_finite(scene.cameras[0].position));
}

TEST(SceneFraming, objects_fill_the_picture_from_outside) {
  for (const float scale : {1e-6f, 1.0f, 1e6f}) {
    for (const Vec3 size : {Vec3(1), Vec3(5, 1, 0.01f), Vec3(1, 0, 1), Vec3(0.1f, 3, 0.1f)}) {
      Scene scene = make_box(Vec3(0), size, false, false);
      transform(scene, scale, scale * Vec3(2, -1, 0.5f));
      const Camera& camera = framed(scene);
      EXPECT_TRUE(camera.generated);
      EXPECT_FALSE(inside(scene.bounds, camera.position));
      EXPECT_NEAR(greatest_offset(scene, camera), 0.92f, 0.01f) << scale << " " << size.x;
    }
  }
}

TEST(SceneFraming, rooms_are_seen_from_inside) {
  for (const float scale : {1e-3f, 1.0f, 1e4f}) {
    Scene scene = make_box(Vec3(0), {6, 2.7f, 4}, true, false);
    transform(scene, scale, scale * Vec3(100, 0, -30));
    const Camera& camera = framed(scene);
    ASSERT_TRUE(inside(scene.bounds, camera.position));
    const float height = (camera.position.y - scene.bounds.low.y) / scene.bounds.extent().y;
    EXPECT_GT(height, 0.45f);
    EXPECT_LT(height, 0.75f);
    EXPECT_LT(camera.back.y, 0.3f);
    EXPECT_GT(camera.back.y, 0);
    // The view goes across the room: more than its shorter side is free before the lens.
    const Vec3 ahead = camera.position - scale * 3.5f * camera.back;
    EXPECT_TRUE(ahead.x > scene.bounds.low.x && ahead.x < scene.bounds.high.x);
    EXPECT_TRUE(ahead.z > scene.bounds.low.z && ahead.z < scene.bounds.high.z);
  }
}

TEST(SceneFraming, an_open_box_is_seen_through_its_open_side) {
  Scene scene = make_box(Vec3(0), Vec3(5.5f), true, true);
  const Camera& camera = framed(scene);
  EXPECT_GT(camera.position.z, scene.bounds.high.z);
  EXPECT_NEAR(camera.back.z, 1, 1e-5f);
  EXPECT_NEAR(greatest_offset(scene, camera), 0.92f, 0.01f);
}

TEST(SceneFraming, extreme_coordinates_stay_finite) {
  for (const float size : {1e-42f, 1e-30f, 1e30f, 3e38f}) {
    Scene scene = make_box(Vec3(-0.5f), Vec3(1), false, false);
    transform(scene, size, Vec3(0));
    const Camera& camera = framed(scene);
    EXPECT_TRUE(is_finite(camera.position) && is_finite(camera.right) && is_finite(camera.back)) << size;
  }
}

TEST(SceneFraming, shared_scenes) {
  const std::string folder = HALFLIGHT_SHARED_DATA "/gltf/";
  const auto load = [&](const std::string& path, Scene& scene) {
    if (!std::filesystem::exists(folder + path)) return false;
    Messages messages;
    scene = load_gltf(folder + path, {}, messages);
    return true;
  };
  for (const char* room : {"interiors/hotel-room/hotel-room.glb", "interiors/home-theater/home-theater.gltf",
                           "interiors/garage/garage.gltf"}) {
    Scene scene;
    if (!load(room, scene)) GTEST_SKIP() << "no shared data";
    EXPECT_TRUE(inside(scene.bounds, framed(scene).position)) << room;
  }
  for (const char* object : {"interiors/cornell-bevy/CornellBox.glb", "khronos/Box/Box.glb",
                             "khronos/WaterBottle/WaterBottle.gltf", "misc/shaderball.glb"}) {
    Scene scene;
    if (!load(object, scene)) GTEST_SKIP() << "no shared data";
    scene.cameras.clear();
    EXPECT_FALSE(inside(scene.bounds, framed(scene).position)) << object;
  }
}
