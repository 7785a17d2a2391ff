// How the path tracer draws its lights, against what they are elsewhere and against their sums.
#include <gtest/gtest.h>

#include "core/random.h"
#include "lights/virtual_light.h"
#include "support/traced_rooms.h"
#include "techniques/path_lights.h"

namespace halflight {
namespace {

// The fall-offs are written twice; what they mean is one thing.
TEST(PathLights, PunctualLightsAreWhatTheyAreElsewhere) {
  Scene scene = floor_scene(4);
  ImageRgb slide(5, 3);
  RandomStream random(1, 2, 3);
  for (Vec3& pixel : slide.pixels) pixel = Vec3(random.next(), random.next(), random.next());
  scene.pictures.push_back(slide);
  std::vector<PunctualLight> lights(5);
  lights[1].kind = PunctualKind::directional;
  lights[2].range = 3;
  lights[3].kind = lights[4].kind = PunctualKind::spot;
  lights[3].inner_cone = 0.2f, lights[3].outer_cone = 0.9f;
  lights[4].picture = 0, lights[4].inner_cone = lights[4].outer_cone = 0.8f;
  for (PunctualLight& light : lights) {
    light.position = {0.3f, 2, 0.1f}, light.intensity = {1, 2, 3};
    light.direction = glm::normalize(Vec3(0.2f, -1, 0.3f));
    light.up = basis_around(light.direction).tangent;
    double lit = 0;
    for (int i = 0; i < 500; ++i) {
      const Vec3 x(4 * random.next() - 2, random.next(), 4 * random.next() - 2);
      const PathPunctual own = punctual_towards(scene, light, x);
      const LightConnection other = connect_punctual(light, scene, x);
      ASSERT_LT(glm::length(own.wi - other.wi), 1e-5f);
      if (light.kind != PunctualKind::directional) {
        ASSERT_NEAR(own.distance, other.distance, 1e-5);
      }
      for (int c = 0; c < 3; ++c) ASSERT_NEAR(own.irradiance[c], other.irradiance[c], 2e-4) << i;
      lit += own.irradiance.y > 0;
    }
    EXPECT_GT(lit, 50);
  }
}

TEST(PathLights, EnvironmentIsDrawnByItsDensity) {
  ImageRgb map(16, 8);
  RandomStream random(4, 5, 6);
  for (Vec3& pixel : map.pixels) pixel = random.next() < 0.3f ? Vec3(0) : Vec3(random.next());
  Environment environment = make_environment(map, "noise", EnvironmentLayout::latlong);
  environment.rotation = 0.7f, environment.strength = 3;
  const PathEnvironment lights(environment);

  constexpr int draws = 200000;
  std::vector<double> observed(map.pixels.size()), expected(map.pixels.size());
  double total = 0;
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const Vec3 wi = environment_direction(environment, (Vec2(x, y) + 0.5f) / Vec2(map.width, map.height));
      const double share = lights.pdf(wi) * texel_solid_angle(environment, y);
      total += share, expected[static_cast<size_t>(y) * map.width + x] = share * draws;
    }
  EXPECT_NEAR(total, 1, 1e-5);
  for (int i = 0; i < draws; ++i) {
    const PathLightSample sample = lights.sample(random);
    const Vec2 uv = environment_uv(environment, sample.wi);
    const int x = std::min(static_cast<int>(uv.x * map.width), map.width - 1),
              y = std::min(static_cast<int>(uv.y * map.height), map.height - 1);
    observed[static_cast<size_t>(y) * map.width + x] += 1;
    ASSERT_LT(glm::length(Vec3(sample.radiance) - environment_radiance(environment, sample.wi)), 1e-5f);
    ASSERT_NEAR(sample.pdf, lights.pdf(sample.wi), 1e-6 * sample.pdf);
  }
  EXPECT_GT(chi_square_p(observed, expected), 1e-3);
}

TEST(PathLights, ManyPunctualLightsHaveTheSumOfAllAsTheirMean) {
  Scene scene = floor_scene(4);
  RandomStream random(7, 8, 9);
  for (int i = 0; i < 30; ++i) {
    PunctualLight light;
    light.position = {4 * random.next() - 2, 1 + random.next(), 4 * random.next() - 2};
    light.intensity = Vec3(std::pow(10.0f, 3 * random.next() - 2));
    scene.lights.push_back(light);
  }
  const PathPunctuals lights(scene);
  const Vec3 x(0.1f, 0, 0.2f);
  double sum = 0, mean = 0, square_mean = 0;
  for (const PunctualLight& light : scene.lights) sum += punctual_towards(scene, light, x).irradiance.y;
  constexpr int draws = 100000;
  std::vector<PathPunctual> drawn;
  for (int i = 0; i < draws; ++i) {
    drawn.clear();
    lights.sample(x, random, drawn);
    ASSERT_EQ(drawn.size(), 1u);
    const double value = drawn[0].irradiance.y;
    mean += value / draws, square_mean += value * value / draws;
  }
  EXPECT_NEAR(mean, sum, 4 * std::sqrt((square_mean - mean * mean) / draws));
}

}  // namespace
}  // namespace halflight
