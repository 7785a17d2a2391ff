#include <gtest/gtest.h>

#include <array>
#include <numeric>

#include "core/parallel.h"
#include "core/random.h"
#include "lights/light_points.h"
#include "lights/surface_walk.h"
#include "support/simple_scenes.h"

namespace halflight {
namespace {

/// A 2 × 2 × 2 box whose corners are vertices of their own on each face.
Scene box_scene() {
  Scene scene;
  scene.materials.push_back(diffuse_material(Vec3(0.5f)));
  add_patch(scene, {0, 0, 0}, {2, 0, 0}, {0, 0, 2});
  add_patch(scene, {0, 2, 0}, {0, 0, 2}, {2, 0, 0});
  add_patch(scene, {0, 0, 0}, {0, 2, 0}, {2, 0, 0});
  add_patch(scene, {0, 0, 2}, {2, 0, 0}, {0, 2, 0});
  add_patch(scene, {0, 0, 0}, {0, 0, 2}, {0, 2, 0});
  add_patch(scene, {2, 0, 0}, {0, 2, 0}, {0, 0, 2});
  return scene;
}

/// Mean distance to the nearest neighbour over that of a hexagonal lattice: 1 is the most even there is.
double evenness(const std::vector<BouncePoint>& points, double area) {
  double sum = 0;
  for (const BouncePoint& a : points) {
    float nearest = infinity;
    for (const BouncePoint& b : points)
      if (&a != &b && glm::dot(a.normal, b.normal) > 0.5f)
        nearest = std::min(nearest, glm::length(a.position - b.position));
    sum += nearest;
  }
  const double lattice = std::sqrt(2 * area / (std::sqrt(3.0) * static_cast<double>(points.size())));
  return sum / static_cast<double>(points.size()) / lattice;
}

TEST(SurfacePoints, ShareTheAreaAndLieOnTheSurface) {
  const Scene scene = box_scene();
  for (const uint32_t count : {1u, 7u, 1000u}) {
    LightPointSettings settings;
    settings.count = count;
    const auto points = spread_surface_points(scene, settings);
    ASSERT_EQ(points.size(), count);
    double area = 0;
    for (const BouncePoint& point : points) {
      area += point.area;
      const Vec3 from_centre = glm::abs(point.position - Vec3(1));
      EXPECT_NEAR(max_component(from_centre), 1, 1e-5f);
      EXPECT_NEAR(glm::length(point.normal), 1, 1e-5f);
      EXPECT_EQ(point.albedo, Vec3(0.5f));
    }
    EXPECT_NEAR(area, 24, 24e-5);
  }
}

TEST(SurfacePoints, RepulsionMakesThemEvener) {
  const Scene scene = box_scene();
  LightPointSettings settings;
  settings.count = 1500;
  settings.repulsion_steps = 0;
  const double before = evenness(spread_surface_points(scene, settings), 24);
  settings.repulsion_steps = 4;
  const double few = evenness(spread_surface_points(scene, settings), 24);
  settings.repulsion_steps = 40;
  const double many = evenness(spread_surface_points(scene, settings), 24);
  EXPECT_LT(before, 0.62);
  EXPECT_GT(few, before + 0.1);
  EXPECT_GT(many, 0.78);
}

/// ∫ over the box's faces of cos(3x) cos(2y) cos(2.5z), in closed form.
double wave(double x, double y, double z) { return std::cos(3 * x) * std::cos(2 * y) * std::cos(2.5 * z); }
double wave_over_box() {
  const double x = std::sin(6.0) / 3, y = std::sin(4.0) / 2, z = std::sin(5.0) / 2.5;
  return (1 + std::cos(6.0)) * y * z + x * (1 + std::cos(4.0)) * z + x * y * (1 + std::cos(5.0));
}

TEST(SurfacePoints, SumsOverMovedPointsAreMoreExactThanOverDrawnOnes) {
  const Scene scene = box_scene();
  LightPointSettings settings;
  settings.count = 2000;
  const auto rms_error = [&](int steps) {
    settings.repulsion_steps = steps;
    double sum = 0;
    constexpr int runs = 20;
    for (int run = 0; run < runs; ++run) {
      settings.seed = static_cast<uint64_t>(run);
      double estimate = 0;
      for (const BouncePoint& p : spread_surface_points(scene, settings))
        estimate += p.area * wave(p.position.x, p.position.y, p.position.z);
      sum += square(estimate - wave_over_box());
    }
    return std::sqrt(sum / runs);
  };
  const double drawn = rms_error(0);
  EXPECT_LT(rms_error(4), 0.5 * drawn);
  EXPECT_LT(rms_error(16), 0.5 * drawn) << "more steps must not make it worse";
}

TEST(SurfacePoints, DoNotCrowdAtBorders) {
  const Scene scene = floor_scene(2);
  LightPointSettings settings;
  settings.count = 2000;
  settings.repulsion_steps = 30;
  const float spacing = 2 / std::sqrt(2000.0f);
  int near_border = 0;
  for (const BouncePoint& point : spread_surface_points(scene, settings)) {
    const float inset = 1 - std::max(std::abs(point.position.x), std::abs(point.position.z));
    EXPECT_GT(inset, 1e-4f);
    near_border += inset < 0.25f * spacing;
  }
  // A strip of a quarter of the spacing holds 1/4 · 4 · 2/spacing points where they are even.
  EXPECT_LT(near_border, 2 / spacing);
}

TEST(SurfacePoints, BothSidesOfAThinWallDoNotSeeEachOther) {
  Scene wall;
  wall.materials.push_back(diffuse_material(Vec3(0.5f)));
  add_patch(wall, {-1, 0, 1}, {2, 0, 0}, {0, 0, -2});
  add_patch(wall, {-1, -1e-3f, -1}, {2, 0, 0}, {0, 0, 2});
  LightPointSettings settings;
  wall.materials.push_back(diffuse_material(Vec3(0.1f)));
  wall.triangle_material[2] = wall.triangle_material[3] = 1;
  settings.count = 1000;
  settings.repulsion_steps = 20;
  const std::vector<BouncePoint> both = spread_surface_points(wall, settings);
  const double together = evenness(both, 8);
  double above = 0;
  for (const BouncePoint& point : both) {
    const bool front = point.normal.y > 0;
    EXPECT_NEAR(point.albedo.x, front ? 0.5f : 0.1f, 1e-6f) << "a cell holds no part of the other side";
    if (front) above += point.area;
  }
  EXPECT_NEAR(above, 4, 0.02);
  settings.count = 500;
  const double alone = evenness(spread_surface_points(floor_scene(2), settings), 4);
  EXPECT_NEAR(together, alone, 0.03);
}

TEST(SurfacePoints, HolesReturnNothing) {
  // The left half of the floor is a hole: an alpha of 0 in its half of a two-texel picture.
  for (const AlphaMode mode : {AlphaMode::opaque, AlphaMode::mask, AlphaMode::blend}) {
    Scene scene = floor_scene(2);
    ImageRgba8 picture;
    picture.width = 2, picture.height = 1;
    picture.bytes = {255, 255, 255, 0, 255, 255, 255, 255};
    scene.images.push_back(picture);
    scene.textures.emplace_back();
    scene.textures[0].nearest = true;
    scene.materials[0].base_color_texture.texture = 0;
    scene.materials[0].alpha_mode = mode;
    for (const int steps : {0, 4}) {
      LightPointSettings settings;
      settings.count = 1000;
      settings.repulsion_steps = steps;
      double returned = 0;
      for (const BouncePoint& point : spread_surface_points(scene, settings))
        returned += point.area * point.albedo.x;
      EXPECT_NEAR(returned, mode == AlphaMode::opaque ? 2 : 1, 0.05)
          << static_cast<int>(mode) << " " << steps;
    }
  }
}

TEST(SurfacePoints, BlackSurfacesGetNone) {
  Scene scene = box_scene();
  scene.materials.push_back(diffuse_material(Vec3(0)));
  for (size_t i = 0; i < 6; ++i) scene.triangle_material[i] = 1;
  LightPointSettings settings;
  settings.count = 3000;
  double area = 0;
  for (const BouncePoint& point : spread_surface_points(scene, settings)) {
    EXPECT_GE(point.surface.triangle, 6u);
    area += point.area;
  }
  EXPECT_NEAR(area, 12, 12e-5);
}

TEST(SurfacePoints, EachFaceKeepsItsShare) {
  const Scene scene = box_scene();
  LightPointSettings settings;
  settings.count = 6000;
  std::array<int, 6> on_face{};
  for (const BouncePoint& point : spread_surface_points(scene, settings))
    ++on_face[point.surface.triangle / 2];
  for (const int count : on_face) EXPECT_NEAR(count, 1000, 60);
}

TEST(SurfacePoints, NoneWhereNothingReflects) {
  Scene scene = box_scene();
  scene.materials[0].unlit = true;
  EXPECT_TRUE(spread_surface_points(scene, {}).empty());
  EXPECT_TRUE(spread_surface_points(Scene{}, {}).empty());
}

TEST(SurfacePoints, SameBitsForAnyNumberOfThreads) {
  const Scene scene = box_scene();
  LightPointSettings settings;
  settings.count = 2000;
  std::vector<Vec3> first;
  for (const int threads : {1, 2, 5}) {
    set_thread_count(threads);
    std::vector<Vec3> positions;
    for (const BouncePoint& point : spread_surface_points(scene, settings))
      positions.push_back(point.position);
    if (first.empty()) first = positions;
    EXPECT_EQ(positions, first);
  }
  set_thread_count(0);
}

std::vector<uint32_t> all_triangles(const Scene& scene) {
  std::vector<uint32_t> all(scene.triangles.size());
  std::iota(all.begin(), all.end(), 0u);
  return all;
}

TEST(SurfaceWalk, GoesRoundTheBoxAndComesBack) {
  // Eight units along a girdle of the 2 × 2 × 2 box lead back to the start.
  const Scene scene = box_scene();
  const TriangleNeighbours neighbours(scene, all_triangles(scene));
  const SurfacePoint start{2, {0.25f, 0.5f}};  // on the top, y = 2
  const Vec3 from = surface_position(scene, start);
  const SurfacePoint end = walk_surface(scene, neighbours, start, {0, 0, 8});
  EXPECT_NEAR(glm::length(surface_position(scene, end) - from), 0, 1e-4f);
  const SurfacePoint below = walk_surface(scene, neighbours, start, {0, 0, 4});
  EXPECT_NEAR(surface_position(scene, below).y, 0, 1e-5f);
}

TEST(SurfaceWalk, StopsAtABorder) {
  const Scene scene = floor_scene(2);
  const TriangleNeighbours neighbours(scene, all_triangles(scene));
  const SurfacePoint end = walk_surface(scene, neighbours, {0, {0.3f, 0.3f}}, {100, 0, 0});
  const float x = surface_position(scene, end).x;
  EXPECT_LT(x, 1 - 1e-3f) << "a light in the corner itself sees what lies behind it";
  EXPECT_GT(x, 0.9f);
}

TEST(SurfaceWalk, KnowsWhereTheSurfaceFolds) {
  const Scene box = box_scene();
  const TriangleNeighbours of_box(box, all_triangles(box));
  int folds = 0;
  for (uint32_t i = 0; i < box.triangles.size(); ++i)
    for (int edge = 0; edge < 3; ++edge) {
      EXPECT_NE(of_box.across(i, edge), TriangleNeighbours::none);
      folds += of_box.folds(i, edge);
    }
  EXPECT_EQ(folds, 2 * 12) << "the box's twelve edges from both sides; diagonals are flat";
  const Scene sheet = floor_scene(2);
  const TriangleNeighbours of_sheet(sheet, all_triangles(sheet));
  EXPECT_EQ(of_sheet.folds(0, 0) + of_sheet.folds(0, 1) + of_sheet.folds(0, 2), 2);
}

TEST(BounceLights, RadianceIsAlbedoTimesIrradianceOverPi) {
  BouncePoint point;
  point.position = {1, 2, 3};
  point.area = 0.25f;
  point.normal = {0, 1, 0};
  point.albedo = {0.5f, 0.25f, 0.1f};
  const auto lights = bounce_lights({point}, {Vec3(2), Vec3(4)});
  ASSERT_EQ(lights.size(), 2u);
  EXPECT_NEAR(lights[0].radiance.x, 0.5f * 2 / pi, 1e-6f);
  EXPECT_NEAR(lights[1].radiance.y, 0.25f * 4 / pi, 1e-6f);
  EXPECT_EQ(lights[0].normal, Vec3(0, 1, 0));
  EXPECT_EQ(lights[1].normal, Vec3(0, -1, 0));
  EXPECT_EQ(lights[1].source, 1u);
}

}  // namespace
}  // namespace halflight
