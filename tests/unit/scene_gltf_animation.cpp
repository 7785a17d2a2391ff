// Animations, skins and morph targets at a moment.
#include <gtest/gtest.h>

#include <numbers>

#include "scene/gltf_animation.h"
#include "support/gltf_fixture.h"

namespace halflight {

namespace {

LoadOutcome load_at(const GltfFixture& gltf, double seconds) {
  LoadOptions options;
  options.at_seconds = seconds;
  return load_outcome(gltf, options);
}

Vec3 first_position(const LoadOutcome& outcome) {
  EXPECT_EQ(outcome.exit, ExitCode::ok) << outcome.message;
  return outcome.scene.vertices.at(outcome.scene.triangles.at(0).x).position;
}

GltfFixture animated_triangle(const char* path, const char* type, const std::vector<float>& times,
                              const std::vector<float>& values, const char* interpolation) {
  GltfFixture gltf = triangle_fixture();
  const size_t input = gltf.add_accessor("SCALAR", times), output = gltf.add_accessor(type, values);
  gltf.json["animations"] = {
      {{"samplers", {{{"input", input}, {"output", output}, {"interpolation", interpolation}}}},
       {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", path}}}}}}}};
  return gltf;
}

TEST(GltfKeys, LinearIsALineAndStaysAtItsEnds) {
  const GltfKeys keys{{1, 3}, {10, 20, 30, 40}, 2, GltfInterpolation::linear, false};
  EXPECT_EQ(evaluate(keys, 0), (std::vector<double>{10, 20}));
  EXPECT_EQ(evaluate(keys, 1), (std::vector<double>{10, 20}));
  EXPECT_EQ(evaluate(keys, 1.5), (std::vector<double>{15, 25}));
  EXPECT_EQ(evaluate(keys, 3), (std::vector<double>{30, 40}));
  EXPECT_EQ(evaluate(keys, 1e9), (std::vector<double>{30, 40}));
  EXPECT_EQ(evaluate(keys, std::nan("")), (std::vector<double>{10, 20}));
}

TEST(GltfKeys, StepHoldsUntilTheNextKey) {
  const GltfKeys keys{{0, 1, 2}, {5, 6, 7}, 1, GltfInterpolation::step, false};
  EXPECT_EQ(evaluate(keys, 0.999)[0], 5);
  EXPECT_EQ(evaluate(keys, 1)[0], 6);
  EXPECT_EQ(evaluate(keys, 1.5)[0], 6);
  EXPECT_EQ(evaluate(keys, 2)[0], 7);
}

/// A cubic Hermite spline reproduces any cubic, given its values and slopes.
TEST(GltfKeys, CubicSplineReproducesACubic) {
  const auto p = [](double t) { return 2 - t + 3 * t * t - 0.5 * t * t * t; };
  const auto slope = [](double t) { return static_cast<float>(-1 + 6 * t - 1.5 * t * t); };
  GltfKeys keys;
  keys.times = {0.5f, 2, 5};
  keys.width = 1;
  keys.interpolation = GltfInterpolation::cubic_spline;
  for (const float t : keys.times)
    keys.values.insert(keys.values.end(), {slope(t), static_cast<float>(p(t)), slope(t)});
  for (double t = 0.5; t <= 5; t += 0.1) EXPECT_NEAR(evaluate(keys, t)[0], p(t), 1e-4) << t;
}

TEST(GltfKeys, RotationsGoTheShortWayAtConstantSpeed) {
  const auto about_z = [](double degrees) {
    const double half = degrees * std::numbers::pi / 360;
    return std::array<float, 4>{0, 0, static_cast<float>(std::sin(half)), static_cast<float>(std::cos(half))};
  };
  const auto from = about_z(10);
  auto to = about_z(100);
  for (float& x : to) x = -x;  // the same rotation, on the far side
  GltfKeys keys{{0, 1},
                {from[0], from[1], from[2], from[3], to[0], to[1], to[2], to[3]},
                4,
                GltfInterpolation::linear,
                true};
  for (double t = 0; t <= 1; t += 0.125) {
    const auto q = evaluate(keys, t);
    const double angle = 2 * std::atan2(std::abs(q[2]), std::abs(q[3])) * 180 / std::numbers::pi;
    EXPECT_NEAR(angle, 10 + 90 * t, 1e-3) << t;
  }
}

TEST(GltfAnimation, MovesTheNode) {
  const GltfFixture gltf = animated_triangle("translation", "VEC3", {0, 2}, {0, 0, 0, 4, 6, 8}, "LINEAR");
  EXPECT_EQ(first_position(load_at(gltf, 0)), Vec3(0));
  EXPECT_EQ(first_position(load_at(gltf, 1)), Vec3(2, 3, 4));
  EXPECT_EQ(first_position(load_at(gltf, 9)), Vec3(4, 6, 8));
}

TEST(GltfAnimation, StartsAtItsFirstKeyRatherThanTheNodesOwnValue) {
  GltfFixture gltf = animated_triangle("translation", "VEC3", {1, 2}, {5, 5, 5, 6, 6, 6}, "STEP");
  gltf.json["nodes"][0]["translation"] = {1, 1, 1};
  EXPECT_EQ(first_position(load_at(gltf, 0)), Vec3(5));
}

TEST(GltfAnimation, TurnsByNormalizedIntegers) {
  GltfFixture gltf = triangle_fixture();
  const size_t input = gltf.add_accessor<float>("SCALAR", {0});
  const size_t output = gltf.add_accessor<int16_t>("VEC4", {0, 0, 23170, 23170}, {{"normalized", true}});
  gltf.json["animations"] = {
      {{"samplers", {{{"input", input}, {"output", output}}}},
       {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "rotation"}}}}}}}};
  const Scene scene = load_at(gltf, 0).scene;
  // A quarter turn about z takes +x to +y.
  EXPECT_NEAR(glm::length(scene.vertices[1].position - Vec3(0, 1, 0)), 0, 1e-4);
}

TEST(GltfAnimation, TheFirstOfTwoThatMoveOneThingCounts) {
  GltfFixture gltf = animated_triangle("translation", "VEC3", {0}, {1, 0, 0}, "STEP");
  const size_t other = gltf.add_accessor<float>("VEC3", {0, 9, 0});
  nlohmann::json second = gltf.json["animations"][0];
  second["samplers"][0]["output"] = other;
  gltf.json["animations"].push_back(second);
  EXPECT_EQ(first_position(load_at(gltf, 0)), Vec3(1, 0, 0));
}

TEST(GltfMorph, AddsWeightedDisplacements) {
  GltfFixture gltf = triangle_fixture();
  gltf.primitive()["attributes"]["NORMAL"] = gltf.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1});
  const size_t up = gltf.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1});
  const size_t aside = gltf.add_accessor<float>("VEC3", {1, 0, 0, 1, 0, 0, 1, 0, 0});
  const size_t tilt = gltf.add_accessor<float>("VEC3", {1, 0, 0, 1, 0, 0, 1, 0, 0});
  gltf.primitive()["targets"] = {{{"POSITION", up}}, {{"POSITION", aside}, {"NORMAL", tilt}}};
  gltf.json["meshes"][0]["weights"] = {0.5, 0.0};
  EXPECT_EQ(first_position(load_at(gltf, 0)), Vec3(0, 0, 0.5f));
  gltf.json["nodes"][0]["weights"] = {0.0, 1.0};  // the node's count, not the mesh's
  const LoadOutcome outcome = load_at(gltf, 0);
  EXPECT_EQ(first_position(outcome), Vec3(1, 0, 0));
  EXPECT_NEAR(glm::length(outcome.scene.vertices[0].normal - glm::normalize(Vec3(1, 0, 1))), 0, 1e-6);
}

TEST(GltfMorph, WeightsAreAnimated) {
  GltfFixture gltf = animated_triangle("weights", "SCALAR", {0, 1}, {0, 0, 1, 2}, "LINEAR");
  const size_t up = gltf.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1});
  const size_t aside = gltf.add_accessor<float>("VEC3", {1, 0, 0, 1, 0, 0, 1, 0, 0});
  gltf.primitive()["targets"] = {{{"POSITION", up}}, {{"POSITION", aside}}};
  EXPECT_EQ(first_position(load_at(gltf, 0.5)), Vec3(1, 0, 0.5f));
}

/// Two joints: the first stays, the second is lifted by 2; the third vertex hangs on both.
TEST(GltfSkin, BlendsJointsAndIgnoresTheMeshesNode) {
  GltfFixture gltf = triangle_fixture();
  gltf.primitive()["attributes"]["JOINTS_0"] =
      gltf.add_accessor<uint8_t>("VEC4", {0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0});
  gltf.primitive()["attributes"]["WEIGHTS_0"] =
      gltf.add_accessor<float>("VEC4", {1, 0, 0, 0, 1, 0, 0, 0, 0.25f, 0.75f, 0, 0});
  // The second joint is bound at z = 10: its inverse bind matrix takes that away.
  std::vector<float> bind(32, 0.0f);
  for (const int i : {0, 5, 10, 15, 16, 21, 26, 31}) bind[i] = 1;
  bind[16 + 14] = -10;
  const size_t matrices = gltf.add_accessor("MAT4", bind);
  gltf.json["nodes"][0]["skin"] = 0;
  gltf.json["nodes"][0]["translation"] = {100, 100, 100};
  gltf.json["nodes"].push_back({{"name", "still"}});
  gltf.json["nodes"].push_back({{"name", "lifted"}, {"translation", {0, 0, 12}}});
  gltf.json["scenes"][0]["nodes"] = {0, 1, 2};
  gltf.json["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", matrices}}};
  const Scene scene = load_at(gltf, 0).scene;
  ASSERT_EQ(scene.triangles.size(), 1u);
  const UVec3 t = scene.triangles[0];
  EXPECT_NEAR(glm::length(scene.vertices[t.x].position - Vec3(0, 0, 0)), 0, 1e-6);
  EXPECT_NEAR(glm::length(scene.vertices[t.y].position - Vec3(1, 0, 2)), 0, 1e-6);
  EXPECT_NEAR(glm::length(scene.vertices[t.z].position - Vec3(0, 1, 1.5f)), 0, 1e-6);
}

TEST(GltfSkin, MirroringJointsKeepFrontsInFront) {
  GltfFixture gltf = triangle_fixture();
  gltf.primitive()["attributes"]["NORMAL"] = gltf.add_accessor<float>("VEC3", {0, 0, 1, 0, 0, 1, 0, 0, 1});
  gltf.primitive()["attributes"]["JOINTS_0"] = gltf.add_accessor("VEC4", std::vector<uint8_t>(12));
  gltf.primitive()["attributes"]["WEIGHTS_0"] =
      gltf.add_accessor<float>("VEC4", {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  gltf.json["nodes"][0]["skin"] = 0;
  gltf.json["nodes"].push_back({{"scale", {-1, 1, 1}}});
  gltf.json["skins"] = {{{"joints", {1}}}};
  const Scene scene = load_at(gltf, 0).scene;
  ASSERT_EQ(scene.triangles.size(), 1u);
  EXPECT_GT(triangle_cross(scene, 0).z, 0);
  EXPECT_NEAR(scene.vertices[scene.triangles[0].x].normal.z, 1, 1e-6);
}

}  // namespace

}  // namespace halflight
