// Near surfaces: where two planes meet, light samples alone have weights like 1/r², and their relative
// variance grows without bound towards the edge. Beside BRDF rays it must not (ESTIMATORS: "Continuous mode",
// corner test).
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "session.h"
#include "support/traced_scene.h"

namespace halflight {
namespace {

/// A floor at the foot of a lit wall, seen from above in a pixel so small that it is one point, `distance`
/// from the wall. The wall shines itself, or returns the light of a lamp.
Scene corner(float distance, bool wall_shines) {
  Scene scene;
  Material wall = diffuse_material(Vec3(0.8f));
  if (wall_shines) wall.emission = Vec3(1);
  scene.materials = {diffuse_material(Vec3(0.8f)), wall};
  add_patch(scene, {0, 0, -1}, {0, 0, 2}, {2, 0, 0}, 0);
  add_patch(scene, {0, 0, -1}, {0, 2, 0}, {0, 0, 2}, 1);
  if (!wall_shines) {
    PunctualLight lamp;
    lamp.position = {1.5f, 1, 0};
    lamp.intensity = Vec3(1);
    scene.lights.push_back(lamp);
  }
  scene.cameras = {look_at({distance, 1, 0}, {distance, 0, 0}, {0, 0, 1}, 1e-6f)};
  return scene;
}

/// Variance over the squared mean, times N, of the light between two surfaces in a round of N samples.
double relative_variance(float distance, bool wall_shines, const char* brdf_share) {
  constexpr int rounds = 300;
  constexpr uint32_t samples = 32;
  Messages messages;
  RenderSettings settings;
  settings.technique = "halflight", settings.target = Target::continuous, settings.backend = Backend::none;
  settings.light = wall_shines ? LightSelection::direct : LightSelection::indirect;
  settings.width = settings.height = 1;
  settings.values.set("lights.count", "1000");
  settings.values.set("halflight.brdf-share", brdf_share);
  Session session(corner(distance, wall_shines), settings, messages);
  double sum = 0, squares = 0;
  for (int i = 0; i < rounds; ++i) {
    settings.seed = static_cast<uint64_t>(i) + 1;
    session.set_settings(settings);
    session.run_pass(samples, 1, 0);
    const double value = static_cast<double>(session.film().image().pixels[0].x);
    sum += value, squares += value * value;
  }
  const double mean = sum / rounds;
  EXPECT_GT(mean, 0);
  return samples * (squares / rounds - mean * mean) / (mean * mean);
}

class CornerVariance : public testing::TestWithParam<bool> {};

TEST_P(CornerVariance, DoesNotGrowTowardsTheEdge) {
  const double far = relative_variance(0.05f, GetParam(), "0.125");
  for (const float distance : {0.01f, 0.002f, 0.0004f}) {
    const double near = relative_variance(distance, GetParam(), "0.125");
    std::printf("distance %g: relative variance x N %.3g, %.3g at 0.05\n", static_cast<double>(distance),
                near, far);
    EXPECT_LT(near, 20 * far) << "at " << distance << ", " << far << " at 0.05";
  }
}

TEST_P(CornerVariance, OfLightSamplesAloneGrows) {
  EXPECT_GT(relative_variance(0.0004f, GetParam(), "0"), 50 * relative_variance(0.05f, GetParam(), "0"));
}

INSTANTIATE_TEST_SUITE_P(Walls, CornerVariance, testing::Values(true, false),
                         [](const auto& param) { return param.param ? "emitting" : "lit"; });

}  // namespace
}  // namespace halflight
