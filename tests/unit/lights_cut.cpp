#include <gtest/gtest.h>

#include "lights/light_tree.h"
#include "support/cuts.h"
#include "support/random_lights.h"

namespace halflight {
namespace {

uint32_t clusters_of(const Cut& cut, LightKind kind) {
  return static_cast<uint32_t>(std::count(cut.kind.begin(), cut.kind.begin() + cut.size, kind));
}

TEST(IlluminationCut, CoversEveryLitLeafOnceAndKeepsItsBound) {
  const LightTree tree = build_light_tree(mixed_lights(6000, 10, 1));
  CutSettings settings;
  settings.most = 100000;
  for (const float error : {0.5f, 0.05f, 0.01f}) {
    settings.relative_error = error;
    const Cut cut = illumination_cut(tree, settings);
    expect_covers_every_lit_leaf_once(tree, cut);
    for (uint32_t k = 0; k < cut.size; ++k) {
      const LightNode& root = tree.nodes[tree.roots[static_cast<int>(cut.kind[k])]];
      const double bound = error * root.mean_radiance();
      ASSERT_LE(tree.nodes[cut.node[k]].error, bound * bound * root.count() * (1 + 1e-6));
      ASSERT_GT(tree.nodes[cut.node[k]].power, 0);
    }
  }
}

TEST(IlluminationCut, RefinesNoFurtherThanItMust) {
  const LightTree tree = build_light_tree(wall_lights(6000, 10, 2));
  CutSettings settings;
  settings.relative_error = 0.2f, settings.least = 1, settings.most = 100000;
  const Cut cut = illumination_cut(tree, settings);
  const double bound = std::pow(0.2 * tree.nodes[0].mean_radiance(), 2) * tree.nodes[0].count();
  // Parents of clusters were above the bound.
  for (size_t i = 0; i < tree.nodes.size(); ++i) {
    if (tree.nodes[i].left < 0) continue;
    for (const int32_t child : {tree.nodes[i].left, tree.nodes[i].left + 1})
      if (std::find(cut.node.begin(), cut.node.begin() + cut.size, child) != cut.node.begin() + cut.size) {
        ASSERT_GT(tree.nodes[i].error, bound * (1 - 1e-6));
      }
  }
}

TEST(IlluminationCut, AbsoluteErrorIsThePapersEquation5) {
  const LightTree tree = build_light_tree(wall_lights(6000, 10, 3));
  CutSettings settings;
  settings.sigma = 0.7f, settings.least = 1, settings.most = 100000;
  const Cut cut = illumination_cut(tree, settings);
  EXPECT_GT(cut.size, 10u);
  for (uint32_t k = 0; k < cut.size; ++k) {
    double sum = 0, squares = 0;  // equal areas: |C| var(l) = Σ l² − (Σ l)²/|C|
    for (uint32_t i = cut.begin[k]; i < cut.end[k]; ++i) {
      const double l = luminance(tree.lights[i].radiance);
      sum += l, squares += l * l;
    }
    ASSERT_LE(squares - sum * sum / (cut.end[k] - cut.begin[k]), 0.49 * (1 + 1e-4));
  }
}

TEST(IlluminationCut, BoundsHoldForEachKind) {
  const LightTree tree = build_light_tree(mixed_lights(6000, 10, 4));
  CutSettings settings;
  settings.least = 100, settings.most = 150, settings.relative_error = 0.001f;
  const Cut cut = illumination_cut(tree, settings);
  for (const LightKind kind : {LightKind::environment, LightKind::surface, LightKind::punctual})
    EXPECT_EQ(clusters_of(cut, kind), 150u);
  settings.relative_error = 1e6f;
  const Cut coarse = illumination_cut(tree, settings);
  for (const LightKind kind : {LightKind::environment, LightKind::surface, LightKind::punctual})
    EXPECT_NEAR(clusters_of(coarse, kind), 100, 1);
  EXPECT_EQ(coarse.padded_size() % 16, 0u);
  for (size_t k = coarse.size; k < coarse.padded_size(); ++k) EXPECT_EQ(coarse.power[k], 0);
}

TEST(IlluminationCut, FromOneClusterToAllLeaves) {
  const LightTree tree = build_light_tree(wall_lights(500, 1, 5, 7));
  CutSettings settings;
  settings.least = settings.most = 1;
  const Cut one = illumination_cut(tree, settings);
  ASSERT_EQ(one.size, 1u);
  expect_covers_every_lit_leaf_once(tree, one);
  settings.least = settings.most = 1000000;
  const Cut all = illumination_cut(tree, settings);
  uint32_t lit = 0;
  for (const auto& light : tree.lights) lit += leaf_power(light) > 0;
  EXPECT_EQ(all.size, lit);
  EXPECT_EQ(illumination_cut(build_light_tree(wall_lights(1, 1, 6, 7)), {}).size,
            0u);  // its one light is dark
  EXPECT_EQ(illumination_cut(build_light_tree({}), {}).size, 0u);
}

TEST(IlluminationCut, ConstantLightIsCutByPlace) {
  auto lights = sky_lights(4096, 1, 7);
  for (auto& light : lights) light.radiance = Vec3(1);
  const Cut cut = illumination_cut(build_light_tree(lights), {});
  EXPECT_EQ(cut.size, 64u);
  for (uint32_t k = 0; k < cut.size; ++k) EXPECT_LT(cut.radius[k], 0.8f);
}

// A sky alike all round, and a sun of as much power in one place: the sky is what more clusters tell apart.
TEST(IlluminationCut, WideEnvironmentsAreCutFinerThanTheirRadiancesAsk) {
  auto lights = sky_lights(4096, 1, 7);
  for (auto& light : lights) light.radiance = Vec3(1);
  const uint32_t sky = static_cast<uint32_t>(lights.size());
  const Vec3 sun = glm::normalize(Vec3(1, 2, 3));
  for (uint32_t i = 0; i < 4096; ++i) {
    VirtualLight light = lights[i];
    light.position = glm::normalize(sun + 0.01f * light.position);
    lights.push_back(light);
  }
  const LightTree tree = build_light_tree(lights);
  CutSettings settings;
  settings.least_environment = 512;
  const Cut cut = illumination_cut(tree, settings);
  expect_covers_every_lit_leaf_once(tree, cut);
  EXPECT_EQ(cut.size, 512u);
  uint32_t in_the_sun = 0;
  for (uint32_t k = 0; k < cut.size; ++k) {
    EXPECT_LT(cut.radius[k], 0.25f);
    in_the_sun += cut.radius[k] < 0.02f && tree.original[cut.begin[k]] >= sky;
  }
  EXPECT_GE(in_the_sun, 1u);
  EXPECT_LE(in_the_sun, 64u) << "no more than the least of any kind";
  settings.most = 100;
  EXPECT_EQ(illumination_cut(tree, settings).size, 100u);
  // Fewer than eight leaves do not tell how far a cluster extends.
  settings.most = settings.least_environment = 1u << 20;
  const Cut finest = illumination_cut(tree, settings);
  EXPECT_LT(finest.size, lights.size() / 2);
}

TEST(IlluminationCut, IsTheSameInAnyUnitOfLengthAndLight) {
  const auto lights = mixed_lights(3000, 10, 8);
  const Cut cut = illumination_cut(build_light_tree(lights), {});
  for (const int exponent : {-20, 20}) {
    const float scale = std::ldexp(1.0f, exponent);
    auto scaled = lights;
    for (auto& light : scaled) {
      light.radiance *= scale;
      if (light.kind != LightKind::environment) light.position *= scale;
      if (light.kind == LightKind::surface) light.measure *= scale * scale;
    }
    const Cut other = illumination_cut(build_light_tree(scaled), {});
    EXPECT_EQ(cut.node, other.node);
    EXPECT_EQ(*cut.leaves, *other.leaves);
  }
}

}  // namespace
}  // namespace halflight
