#include <gtest/gtest.h>

#include <array>

#include "core/parallel.h"
#include "core/random.h"
#include "lights/light_points.h"
#include "lights/spherical_fibonacci.h"
#include "support/simple_scenes.h"

namespace halflight {
namespace {

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
    settings.count = 16;
    settings.seed = static_cast<uint64_t>(run);
    for (const VirtualLight& light : emitter_points(scene, settings)) area += light.measure / runs;
  }
  EXPECT_NEAR(area, expected, 0.01 * expected);
}

TEST(EmitterPoints, EachTriangleHasAPointAsLongAsThereAreEnough) {
  Scene scene = floor_scene(4);
  for (int i = 0; i < 100; ++i) {
    Material lamp = diffuse_material(Vec3(0));
    lamp.emission = Vec3(std::pow(1.2f, static_cast<float>(i)));
    scene.materials.push_back(lamp);
    add_patch(scene, {0, 1 + i, 0}, {1, 0, 0}, {0, 0, 1}, static_cast<uint32_t>(i + 1));
  }
  for (const uint32_t count : {200u, 250u, 1000u, 32768u}) {
    LightPointSettings settings;
    settings.count = count;
    std::vector<double> area(scene.triangles.size());
    const auto lights = emitter_points(scene, settings);
    EXPECT_LE(lights.size(), count);
    for (const VirtualLight& light : lights) area[light.source] += light.measure;
    for (size_t i = 2; i < area.size(); ++i) EXPECT_NEAR(area[i], 0.5, 1e-4) << i;
  }
}

TEST(EmitterPoints, FollowTheEmissionsPicture) {
  // One of two alike panels is dark but for a hundredth: points go to the lit one, and no power is lost.
  Scene scene = floor_scene(4);
  ImageRgba8 picture;
  picture.width = 2, picture.height = 1;
  picture.bytes = {255, 255, 255, 255, 0, 0, 0, 255};
  scene.images.push_back(picture);
  scene.textures.emplace_back();
  scene.textures[0].nearest = true;
  for (int i = 0; i < 2; ++i) {
    Material lamp = diffuse_material(Vec3(0));
    lamp.emission = Vec3(3);
    lamp.emission_texture.texture = 0;
    lamp.emission_texture.row_u = {i == 0 ? 0.5f : 0.02f, 0, i == 0 ? 0 : 0.49f};
    scene.materials.push_back(lamp);
    add_patch(scene, {4.0f * i, 2, 0}, {1, 0, 0}, {0, 0, 1}, static_cast<uint32_t>(1 + i));
  }
  LightPointSettings settings;
  settings.count = 8000;
  double power = 0;
  size_t on_lit = 0, on_dark = 0;
  for (const VirtualLight& light : emitter_points(scene, settings)) {
    power += static_cast<double>(light.radiance.x) * light.measure;
    ++(light.position.x < 2 ? on_lit : on_dark);
  }
  EXPECT_NEAR(power, 3 + 1.5, 0.1);
  EXPECT_GT(on_lit, on_dark);
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

TEST(EnvironmentPoints, AnEvenSkyGetsEvenPointsHoweverCoarseItsMap) {
  LightPointSettings settings;
  settings.count = 8192;
  const auto lights = environment_points(constant_environment(Vec3(1), 32), settings);
  EXPECT_GT(lights.size(), 7500u);
  float largest = 0;
  for (const VirtualLight& light : lights) largest = std::max(largest, light.measure);
  EXPECT_LT(largest, 3 * 4 * pi / 8192);
  // ∫ max(ω_y, 0) dω = π, by cells much finer than the map's texels.
  double floor = 0;
  for (const VirtualLight& light : lights)
    floor += static_cast<double>(light.radiance.x) * light.measure * std::max(light.position.y, 0.0f);
  EXPECT_NEAR(floor, pi, 1e-3);
}

TEST(EnvironmentPoints, SameBitsForAnyNumberOfThreads) {
  const Environment sky = built_in_sky();
  LightPointSettings settings;
  settings.count = 3000;
  std::vector<VirtualLight> first;
  for (const int threads : {1, 4}) {
    set_thread_count(threads);
    const auto lights = environment_points(sky, settings);
    if (first.empty()) first = lights;
    ASSERT_EQ(lights.size(), first.size());
    for (size_t i = 0; i < lights.size(); ++i) {
      EXPECT_EQ(lights[i].position, first[i].position);
      EXPECT_EQ(lights[i].radiance, first[i].radiance);
      EXPECT_EQ(lights[i].measure, first[i].measure);
    }
  }
  set_thread_count(0);
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

TEST(SphericalFibonacci, SearchAlongAWayIsTheSame) {
  for (const uint32_t count : {1u, 7u, 31u, 32u, 100u, 4096u}) {
    FibonacciSearch search(count);
    for (int i = 0; i < 5000; ++i) {
      const double z = std::cos(0.00061 * i), r = std::sqrt(1 - z * z), phi = 0.0123 * i;
      const Vec3d d(r * std::cos(phi), r * std::sin(phi), z);
      EXPECT_EQ(search.nearest(d), nearest_fibonacci(d, count)) << count << " " << i;
    }
  }
}

TEST(SphericalFibonacci, PointsKeepTheDistanceTheSearchReliesOn) {
  for (const uint32_t count : {32u, 33u, 50u, 100u, 377u, 1000u, 2000u}) {
    double least = 4;
    for (uint32_t i = 0; i < count; ++i)
      for (uint32_t j = 0; j < i; ++j)
        least = std::min(least, glm::length(fibonacci_direction(i, count) - fibonacci_direction(j, count)));
    EXPECT_GT(least * std::sqrt(count), 2 * std::sqrt(2.2)) << count;
  }
}

}  // namespace
}  // namespace halflight
