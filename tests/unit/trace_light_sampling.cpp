// Draws of light towards a point: their densities against quadrature, and what a ray that meets the same
// would get.
#include "trace/light_sampling.h"

#include <gtest/gtest.h>

#include "lights/surface_strata.h"
#include "lights/virtual_light.h"
#include "support/simple_scenes.h"
#include "support/statistics.h"

namespace halflight {
namespace {

Environment spotty_sky() {
  ImageRgb map(16, 8, Vec3(0.1f));
  RandomStream random(1, 2, 3);
  for (Vec3& texel : map.pixels) texel = Vec3(std::pow(random.next(), 6.0f));
  map.at(3, 2) = Vec3(50), map.at(9, 6) = Vec3(0);
  Environment sky = make_environment(map, "spotty", EnvironmentLayout::latlong);
  sky.rotation = 1.1f, sky.strength = 0.5f;
  return sky;
}

TEST(EnvironmentSampler, DensityOfADrawIsTheDensityThere) {
  const Environment sky = spotty_sky();
  const EnvironmentSampler sampler(sky);
  RandomStream random(4, 5, 6);
  for (int i = 0; i < 20000; ++i) {
    const IncidentSample sample = sampler.sample(random.next2());
    ASSERT_NEAR(sampler.pdf(sample.wi), sample.pdf, 2e-3 * sample.pdf);
    const Vec3 radiance = environment_radiance(sky, sample.wi);
    ASSERT_NEAR(sample.radiance_over_pdf.y * sample.pdf, radiance.y, 2e-3 * radiance.y);
    ASSERT_EQ(sampler.met(sample.wi).radiance, radiance);
  }
}

TEST(EnvironmentSampler, ManyAtOnceAreTheSameDraws) {
  const Environment sky = spotty_sky();
  const EnvironmentSampler sampler(sky);
  RandomStream random(6, 6, 6);
  std::vector<Vec2> u(37);
  for (Vec2& place : u) place = random.next2();
  std::vector<IncidentSample> many(u.size());
  sampler.sample(u, many);
  for (size_t i = 0; i < u.size(); ++i) {
    EXPECT_EQ(many[i].wi, sampler.sample(u[i]).wi);
    EXPECT_EQ(many[i].radiance_over_pdf, sampler.sample(u[i]).radiance_over_pdf);
    EXPECT_EQ(many[i].pdf, sampler.sample(u[i]).pdf);
  }
}

TEST(EnvironmentSampler, DensityIntegratesToOneAndFollowsLuminance) {
  const Environment sky = spotty_sky();
  const EnvironmentSampler sampler(sky);
  constexpr int columns = 320, rows = 160;
  double sum = 0, light = 0;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const Vec3 wi = environment_direction(sky, {(x + 0.5f) / columns, (y + 0.5f) / rows});
      const double omega = std::sin(pi * (y + 0.5) / rows) * (pi / rows) * (2 * pi / columns);
      sum += sampler.pdf(wi) * omega, light += environment_radiance(sky, wi).y * omega;
    }
  EXPECT_NEAR(sum, 1, 1e-3);
  const Vec3 sun = environment_direction(sky, {3.5f / 16, 2.5f / 8});
  EXPECT_NEAR(sampler.pdf(sun), 25 / light,
              0.03 * 25 / light);  // even in the texel's area, not its solid angle
}

TEST(EmitterSampler, DensityOfADrawIsPowerOverAreaSeenFromThere) {
  Scene scene = floor_scene(1);
  Material lamp = diffuse_material(Vec3(0));
  lamp.emission = Vec3(2);
  scene.materials.push_back(lamp);
  add_patch(scene, {0, 2, 0}, {1, 0, 0}, {0, 0, 1}, 1);  // faces down, area 1
  add_patch(scene, {2, 2, 0}, {0.5f, 0, 0}, {0, 0.2f, 0.5f}, 1);
  const EmitterSampler sampler(scene);
  EXPECT_EQ(sampler.density(0), 0);
  double whole = 0;
  for (uint32_t i = 0; i < scene.triangles.size(); ++i)
    whole += sampler.density(i) * 0.5 * glm::length(triangle_cross(scene, i));
  EXPECT_NEAR(whole, 1, 1e-6);
  RandomStream random(7, 8, 9);
  const Vec3 x(0.3f, 0, 0.1f);
  for (int i = 0; i < 1000; ++i) {
    const float choose = random.next();
    const auto sample = sampler.sample(x, choose, random.next2());
    if (!sample) continue;
    EXPECT_NEAR(sample->radiance_over_pdf.y * sample->pdf, 2, 1e-4);
  }
}

/// Mean of the estimate of Σ E cos over lights in z of its error.
void expect_punctual_sum(int lights) {
  Scene scene = floor_scene(1);
  RandomStream place(11, 12, 13);
  for (int i = 0; i < lights; ++i) {
    PunctualLight light;
    light.kind = i % 3 == 0   ? PunctualKind::directional
                 : i % 3 == 1 ? PunctualKind::point
                              : PunctualKind::spot;
    light.position = Vec3(place.next() - 0.5f, 0.2f + place.next(), place.next() - 0.5f);
    light.direction = glm::normalize(Vec3(place.next() - 0.5f, -1, 0));
    light.up = glm::normalize(glm::cross(light.direction, Vec3(1, 0, 0)));
    light.intensity = Vec3(place.next());
    scene.lights.push_back(light);
  }
  scene.lights[0].intensity = Vec3(0);
  const Vec3 x(0.1f, 0, 0.1f), n(0, 1, 0);
  double truth = 0;
  for (const PunctualLight& light : scene.lights) {
    const LightConnection link = connect_punctual(light, scene, x);
    truth += link.irradiance.y * std::max(0.0f, link.wi.y);
  }
  const PunctualSampler sampler(scene);
  RandomStream random(14, 15, 16);
  constexpr int draws = 100000;
  double mean = 0, squares = 0;
  for (int i = 0; i < draws; ++i) {
    const auto sample = sampler.sample(x, n, random);
    const double value = sample ? sample->radiance_over_pdf.y * std::max(0.0f, sample->wi.y) : 0.0;
    mean += value / draws, squares += value * value / draws;
  }
  const double error = std::sqrt(std::max(0.0, squares - mean * mean) / draws);
  EXPECT_NEAR(mean, truth, 4 * error + 1e-5 * truth) << lights;
  if (lights <= 8) {
    EXPECT_LT(error, 1e-5 * truth) << "in exact proportion: no variance";
  }
}

TEST(PunctualSampler, MeanIsTheSumOfAllLights) {
  for (const int lights : {2, 8, 9, 60}) expect_punctual_sum(lights);
}

TEST(SurfaceStrata, PointsAreUniformByAreaOverWhatReturnsLight) {
  Scene scene = floor_scene(2);
  scene.materials.push_back(diffuse_material(Vec3(0)));
  add_patch(scene, {5, 0, 0}, {3, 0, 0}, {0, 0, 3}, 1);  // black
  add_patch(scene, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, 0);
  const SurfaceStrata strata(scene);
  EXPECT_NEAR(strata.area(), 5, 1e-5);
  std::vector<double> observed(scene.triangles.size()), expected(scene.triangles.size());
  RandomStream random(17, 18, 19);
  constexpr int draws = 50000;
  for (int i = 0; i < draws; ++i) {
    const double share = random.next();
    observed[strata.at(share, random.next2()).triangle] += 1;
  }
  for (const uint32_t triangle : strata.triangles())
    expected[triangle] = draws * 0.5 * glm::length(triangle_cross(scene, triangle)) / 5;
  EXPECT_GT(chi_square_p(observed, expected), 1e-3);
}

}  // namespace
}  // namespace halflight
