// The mesh toolkit against areas and volumes known in closed form, and what the built-in scenes promise.
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <map>

#include "scene/built_in_scenes.h"
#include "scene/load.h"
#include "scene/mesh_builder.h"

namespace halflight {
namespace {

/// Volume inside a closed mesh (divergence theorem); negative where the faces point inwards.
double volume(const Mesh& mesh) {
  double sum = 0;
  for (const UVec3 t : mesh.triangles) {
    const Vec3d a = mesh.vertices[t.x].position, b = mesh.vertices[t.y].position,
                c = mesh.vertices[t.z].position;
    sum += glm::dot(a, glm::cross(b, c)) / 6;
  }
  return sum;
}

double area(const Mesh& mesh) {
  double sum = 0;
  for (const UVec3 t : mesh.triangles) {
    const Vec3d a = mesh.vertices[t.x].position, b = mesh.vertices[t.y].position,
                c = mesh.vertices[t.z].position;
    sum += 0.5 * glm::length(glm::cross(b - a, c - a));
  }
  return sum;
}

/// Every edge between two positions is walked once each way: no holes, no flipped face.
bool closed(const Mesh& mesh) {
  using Key = std::array<int, 6>;
  std::map<Key, int> balance;
  const auto quantised = [&](uint32_t v, Key& key, int at) {
    for (int k = 0; k < 3; ++k)
      key[at + k] = static_cast<int>(std::lround(mesh.vertices[v].position[k] * 1e6));
  };
  for (const UVec3 t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      Key forth, back;
      quantised(t[k], forth, 0), quantised(t[(k + 1) % 3], forth, 3);
      quantised(t[(k + 1) % 3], back, 0), quantised(t[k], back, 3);
      ++balance[forth], --balance[back];
    }
  for (const auto& [edge, count] : balance)
    if (count != 0) return false;
  return true;
}

void expect_normals_agree(const Mesh& mesh, float least_cosine) {
  for (const UVec3 t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t.x].position;
    const Vec3 face =
        glm::normalize(glm::cross(mesh.vertices[t.y].position - a, mesh.vertices[t.z].position - a));
    for (int k = 0; k < 3; ++k) {
      const Vec3 n = mesh.vertices[t[k]].normal;
      ASSERT_NEAR(glm::length(n), 1, 1e-4);
      ASSERT_GE(glm::dot(n, face), least_cosine);
    }
  }
}

TEST(MeshBuilder, SharpBoxIsExact) {
  const Mesh box = box_mesh({2, 3, 4});
  EXPECT_EQ(box.triangles.size(), 12u);
  EXPECT_TRUE(closed(box));
  EXPECT_NEAR(volume(box), 24, 1e-5);
  expect_normals_agree(box, 0.9999f);
}

TEST(MeshBuilder, RoundedBoxApproachesItsVolume) {
  const double r = 0.3, x = 2 - 2 * r, y = 3 - 2 * r, z = 4 - 2 * r, exact_pi = 3.14159265358979;
  // Steiner's formula: core, slabs, quarter cylinders, a ball.
  const double exact = x * y * z + 2 * r * (x * y + y * z + z * x) + exact_pi * r * r * (x + y + z) +
                       4 * exact_pi / 3 * r * r * r;
  const Mesh coarse = box_mesh({2, 3, 4}, 0.3f, 2), fine = box_mesh({2, 3, 4}, 0.3f, 12);
  EXPECT_TRUE(closed(fine));
  EXPECT_GT(exact - volume(coarse), 4 * (exact - volume(fine)));
  EXPECT_NEAR(volume(fine), exact, 2e-3 * exact);
  expect_normals_agree(fine, 0.99f);
}

TEST(MeshBuilder, EllipsoidAndLatheAndTubeHaveTheirVolumes) {
  const double exact_pi = 3.14159265358979;
  const Mesh ellipsoid = superquadric_mesh({1, 2, 0.5f}, {1, 1}, 96, 64);
  EXPECT_TRUE(closed(ellipsoid));
  EXPECT_NEAR(volume(ellipsoid), 4 * exact_pi / 3, 0.02);
  expect_normals_agree(ellipsoid, 0.95f);

  const Mesh cone = lathe_mesh(std::vector<Vec2>{{0, 0}, {1, 0}, {0, 3}}, 200);
  EXPECT_TRUE(closed(cone));
  EXPECT_NEAR(volume(cone), exact_pi, 0.01);

  const std::vector<Vec3> path{{0, 0, 0}, {0, 1, 0}, {0, 2, 0}};
  const Mesh tube = tube_mesh(path, 64, 0.25f);
  EXPECT_TRUE(closed(tube));
  EXPECT_NEAR(volume(tube), 2 * exact_pi / 16, 2e-3);
  expect_normals_agree(tube, 0.99f);
}

TEST(MeshBuilder, ExtrusionOfAConcaveOutline) {
  // An L of three unit squares.
  const std::vector<Vec2> outline{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
  const Mesh prism = extrude_mesh(outline, 0.5f);
  EXPECT_NEAR(volume(prism), 1.5, 1e-6);
  EXPECT_NEAR(area(prism), 2 * 3 + 8 * 0.5, 1e-5);
  EXPECT_TRUE(closed(prism));
}

TEST(MeshBuilder, FrameFacesOutAndFront) {
  const Mesh frame = frame_mesh({2, 1}, std::vector<Vec2>{{0, 0.1f}, {0.2f, 0.1f}});
  EXPECT_NEAR(area(frame), 2.4 * 1.4 - 2 * 1, 1e-5);
  for (const Vertex& v : frame.vertices) EXPECT_NEAR(v.normal.z, 1, 1e-5);
}

TEST(MeshBuilder, MirroredPlacementKeepsFrontsOut) {
  Scene scene;
  place(scene, box_mesh(Vec3(1), 0.1f, 2), 0, stretch({-2, 1, 1}));
  Mesh placed{scene.vertices, scene.triangles};
  EXPECT_GT(volume(placed), 1.9);
  expect_normals_agree(placed, 0.8f);
}

TEST(MeshBuilder, PeriodicNoiseRepeats) {
  for (const float x : {0.1f, 1.7f, 3.9f})
    EXPECT_NEAR(periodic_noise({x, 0.3f}, 4, 9), periodic_noise({x + 4, 4.3f}, 4, 9), 1e-5);
  EXPECT_EQ(gradient_noise({3, 4, 5}), 0);  // at the lattice
}

/// What every built-in scene must be to be drawn, traced and saved.
void expect_sound(const Scene& scene) {
  ASSERT_EQ(scene.triangle_material.size(), scene.triangles.size());
  for (const uint32_t m : scene.triangle_material) ASSERT_LT(m, scene.materials.size());
  for (uint32_t t = 0; t < scene.triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) ASSERT_LT(scene.triangles[t][k], scene.vertices.size());
    ASSERT_GT(glm::length(triangle_cross(scene, t)), 0) << "triangle " << t;
  }
  for (const Vertex& v : scene.vertices) {
    ASSERT_TRUE(is_finite(v.position));
    ASSERT_NEAR(glm::length(v.normal), 1, 1e-3);
    ASSERT_TRUE(std::isfinite(v.uv[0].x) && std::isfinite(v.uv[0].y));
  }
  for (const Texture& texture : scene.textures) ASSERT_LT(texture.image, scene.images.size());
  for (const Material& m : scene.materials)
    ASSERT_LT(m.base_color_texture.texture, static_cast<int>(scene.textures.size()));
  ASSERT_FALSE(scene.cameras.empty());
  EXPECT_EQ(scene.cameras[0].name, "main");
  EXPECT_FALSE(scene.bounds.empty());
}

TEST(BuiltInScenes, AreSoundAndTheSameEveryTime) {
  for (const BuiltInScene& built_in : built_in_scenes()) {
    SCOPED_TRACE(built_in.name);
    const Scene a = built_in.make(), b = built_in.make();
    expect_sound(a);
    EXPECT_EQ(a.facts.source, built_in.name);
    ASSERT_EQ(a.vertices.size(), b.vertices.size());
    EXPECT_EQ(std::memcmp(a.vertices.data(), b.vertices.data(), a.vertices.size() * sizeof(Vertex)), 0);
    for (size_t i = 0; i < a.images.size(); ++i) EXPECT_EQ(a.images[i].bytes, b.images[i].bytes);
  }
}

TEST(BuiltInScenes, CornellHasThePublishedMeasures) {
  const Scene scene = make_cornell();
  EXPECT_EQ(scene.bounds.low, Vec3(0));
  EXPECT_EQ(scene.bounds.high, Vec3(556, 548.8f, 559.2f));
  double light_area = 0;
  std::map<uint32_t, double> areas;
  for (uint32_t t = 0; t < scene.triangles.size(); ++t) {
    const Vec3 cross = triangle_cross(scene, t);
    areas[scene.triangle_material[t]] += 0.5 * glm::length(cross);
    if (!scene.materials[scene.triangle_material[t]].emissive()) continue;
    light_area += 0.5 * glm::length(cross);
    EXPECT_LT(glm::normalize(cross).y, -0.999f);  // shines down
  }
  EXPECT_NEAR(light_area, 130 * 105, 1);
  EXPECT_NEAR(areas[1], 548.8 * 559.2, 1);  // the green wall
  // Every inner face is turned to the box's middle, so that a one-sided view shows it from the camera.
  EXPECT_NEAR(glm::degrees(scene.cameras[0].vertical_fov), 39.31, 0.01);
  EXPECT_EQ(scene.cameras[0].position, Vec3(278, 273, -800));
}

TEST(BuiltInScenes, CornellBlocksAreClosed) {
  // Volumes: 165 and 330 over quadrilaterals whose areas follow from the published corners (shoelace
  // formula).
  const auto shoelace = [](std::vector<Vec2> p) {
    double sum = 0;
    for (size_t i = 0; i < p.size(); ++i) {
      const Vec2 a = p[i], b = p[(i + 1) % p.size()];
      sum += static_cast<double>(a.x) * b.y - static_cast<double>(b.x) * a.y;
    }
    return std::abs(sum) / 2;
  };
  const double expected = 165 * shoelace({{130, 65}, {82, 225}, {240, 272}, {290, 114}}) +
                          330 * shoelace({{423, 247}, {265, 296}, {314, 456}, {472, 406}});
  const Scene scene = make_cornell();
  double blocks =
      0;  // of their faces: ten quads, the last triangles of the scene; the bottoms at y = 0 add nothing
  for (size_t t = scene.triangles.size() - 20; t < scene.triangles.size(); ++t) {
    const UVec3 i = scene.triangles[t];
    blocks += glm::dot(Vec3d(scene.vertices[i.x].position),
                       glm::cross(Vec3d(scene.vertices[i.y].position), Vec3d(scene.vertices[i.z].position))) /
              6;
  }
  EXPECT_NEAR(blocks, expected, 1e-4 * expected);
}

TEST(BuiltInScenes, BedroomIsThePapersSize) {
  const Scene scene = make_bedroom();
  EXPECT_NEAR(static_cast<double>(scene.triangles.size()), 95000, 5000);
  ASSERT_EQ(scene.lights.size(), 1u);
  for (const Material& m : scene.materials) EXPECT_FALSE(m.emissive());
  EXPECT_GE(scene.cameras.size(), 2u);
  // Nothing is hidden outside the room: light points would be spent on it.
  EXPECT_GT(scene.bounds.low.y, -0.005f);
  EXPECT_LT(max_component(scene.bounds.extent()), 5.3f);
  for (const Camera& camera : scene.cameras)
    for (int k = 0; k < 3; ++k) {
      EXPECT_GT(camera.position[k], scene.bounds.low[k]);
      EXPECT_LT(camera.position[k], scene.bounds.high[k]);
    }
}

}  // namespace
}  // namespace halflight
