#include <gtest/gtest.h>

#include <array>

#include "core/parallel.h"
#include "core/random.h"
#include "lights/light_points.h"
#include "lights/spherical_fibonacci.h"
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

TEST(SurfaceWalk, GoesRoundTheBoxAndComesBack) {
  // Eight units along a girdle of the 2 × 2 × 2 box lead back to the start.
  const Scene scene = box_scene();
  const TriangleNeighbours neighbours(scene);
  const SurfacePoint start{2, {0.25f, 0.5f}};  // on the top, y = 2
  const Vec3 from = surface_position(scene, start);
  const SurfacePoint end = walk_surface(scene, neighbours, start, {0, 0, 8});
  EXPECT_NEAR(glm::length(surface_position(scene, end) - from), 0, 1e-4f);
  const SurfacePoint below = walk_surface(scene, neighbours, start, {0, 0, 4});
  EXPECT_NEAR(surface_position(scene, below).y, 0, 1e-5f);
}

TEST(SurfaceWalk, StopsAtABorder) {
  const Scene scene = floor_scene(2);
  const TriangleNeighbours neighbours(scene);
  const SurfacePoint end = walk_surface(scene, neighbours, {0, {0.3f, 0.3f}}, {100, 0, 0});
  EXPECT_NEAR(surface_position(scene, end).x, 1, 1e-5f);
}

TEST(EmitterPoints, AreaAndPowerAreTheEmitters) {
  Scene scene = floor_scene(4);
  for (const float radiance : {1.0f, 1000.0f}) {
    Material lamp = diffuse_material(Vec3(0));
    lamp.emission = Vec3(radiance);
    scene.materials.push_back(lamp);
    const auto material = static_cast<uint32_t>(scene.materials.size() - 1);
    add_patch(scene, {0, radiance, 0}, {2, 0, 0}, {0, 0, 2}, material);
  }
  LightPointSettings settings;
  settings.count = 4000;
  const auto lights = emitter_points(scene, settings);
  std::array<double, 2> area{};
  std::array<int, 2> points{};
  for (const VirtualLight& light : lights) {
    const int which = light.radiance.x > 10 ? 1 : 0;
    area[which] += light.measure;
    ++points[which];
    EXPECT_NEAR(light.normal.y, -1, 1e-6f);
  }
  EXPECT_NEAR(area[0], 4, 1e-4);
  EXPECT_NEAR(area[1], 4, 1e-4);
  EXPECT_GE(points[0], 2) << "a dim lamp keeps a point a triangle";
  EXPECT_GT(points[1], 100 * points[0]);
}

TEST(EmitterPoints, FewerPointsThanTrianglesKeepThePowerOnAverage) {
  Scene scene = floor_scene(4);
  Material lamp = diffuse_material(Vec3(0));
  lamp.emission = Vec3(2);
  scene.materials.push_back(lamp);
  for (int i = 0; i < 100; ++i) add_patch(scene, {0, 1 + i, 0}, {1 + 0.05f * i, 0, 0}, {0, 0, 1}, 1);
  double expected = 0;
  for (int i = 0; i < 100; ++i) expected += 1 + 0.05 * i;
  double area = 0;
  constexpr int runs = 200;
  for (int run = 0; run < runs; ++run) {
    LightPointSettings settings;
    settings.count = 64;  // 16 points
    settings.seed = static_cast<uint64_t>(run);
    for (const VirtualLight& light : emitter_points(scene, settings)) area += light.measure / runs;
  }
  EXPECT_NEAR(area, expected, 0.01 * expected);
}

TEST(EmitterPoints, DoubleSidedOnesEmitBothWays) {
  Scene scene;
  Material lamp = diffuse_material(Vec3(0));
  lamp.emission = Vec3(2);
  lamp.double_sided = true;
  scene.materials.push_back(lamp);
  add_patch(scene, {0, 0, 0}, {1, 0, 0}, {0, 0, 1});
  double up = 0, down = 0;
  for (const VirtualLight& light : emitter_points(scene, {}))
    (light.normal.y > 0 ? up : down) += light.measure;
  EXPECT_NEAR(up, 1, 1e-5);
  EXPECT_NEAR(down, 1, 1e-5);
}

/// ∫ L dω of the map, one channel.
double integral(const Environment& environment) {
  double sum = 0;
  for (int y = 0; y < environment.map.height; ++y)
    for (int x = 0; x < environment.map.width; ++x)
      sum += static_cast<double>(environment.map.at(x, y).x) * texel_solid_angle(environment, y);
  return sum * environment.strength;
}

TEST(EnvironmentPoints, KeepTheIntegralExactlyEvenOfASun) {
  Environment sky = constant_environment(Vec3(0.5f), 256);
  sky.map.at(77, 40) = Vec3(1e6f);
  sky.strength = 1.5f;
  sky.rotation = 0.7f;
  for (const uint32_t count : {1u, 64u, 4096u}) {
    LightPointSettings settings;
    settings.count = count;
    const auto lights = environment_points(sky, settings);
    EXPECT_LE(lights.size(), count);
    double sum = 0, sphere = 0;
    for (const VirtualLight& light : lights) {
      sum += static_cast<double>(light.radiance.x) * light.measure;
      sphere += light.measure;
      EXPECT_NEAR(glm::length(light.position), 1, 1e-5f);
    }
    EXPECT_NEAR(sum, integral(sky), 1e-4 * integral(sky)) << count;
    EXPECT_NEAR(sphere, 4 * pi, 1e-3) << count;
  }
}

TEST(EnvironmentPoints, TheSunKeepsItsPlace) {
  Environment sky = constant_environment(Vec3(0.5f), 256);
  sky.map.at(77, 40) = Vec3(1e6f);
  const Vec3 sun = environment_direction(sky, {77.5f / 256, 40.5f / 128});
  LightPointSettings settings;
  settings.count = 512;
  const auto lights = environment_points(sky, settings);
  const auto brightest = std::max_element(lights.begin(), lights.end(), [](const auto& a, const auto& b) {
    return light_power(a) < light_power(b);
  });
  EXPECT_GT(glm::dot(brightest->position, sun), 0.999999f);
}

TEST(EnvironmentPoints, IndependentPointsHaveTheIntegralAsTheirMean) {
  Environment sky = constant_environment(Vec3(0.2f), 64);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x) sky.map.at(x, y) = Vec3(1 + std::sin(0.3f * x) * std::cos(0.2f * y));
  // ∫ L(ω) max(ω_y, 0): what a floor would receive.
  double expected = 0, mean = 0;
  for (int y = 0; y < 32; ++y) {
    for (int x = 0; x < 64; ++x) {
      // The exact mean of cos θ over the row's band: (cos² top − cos² low)/2 in closed form.
      const double top = std::cos(3.141592653589793 * y / 32),
                   low = std::cos(3.141592653589793 * (y + 1) / 32);
      if (top > 0)
        expected +=
            sky.map.at(x, y).x * 0.5 * (top * top - std::max(low, 0.0) * low) * 2 * 3.141592653589793 / 64;
    }
  }
  constexpr int runs = 400;
  for (int run = 0; run < runs; ++run) {
    LightPointSettings settings;
    settings.count = 64;
    settings.repulsion_steps = 0;
    settings.seed = static_cast<uint64_t>(run);
    for (const VirtualLight& light : environment_points(sky, settings))
      mean += static_cast<double>(light.radiance.x) * light.measure * std::max(light.position.y, 0.0f) / runs;
  }
  EXPECT_NEAR(mean, expected, 0.005 * expected);
}

TEST(EnvironmentPoints, BlackOrAbsentGivesNoLight) {
  EXPECT_TRUE(environment_points(Environment{}, {}).empty());
  LightPointSettings settings;
  settings.count = 100;
  for (const VirtualLight& light : environment_points(constant_environment(Vec3(0)), settings))
    EXPECT_EQ(light.radiance, Vec3(0));
  settings.repulsion_steps = 0;
  EXPECT_TRUE(environment_points(constant_environment(Vec3(0)), settings).empty());
}

TEST(SphericalFibonacci, NearestIsNearest) {
  for (const uint32_t count : {1u, 2u, 10u, 1000u, 32768u}) {
    RandomStream random(count, 0, 0);
    for (int i = 0; i < (count > 1000 ? 50 : 500); ++i) {
      const Vec2 u = random.next2();
      const double z = 1 - 2.0 * u.x, r = std::sqrt(1 - z * z), phi = 6.283185307179586 * u.y;
      const Vec3d d(r * std::cos(phi), r * std::sin(phi), z);
      double best = -2;
      for (uint32_t j = 0; j < count; ++j) best = std::max(best, glm::dot(d, fibonacci_direction(j, count)));
      const double found = glm::dot(d, fibonacci_direction(nearest_fibonacci(d, count), count));
      EXPECT_NEAR(found, best, 1e-12) << count << " points";
    }
  }
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
