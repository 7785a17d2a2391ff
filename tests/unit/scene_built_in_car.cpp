// The built-in scene `car` and what its skin is made with: meshes cut along lines on a surface.
#include <gtest/gtest.h>

#include <set>

#include "scene/built_in_car.h"
#include "scene/built_in_scenes.h"

namespace halflight {
namespace {

double area(const Mesh& mesh) {
  double sum = 0;
  for (const UVec3 t : mesh.triangles) {
    const Vec3 a = mesh.vertices[t.x].position;
    sum += 0.5 * glm::length(glm::cross(mesh.vertices[t.y].position - a, mesh.vertices[t.z].position - a));
  }
  return sum;
}

float ball(Vec3 p) { return glm::length(p) - 1; }

Mesh ball_mesh() {
  Mesh mesh = implicit_mesh(ball, {Vec3(-1.2f), Vec3(1.2f)}, 0.06f);
  settle(mesh, ball);
  return mesh;
}

TEST(CutMesh, ZonesOfASphereHaveTheirAreas) {
  const Mesh whole = ball_mesh();
  for (const Vertex& v : whole.vertices) ASSERT_NEAR(glm::length(v.position), 1, 1e-5);
  // Archimedes: a zone's area is 2π times its height.
  for (const float height : {-0.61f, 0.0f, 0.33f}) {
    const CutMesh cut = cut_mesh(whole, ball, [&](Vec3 p) { return p.y - height; });
    EXPECT_NEAR(area(cut.inside), 2 * pi * (height + 1), 0.02);
    EXPECT_NEAR(area(cut.outside), 2 * pi * (1 - height), 0.02);
    for (const Vertex& v : cut.inside.vertices) ASSERT_LT(v.position.y, height + 1e-4f);
    for (const Vertex& v : cut.outside.vertices) ASSERT_GT(v.position.y, height - 1e-4f);
  }
}

TEST(CutMesh, NewVerticesLieOnSurfaceAndLineWithItsNormal) {
  const Mesh whole = ball_mesh();
  const auto line = [](Vec3 p) { return glm::length(Vec2(p.x, p.z)) - 0.5f; };
  const CutMesh cut = cut_mesh(whole, ball, line);
  size_t on_line = 0;
  for (const Vertex& v : cut.inside.vertices) {
    ASSERT_NEAR(glm::length(v.position), 1, 1e-5);
    ASSERT_LT(glm::length(v.normal - v.position), 2e-3f);
    on_line += std::abs(line(v.position)) < 1e-4f;
  }
  EXPECT_GT(on_line, 2 * 2 * pi * 0.5 / 0.06);  // both caps have an edge, a vertex a cell or more
}

TEST(CutMesh, ALineBesideTheMeshLeavesItWhole) {
  const Mesh whole = ball_mesh();
  const CutMesh cut = cut_mesh(whole, ball, [](Vec3 p) { return p.x - 3; });
  EXPECT_EQ(cut.inside.triangles.size(), whole.triangles.size());
  EXPECT_TRUE(cut.outside.triangles.empty());
}

TEST(Superellipsoid, IsAnEllipsoidAtTwoAndFirstOrderElsewhere) {
  const Vec3 centre(0.3f, -0.2f, 0.5f), radii(2, 0.5f, 1);
  for (const Vec3 d : {Vec3(1, 0, 0), Vec3(0.3f, 0.9f, -0.2f), Vec3(-0.5f, 0.1f, 0.8f), Vec3(0, -1, 0)}) {
    const Vec3 p = centre + 1.1f * glm::normalize(d) * radii;
    EXPECT_NEAR(superellipsoid_distance(p, centre, radii, Vec2(2)), ellipsoid_distance(p, centre, radii),
                0.012);
    // Zero on the surface, found along the ray; there the slope along the normal is 1.
    const Vec2 e(2.7f, 2.2f);
    float low = 0.1f, high = 3;
    for (int i = 0; i < 30; ++i) {
      const float t = 0.5f * (low + high);
      const Vec3 q = glm::abs(t * glm::normalize(d));
      const float norm = std::pow(std::pow(q.x, e.x) + std::pow(q.z, e.x), e.y / e.x) + std::pow(q.y, e.y);
      (norm < 1 ? low : high) = t;
    }
    const Vec3 on = centre + low * glm::normalize(d) * radii;
    EXPECT_NEAR(superellipsoid_distance(on, centre, radii, e), 0, 1e-4);
    Vec3 slope;
    for (int a = 0; a < 3; ++a) {
      Vec3 step(0);
      step[a] = 1e-3f;
      slope[a] = (superellipsoid_distance(on + step, centre, radii, e) -
                  superellipsoid_distance(on - step, centre, radii, e)) /
                 2e-3f;
    }
    EXPECT_NEAR(glm::length(slope), 1, 0.02);
  }
}

TEST(BuiltInCar, IsThePapersSizeAndKind) {
  const Scene scene = make_car();
  EXPECT_GE(scene.triangles.size(), 27'000u);
  EXPECT_LE(scene.triangles.size(), 33'000u);
  EXPECT_TRUE(scene.environment.present());
  EXPECT_TRUE(scene.lights.empty());
  std::set<float> exponents;
  for (const Material& m : scene.materials) {
    EXPECT_EQ(m.model, BrdfModel::phong);
    EXPECT_LE(m.exponents.x,
              100);  // "BRDFs vary from diffuse to Phong with the exponent parameter up to 100"
    EXPECT_LE(max_component(m.diffuse + m.phong_specular), 1);
    exponents.insert(m.exponents.x);
  }
  EXPECT_TRUE(exponents.count(100));
  ASSERT_EQ(scene.cameras.size(), 3u);
  EXPECT_EQ(scene.cameras[1].name, "side");
}

/// Vertices of the parts of which `chosen(material name)` holds.
template <class Chosen>
std::vector<Vertex> part_vertices(const Scene& scene, Chosen&& chosen) {
  std::vector<Vertex> all;
  for (uint32_t t = 0; t < scene.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k)
      if (chosen(scene.materials[scene.triangle_material[t]].name))
        all.push_back(scene.vertices[scene.triangles[t][k]]);
  return all;
}

TEST(BuiltInCar, StandsOnItsTyresAndIsTheSameOnBothSides) {
  const Scene scene = make_car();
  Aabb bounds;
  double moment = 0;
  const std::vector<Vertex> car =
      part_vertices(scene, [](const std::string& name) { return name != "ground"; });
  for (const Vertex& v : car) bounds.extend(v.position), moment += v.position.z;
  EXPECT_NEAR(bounds.low.y, 0, 1e-3);
  EXPECT_NEAR(bounds.low.z, -bounds.high.z, 0.01);
  EXPECT_NEAR(moment / static_cast<double>(car.size()), 0, 0.01);
  EXPECT_NEAR(bounds.extent().x, 4.0, 0.25);
  EXPECT_NEAR(bounds.high.y, 1.27, 0.05);
}

TEST(BuiltInCar, EveryPartTouchesTheBody) {
  // Nothing floats: all but the wheels lies within a hand of the skin, mirrors included.
  const Scene scene = make_car();
  for (uint32_t t = 0; t < scene.triangles.size(); ++t) {
    const std::string& name = scene.materials[scene.triangle_material[t]].name;
    if (name == "ground" || name == "tyre" || name == "rim") continue;
    for (int k = 0; k < 3; ++k) {
      const Vec3 p = scene.vertices[scene.triangles[t][k]].position;
      ASSERT_LT(car_body_distance(p), 0.25f) << name << " at " << p.x << ", " << p.y << ", " << p.z;
    }
  }
}

TEST(BuiltInCar, PaintIsSmooth) {
  // Corner normals of the skin are the surface's own: they turn no more than a small triangle allows.
  const Scene scene = make_car();
  size_t checked = 0;
  for (const Vertex& v :
       part_vertices(scene, [](const std::string& name) { return name == "paint" || name == "glass"; })) {
    if (std::abs(car_body_distance(v.position)) > 1e-5f) continue;
    Vec3 gradient;
    for (int a = 0; a < 3; ++a) {
      Vec3 step(0);
      step[a] = 1e-3f;
      gradient[a] = car_body_distance(v.position + step) - car_body_distance(v.position - step);
    }
    ASSERT_GT(glm::dot(glm::normalize(gradient), v.normal), 0.98f);
    ++checked;
  }
  EXPECT_GT(checked, 20'000u);
}

}  // namespace
}  // namespace halflight
