#include "scene/environment.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <functional>

#include "core/random.h"
#include "core/warp.h"
#include "film/image_writers.h"
#include "scene/image_files.h"
#include "scene/load.h"
#include "support/temporary_folder.h"

namespace halflight {
namespace {

namespace fs = std::filesystem;

constexpr double pi_d = 3.14159265358979323846;

/// A map whose texels hold their place.
Environment placed(int width, int height) {
  ImageRgb image(width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image.at(x, y) = Vec3(x, y, 1);
  return make_environment(std::move(image), "placed", EnvironmentLayout::latlong);
}

TEST(Environment, LooksWhereItsConventionSays) {
  const Environment environment = placed(8, 4);
  const auto expect_uv = [&](Vec3 direction, float u, float v) {
    const Vec2 uv = environment_uv(environment, direction);
    EXPECT_NEAR(uv.x, u, 1e-6f) << direction.x << " " << direction.y << " " << direction.z;
    EXPECT_NEAR(uv.y, v, 1e-6f);
  };
  expect_uv({0, 0, -1}, 0.5f, 0.5f);  // the centre
  expect_uv({1, 0, 0}, 0.75f, 0.5f);  // right of it
  expect_uv({-1, 0, 0}, 0.25f, 0.5f);
  expect_uv({0, 0.70710678f, -0.70710678f}, 0.5f, 0.25f);
  EXPECT_NEAR(environment_uv(environment, {0, 1, 0}).y, 0, 1e-6f);
  EXPECT_NEAR(environment_uv(environment, {0, -1, 0}).y, 1, 1e-6f);
  EXPECT_EQ(environment_radiance(environment, glm::normalize(Vec3(0.1f, 0.1f, -1))), Vec3(4, 1, 1));
  EXPECT_EQ(environment_radiance(environment, {0, -1, 0}).y, 3);
  EXPECT_EQ(environment_radiance(Environment{}, {0, 0, 1}), Vec3(0));
}

TEST(Environment, TurnsCounterClockwiseSeenFromAbove) {
  Environment environment = placed(360, 180);
  const Vec3 before = environment_radiance(environment, glm::normalize(Vec3(0.003f, 0.2f, -1)));
  environment.rotation = pi / 2;  // what stood at −z now stands at −x
  environment.strength = 2;
  EXPECT_EQ(environment_radiance(environment, glm::normalize(Vec3(-1, 0.2f, -0.003f))), 2.0f * before);
}

TEST(Environment, DirectionAndPointAreInverses) {
  Environment environment = placed(4096, 2048);
  environment.rotation = 1.234f;
  RandomStream random(1, 2, 3);
  for (int i = 0; i < 20000; ++i) {
    // A tenth of them within 0.01 of a pole, where an arc cosine would be too coarse.
    Vec2 uv = random.next2();
    if (i % 10 == 0) uv.y = i % 20 == 0 ? uv.y * 0.01f : 1 - uv.y * 0.01f;
    const Vec3 direction = environment_direction(environment, uv);
    ASSERT_NEAR(glm::length(direction), 1, 2e-6f);
    const Vec2 back = environment_uv(environment, direction);
    // Longitude loses digits with the circle's radius.
    const float away = std::abs(back.x - uv.x), slack = 1e-6f / std::max(1e-4f, std::sin(pi * uv.y));
    ASSERT_LT(std::min(away, 1 - away), slack) << uv.x << " " << uv.y;
    ASSERT_NEAR(back.y, uv.y, 5e-7f);
    ASSERT_GE(back.x, 0);
    ASSERT_LT(back.x, 1);
  }
}

TEST(Environment, SolidAnglesAreExactAndCoverTheSphere) {
  for (const int height : {1, 2, 7, 512, 8192}) {
    Environment environment;
    environment.map = ImageRgb(1, height);
    environment.map.width = 2 * height;  // only the size is asked for
    double sum = 0;
    for (int y = 0; y < height; ++y) {
      // ∫∫ sin θ dθ dφ over the texel, by Simpson's rule on eight pieces.
      double integral = 0;
      constexpr int pieces = 8;
      for (int i = 0; i < pieces; ++i) {
        const double a = pi_d * (y + static_cast<double>(i) / pieces) / height, h = pi_d / height / pieces;
        integral += h / 6 * (std::sin(a) + 4 * std::sin(a + h / 2) + std::sin(a + h));
      }
      const double expected = integral * 2 * pi_d / (2 * height);
      ASSERT_NEAR(texel_solid_angle(environment, y), expected, (height == 1 ? 1e-5 : 1e-6) * expected) << y;
      sum += texel_solid_angle(environment, y) * 2.0 * height;
    }
    EXPECT_NEAR(sum, 4 * pi_d, 1e-5);
  }
}

TEST(Environment, BadTexelsBecomeBlackAndAreCounted) {
  ImageRgb image(4, 2, Vec3(1));
  image.at(0, 0).y = std::numeric_limits<float>::quiet_NaN();
  image.at(1, 0).x = infinity;
  image.at(2, 1).z = -1e-3f;
  image.at(3, 1).z = 3e38f;  // no radiance of this world, but a number
  const Environment environment = make_environment(std::move(image), "x");
  EXPECT_EQ(environment.bad_texels, 3u);
  EXPECT_EQ(environment.map.at(0, 0), Vec3(0));
  EXPECT_EQ(environment.map.at(1, 0), Vec3(0));
  EXPECT_EQ(environment.map.at(2, 1), Vec3(1, 1, 0));  // the other channels of a negative one stay
  EXPECT_EQ(environment.map.at(3, 1), Vec3(1, 1, 1e30f));
  EXPECT_EQ(environment.map.at(0, 1), Vec3(1));
}

TEST(Environment, LoadingWarnsOfBadTexelsWithTheirNumber) {
  const TemporaryFolder folder;
  ImageRgb image(4, 2, Vec3(1));
  image.at(0, 0) = image.at(2, 1) = Vec3(-1, 2, 3);
  const fs::path path = folder.path() / "bad.exr";
  write_exr(path, image, {});
  Messages messages;
  const Environment environment = load_environment(path, {}, messages);
  EXPECT_EQ(environment.map.width, 4);
  EXPECT_EQ(environment.name, path.string());
  ASSERT_EQ(messages.warnings.size(), 1u);
  EXPECT_NE(messages.warnings[0].find("bad.exr: 2 of its texels"), std::string::npos) << messages.warnings[0];
}

/// A smooth light of no symmetry, with something at the rim's direction +z too.
Vec3 smooth_light(Vec3 d) {
  return {1 + d.x, 1 + 0.5f * d.y + 0.4f * d.x * d.z, std::exp(2 * (d.z - 1)) + 0.3f * (1 - d.y)};
}

/// Debevec's angular map of a light: D = (sin φ cos θ, sin φ sin θ, −cos φ), φ = π r; beyond the rim a colour
/// that belongs nowhere.
ImageRgb angular_map(int size, const std::function<Vec3(Vec3)>& light) {
  ImageRgb image(size, size, Vec3(1000));
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const double u = (x + 0.5) / size * 2 - 1, v = 1 - (y + 0.5) / size * 2, r = std::hypot(u, v);
      if (r > 1) continue;
      const double phi = pi_d * r, theta = std::atan2(v, u);
      image.at(x, y) =
          light(Vec3(std::sin(phi) * std::cos(theta), std::sin(phi) * std::sin(theta), -std::cos(phi)));
    }
  return image;
}

TEST(AngularMap, HoldsTheSameLightAsItsSource) {
  const Environment environment = make_environment(angular_map(256, smooth_light), "angular");
  ASSERT_EQ(environment.map.width, 512);
  ASSERT_EQ(environment.map.height, 256);
  RandomStream random(5, 5, 5);
  for (int i = 0; i < 20000; ++i) {
    Vec3 d = uniform_sphere(random.next2());
    if (i % 5 == 0) d = glm::normalize(Vec3(0, 0, 1) + 0.02f * d);  // the rim
    const Vec3 expected = smooth_light(d), got = environment_radiance(environment, d);
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(got[c], expected[c], 0.035f) << d.x << " " << d.y << " " << d.z;
  }
}

TEST(AngularMap, SquareIsAngularUnlessTold) {
  const ImageRgb square(16, 16, Vec3(1));
  EXPECT_EQ(make_environment(square, "x").map.width, 32);
  EXPECT_EQ(make_environment(square, "x", EnvironmentLayout::latlong).map.width, 16);
  EXPECT_EQ(make_environment(ImageRgb(4000, 10, Vec3(1)), "wide").map.width, 4000);
  EXPECT_EQ(make_environment(ImageRgb(32, 16, Vec3(1)), "x", EnvironmentLayout::angular).map.height, 16);
  EXPECT_EQ(make_environment(ImageRgb(1, 1, Vec3(3)), "dot").map.at(0, 0), Vec3(3));
}

/// Real spherical harmonics of degree ≤ 2 (Ramamoorthi & Hanrahan 2001) of the light.
std::array<Vec3d, 9> harmonics(const Environment& environment) {
  std::array<Vec3d, 9> sums{};
  for (int y = 0; y < environment.map.height; ++y) {
    const double omega = texel_solid_angle(environment, y);
    for (int x = 0; x < environment.map.width; ++x) {
      const Vec3d d(environment_direction(
          environment, (Vec2(x, y) + 0.5f) / Vec2(environment.map.width, environment.map.height)));
      const double basis[] = {0.282095,
                              0.488603 * d.y,
                              0.488603 * d.z,
                              0.488603 * d.x,
                              1.092548 * d.x * d.y,
                              1.092548 * d.y * d.z,
                              0.315392 * (3 * d.z * d.z - 1),
                              1.092548 * d.x * d.z,
                              0.546274 * (d.x * d.x - d.y * d.y)};
      for (size_t i = 0; i < 9; ++i) sums[i] += Vec3d(environment.map.at(x, y)) * (omega * basis[i]);
    }
  }
  return sums;
}

/// Light of 16×8 equal pieces of the map.
std::vector<double> coarse_cells(const Environment& environment) {
  std::vector<double> cells(16 * 8);
  for (int y = 0; y < environment.map.height; ++y)
    for (int x = 0; x < environment.map.width; ++x)
      cells[static_cast<size_t>(y * 8 / environment.map.height * 16 + x * 16 / environment.map.width)] +=
          luminance(environment.map.at(x, y)) * static_cast<double>(texel_solid_angle(environment, y));
  return cells;
}

TEST(AngularMap, SharedStudioIsTheSameInBothLayouts) {
  const fs::path env = fs::path(HALFLIGHT_SHARED_DATA) / "env";
  if (!fs::exists(env)) GTEST_SKIP() << "no shared data beside the checkout";
  Messages messages;
  const Environment straight = load_environment(env / "latlong-hdr/studio_small_03_1k.hdr", {}, messages);
  const Environment round = load_environment(env / "angular/studio_small_03_angular_512.hdr", {}, messages);
  EXPECT_TRUE(messages.warnings.empty());
  const auto latlong = harmonics(straight), angular = harmonics(round);
  for (size_t i = 0; i < 9; ++i)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(angular[i][c], latlong[i][c], 0.006 * latlong[0][c]) << i << " " << c;
  const auto straight_cells = coarse_cells(straight), round_cells = coarse_cells(round);
  double difference = 0, total = 0;
  for (size_t i = 0; i < straight_cells.size(); ++i) {
    difference += std::abs(straight_cells[i] - round_cells[i]);
    total += straight_cells[i];
  }
  EXPECT_LT(difference, 0.006 * total);
}

TEST(BuiltInSky, LightsFromAboveAndIsNeutral) {
  const Environment sky = built_in_sky();
  EXPECT_EQ(sky.bad_texels, 0u);
  Vec3d up(0), down(0);
  for (int y = 0; y < sky.map.height; ++y)
    for (int x = 0; x < sky.map.width; ++x) {
      const Vec3 d = environment_direction(sky, (Vec2(x, y) + 0.5f) / Vec2(sky.map.width, sky.map.height));
      const Vec3d power = Vec3d(sky.map.at(x, y)) * static_cast<double>(texel_solid_angle(sky, y));
      (d.y > 0 ? up : down) += power * static_cast<double>(std::abs(d.y));
    }
  EXPECT_GT(up.y, 3 * down.y);
  EXPECT_NEAR(up.x / up.y, 1, 0.1);
  EXPECT_NEAR(up.z / up.y, 1.1, 0.1);
  EXPECT_GT(up.y, 1);
  EXPECT_LT(up.y, 5);
}

}  // namespace
}  // namespace halflight
