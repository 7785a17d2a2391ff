// The computed environments against what their names promise, and the spheres under them.
#include <gtest/gtest.h>

#include <algorithm>

#include "core/errors.h"
#include "film/image_writers.h"
#include "scene/built_in_environments.h"
#include "scene/built_in_scenes.h"
#include "scene/built_in_spheres.h"
#include "scene/load.h"
#include "support/temporary_folder.h"

namespace halflight {
namespace {

struct Texel {
  double energy, solid_angle;
  Vec3 direction;
};

/// Luminance times solid angle of every texel.
std::vector<Texel> texels(const Environment& environment) {
  std::vector<Texel> all;
  const ImageRgb& map = environment.map;
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x) {
      const double solid_angle = texel_solid_angle(environment, y);
      const Vec2 uv = (Vec2(x, y) + 0.5f) / Vec2(map.width, map.height);
      all.push_back(
          {luminance(map.at(x, y)) * solid_angle, solid_angle, environment_direction(environment, uv)});
    }
  return all;
}

/// Share of the energy that comes from the texels of which `chosen(texel)` holds.
template <class Chosen>
double share(const Environment& environment, Chosen&& chosen) {
  double sum = 0, part = 0;
  for (const Texel& t : texels(environment)) sum += t.energy, part += chosen(t) ? t.energy : 0;
  return part / sum;
}

/// Share of the energy in the brightest `fraction` of the sphere.
double share_of_brightest(const Environment& environment, double fraction) {
  std::vector<Texel> all = texels(environment);
  std::sort(all.begin(), all.end(), [](const Texel& a, const Texel& b) {
    return a.energy * b.solid_angle > b.energy * a.solid_angle;
  });
  double sum = 0, part = 0, covered = 0;
  for (const Texel& t : all) {
    sum += t.energy;
    if (covered < 4 * static_cast<double>(pi) * fraction) part += t.energy;
    covered += t.solid_angle;
  }
  return part / sum;
}

TEST(BuiltInEnvironments, AreFiniteAndTheSameEveryTime) {
  for (const BuiltInEnvironment& built_in : built_in_environments()) {
    SCOPED_TRACE(built_in.name);
    const Environment a = built_in.make(), b = built_in.make();
    EXPECT_EQ(a.name, built_in.name);
    EXPECT_EQ(a.map.width, 2 * a.map.height);
    EXPECT_EQ(a.bad_texels, 0u);
    EXPECT_TRUE(a.map.pixels == b.map.pixels);
    double energy = 0;
    for (const Texel& t : texels(a)) energy += t.energy;
    // Mean radiance within what an exposure of a few stops takes in.
    EXPECT_GT(energy / (4 * pi), 0.05);
    EXPECT_LT(energy / (4 * pi), 5);
  }
}

TEST(BuiltInEnvironments, UniformIsUniform) {
  const Environment uniform = make_built_in_environment("uniform");
  for (const Vec3& texel : uniform.map.pixels) ASSERT_EQ(texel, Vec3(1));
  EXPECT_NEAR(share_of_brightest(uniform, 0.01), 0.01, 2e-4);
}

TEST(BuiltInEnvironments, OvercastAndSkylightShineFromAbove) {
  const auto above = [](float height) { return [height](const Texel& t) { return t.direction.y > height; }; };
  EXPECT_GT(share(make_built_in_environment("overcast"), above(0)), 0.8);
  EXPECT_GT(share(make_built_in_environment("overcast"), above(0.5f)), 0.45);  // 60° about the zenith
  EXPECT_GT(share(make_built_in_environment("skylight"), above(0.3f)), 0.6);
  EXPECT_NEAR(share(make_built_in_environment("uniform"), above(0)), 0.5, 1e-4);
  // The zenith of Moon & Spencer's sky is three times its horizon; ours has a break in the cloud there.
  const Environment overcast = make_built_in_environment("overcast");
  EXPECT_GT(luminance(environment_radiance(overcast, {0, 1, 0})),
            3 * luminance(environment_radiance(overcast, {1, 0.03f, 0})));
}

TEST(BuiltInEnvironments, ConcentrateTheirLightInTheOrderOfTheirNames) {
  const auto brightest = [](const char* name) {
    return share_of_brightest(make_built_in_environment(name), 0.01);
  };
  const double spikes = brightest("spikes"), city = brightest("city-night"), sunset = brightest("sunset"),
               studio = brightest("studio");
  EXPECT_GT(spikes, 0.85);
  EXPECT_GT(city, 0.6);
  EXPECT_GT(sunset, 0.4);
  EXPECT_LT(studio, 0.35);
  EXPECT_GT(spikes, city);
  EXPECT_LT(brightest("overcast"), 0.06);
  // Few texels: a map sampler finds them, a BRDF sampler does not.
  size_t bright = 0;
  for (const Vec3& texel : make_built_in_environment("spikes").map.pixels) bright += luminance(texel) > 100;
  EXPECT_GE(bright, 5u);
  EXPECT_LT(bright, 40u);
}

TEST(BuiltInEnvironments, OpenByNameUnlessAFileHasIt) {
  Messages messages;
  EXPECT_EQ(open_environment("studio", {}, messages).name, "studio");
  try {
    open_environment("stduio", {}, messages);
    FAIL() << "was opened";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::usage);
    EXPECT_NE(std::string(error.what()).find("studio"), std::string::npos) << error.what();
  }
  try {
    open_environment("studio.hdr", {}, messages);
    FAIL() << "was opened";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::bad_input);
  }
  const TemporaryFolder folder;
  const std::string file = (folder.path() / "uniform").string();
  write_radiance(file, ImageRgb(8, 4, Vec3(7)), {});
  EXPECT_NEAR(open_environment(file, {}, messages).map.at(0, 0).x, 7, 0.05);
}

TEST(BuiltInSpheres, OneIsASphereOfItsExponent) {
  const Scene scene = make_phong_sphere(300, make_built_in_environment("spikes"));
  EXPECT_GE(scene.triangles.size(), 10'000u);
  EXPECT_EQ(scene.environment.name, "spikes");
  EXPECT_EQ(scene.materials.at(0).exponents.x, 300);
  EXPECT_LE(max_component(scene.materials.at(0).diffuse + scene.materials.at(0).phong_specular), 1);
  for (const Vertex& v : scene.vertices) {
    ASSERT_NEAR(glm::length(v.position), 1, 1e-5);
    ASSERT_LT(glm::length(v.normal - v.position), 1e-5f);
  }
}

TEST(BuiltInSpheres, GrowSharperAndStandOnTheGround) {
  const Scene scene = make_spheres();
  std::vector<float> exponents, lows(scene.materials.size(), infinity);
  for (const Material& m : scene.materials) {
    EXPECT_LE(max_component(m.diffuse + m.phong_specular), 1);
    if (m.phong_specular != Vec3(0)) exponents.push_back(m.exponents.x);
  }
  EXPECT_EQ(exponents.size(), 8u);
  EXPECT_TRUE(std::is_sorted(exponents.begin(), exponents.end()));
  EXPECT_GE(exponents.back(), 1000 * exponents.front());
  for (uint32_t t = 0; t < scene.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k)
      lows[scene.triangle_material[t]] =
          std::min(lows[scene.triangle_material[t]], scene.vertices[scene.triangles[t][k]].position.y);
  for (const float low : lows) EXPECT_NEAR(low, 0, 1e-4);
}

}  // namespace
}  // namespace halflight
