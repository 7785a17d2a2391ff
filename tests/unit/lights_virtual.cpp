#include <gtest/gtest.h>

#include "lights/virtual_light.h"
#include "support/simple_scenes.h"

namespace halflight {
namespace {

PunctualLight spot() {
  PunctualLight light;
  light.kind = PunctualKind::spot;
  light.position = {0, 2, 0};
  light.direction = {0, -1, 0};
  light.up = {0, 0, -1};
  light.intensity = Vec3(10);
  light.inner_cone = 0.2f;
  light.outer_cone = 0.6f;
  return light;
}

TEST(PunctualLight, SpotRampIsTheSquareBetweenTheCosines) {
  // KHR_lights_punctual: saturate((cos θ − cos outer)/(cos inner − cos outer))².
  const Scene scene;
  const PunctualLight light = spot();
  for (const float angle : {0.0f, 0.1f, 0.2f, 0.3f, 0.45f, 0.59f, 0.7f, 2.0f}) {
    const Vec3 travel(std::sin(angle), -std::cos(angle), 0);
    const double ramp = (std::cos(angle) - std::cos(0.6)) / (std::cos(0.2) - std::cos(0.6));
    const double expected = 10 * std::pow(std::clamp(ramp, 0.0, 1.0), 2);
    EXPECT_NEAR(punctual_intensity(light, scene, travel).x, expected, 1e-4) << angle;
  }
}

TEST(PunctualLight, RangeWindowEndsSmoothlyAtTheRange) {
  const Scene scene;
  PunctualLight light;
  light.position = {0, 0, 0};
  light.intensity = Vec3(1);
  light.range = 4;
  for (const float d : {0.5f, 1.0f, 2.0f, 3.9f, 4.0f, 6.0f}) {
    const double expected = std::max(1 - std::pow(d / 4, 4.0), 0.0) / (d * d);
    EXPECT_NEAR(connect_punctual(light, scene, {d, 0, 0}).irradiance.x, expected, 1e-5) << d;
  }
}

TEST(PunctualLight, DirectionalHasNoDistance) {
  const Scene scene;
  PunctualLight light;
  light.kind = PunctualKind::directional;
  light.direction = {0, -1, 0};
  light.intensity = Vec3(3);
  const LightConnection link = connect_punctual(light, scene, {1e6f, -5, 3});
  EXPECT_EQ(link.irradiance, Vec3(3));
  EXPECT_EQ(link.wi, Vec3(0, 1, 0));
  EXPECT_EQ(link.distance, infinity);
}

TEST(Projector, PictureStandsUprightOverTheConesSquare) {
  Scene scene;
  ImageRgb slide(2, 2);
  slide.at(0, 0) = {1, 0, 0}, slide.at(1, 0) = {0, 1, 0}, slide.at(0, 1) = {0, 0, 1},
              slide.at(1, 1) = {1, 1, 1};
  scene.pictures.push_back(slide);
  PunctualLight light = spot();
  light.inner_cone = 0.59f;
  light.picture = 0;
  // Seen from the light: up is −z, right is direction × up = −y × −z = +x.
  const float edge = std::tan(0.6f) * 0.5f;
  const auto towards = [&](float right, float up) {
    return glm::normalize(Vec3(right * edge, -1, -up * edge));
  };
  const auto color = [&](Vec3 travel) {
    const Vec3 value = punctual_intensity(light, scene, travel);
    return value / max_component(value);
  };
  EXPECT_EQ(color(towards(-1, 1)), Vec3(1, 0, 0));
  EXPECT_EQ(color(towards(1, 1)), Vec3(0, 1, 0));
  EXPECT_EQ(color(towards(-1, -1)), Vec3(0, 0, 1));
  EXPECT_EQ(color(towards(1, -1)), Vec3(1, 1, 1));
  EXPECT_EQ(punctual_intensity(light, scene, {0, 1, 0}), Vec3(0));
}

TEST(Connection, AreaLightsFollowTheirCosineAndTurnDarkBehind) {
  const Scene scene;
  VirtualLight light{{0, 2, 0}, 0.01f, {0, -1, 0}, LightKind::surface, Vec3(5), 0};
  const LightConnection under = connect(light, scene, {0, 0, 0}, GeometryTerm::exact);
  EXPECT_NEAR(under.irradiance.x, 5 * 0.01 / 4, 1e-7);
  EXPECT_EQ(under.wi, Vec3(0, 1, 0));
  EXPECT_FLOAT_EQ(under.distance, 2);
  const LightConnection aside = connect(light, scene, {2, 0, 0}, GeometryTerm::exact);
  EXPECT_NEAR(aside.irradiance.x, 5 * 0.01 * std::sqrt(0.5) / 8, 1e-7);
  EXPECT_EQ(connect(light, scene, {0, 3, 0}, GeometryTerm::exact).irradiance, Vec3(0));
}

TEST(Connection, BoundedGeometryNeverExceedsAHemisphere) {
  for (const float r : {1e-6f, 1e-3f, 0.1f, 1.0f, 100.0f}) {
    const float bounded = patch_solid_angle(1, 1, r * r, GeometryTerm::bounded);
    const float exact = patch_solid_angle(1, 1, r * r, GeometryTerm::exact);
    EXPECT_LE(bounded, 2 * pi * 1.00001f);
    EXPECT_LE(bounded, exact);
    if (r >= 100) {
      EXPECT_NEAR(bounded / exact, 1, 1e-4);
    }
  }
  EXPECT_EQ(patch_solid_angle(1, -0.5f, 1, GeometryTerm::bounded), 0);
}

TEST(PunctualLight, NextToItTheIrradianceStaysFinite) {
  const Scene scene;
  PunctualLight light;
  light.position = {0, 0, 0};
  light.intensity = Vec3(1e30f);
  for (const float d : {0.0f, 1e-30f, 1e-20f, 1e-10f, 1e-3f}) {
    const LightConnection link = connect_punctual(light, scene, {d, 0, 0});
    EXPECT_TRUE(is_finite(link.irradiance)) << d;
    EXPECT_TRUE(is_finite(link.wi)) << d;
  }
}

TEST(Connection, APointOnTheLightItselfStaysFinite) {
  const Scene scene;
  VirtualLight light{{1, 2, 3}, 0.5f, {0, -1, 0}, LightKind::emitter, Vec3(5), 0};
  for (const GeometryTerm term : {GeometryTerm::bounded, GeometryTerm::exact}) {
    const LightConnection link = connect(light, scene, {1, 2, 3}, term);
    EXPECT_TRUE(is_finite(link.irradiance));
    EXPECT_TRUE(is_finite(link.wi));
  }
}

}  // namespace
}  // namespace halflight
