#include <gtest/gtest.h>

#include "lights/cut_distribution.h"
#include "support/random_lights.h"
#include "support/statistics.h"

namespace halflight {
namespace {

/// A cut with random importances and guards already in a distribution.
struct Fixture {
  LightTree tree;
  Cut cut;
  CutDistribution distribution;
  std::vector<float> guard;

  explicit Fixture(std::vector<VirtualLight> lights, const CutSettings& settings = {})
      : tree(build_light_tree(std::move(lights))), cut(illumination_cut(tree, settings)) {
    RandomStream random(11, 12, 13);
    guard.resize(cut.padded_size());
    for (size_t k = 0; k < cut.padded_size(); ++k) {
      const float u = random.next();
      distribution.importance(cut)[k] = k % 7 == 0 ? 0.0f : u * u;
      guard[k] = k < cut.size ? 0.1f + random.next() : 0.0f;
    }
  }
};

void expect_weights_are_reciprocal(const Fixture& f, bool every_lit_light) {
  double sum = 0;
  for (uint32_t k = 0; k < f.cut.size; ++k) {
    double cluster = 0;
    for (uint32_t i = f.cut.begin[k]; i < f.cut.end[k]; ++i) {
      const double p = f.distribution.probability(f.cut, k, i);
      cluster += p;
      if (every_lit_light && leaf_power(f.tree.lights[i]) > 0) {
        ASSERT_GT(p, 0);
      }
      if (p > 0) {
        ASSERT_NEAR(p * f.distribution.weight(f.cut, k, i), 1, 1e-6);
      }
    }
    ASSERT_NEAR(cluster, f.distribution.cluster_probability(k), 1e-14);
    sum += cluster;
  }
  ASSERT_NEAR(sum, 1, 1e-12);
}

TEST(CutDistribution, MixesImportanceWithTheGuard) {
  Fixture f(mixed_lights(2000, 10, 1));
  std::vector<double> q(f.distribution.importance(f.cut).begin(), f.distribution.importance(f.cut).end());
  double sum_q = 0, sum_u = 0;
  for (uint32_t k = 0; k < f.cut.size; ++k) sum_q += q[k], sum_u += f.guard[k];
  ASSERT_TRUE(f.distribution.build(f.cut, f.guard, 0.05f));
  for (uint32_t k = 0; k < f.cut.size; ++k) {
    const double expected = 0.95 * q[k] / sum_q + 0.05 * f.guard[k] / sum_u;
    ASSERT_NEAR(f.distribution.cluster_probability(k), expected,
                2e-6 * 0.05 / f.cut.size * 10 + 1e-4 * expected);
  }
  expect_weights_are_reciprocal(f, true);
}

TEST(CutDistribution, LeavesFollowTheirPower) {
  Fixture f(mixed_lights(2000, 10, 2));
  ASSERT_TRUE(f.distribution.build(f.cut, f.guard, 0.05f));
  for (uint32_t k = 0; k < f.cut.size; ++k)
    for (uint32_t i = f.cut.begin[k]; i < f.cut.end[k]; ++i)
      ASSERT_NEAR(f.distribution.probability(f.cut, k, i) / f.distribution.cluster_probability(k),
                  leaf_power(f.tree.lights[i]) / f.tree.nodes[f.cut.node[k]].power, 1e-9);
}

TEST(CutDistribution, WithoutUsableImportanceTheGuardDraws) {
  for (const float bad : {0.0f, infinity, std::numeric_limits<float>::quiet_NaN()}) {
    Fixture f(mixed_lights(1000, 10, 3));
    for (float& q : f.distribution.importance(f.cut)) q = bad;
    ASSERT_TRUE(f.distribution.build(f.cut, f.guard, 0.05f));
    double sum = 0;
    for (uint32_t k = 0; k < f.cut.size; ++k) sum += f.guard[k];
    for (uint32_t k = 0; k < f.cut.size; ++k)
      ASSERT_NEAR(f.distribution.cluster_probability(k), f.guard[k] / sum, 1e-4 * f.guard[k] / sum + 1e-7);
    for (float& q : f.distribution.importance(f.cut)) q = bad;
    EXPECT_FALSE(f.distribution.build(f.cut, {}, 0));
    for (float& u : f.guard) u = bad;
    ASSERT_TRUE(f.distribution.build(f.cut, f.guard, 0.05f));
    expect_weights_are_reciprocal(f, true);
  }
}

TEST(CutDistribution, ZerosStayWithoutAGuard) {
  Fixture f(mixed_lights(1000, 10, 4));
  ASSERT_TRUE(f.distribution.build(f.cut, {}, 0, LeafRule::uniform));
  for (uint32_t k = 0; k < f.cut.size; ++k)
    EXPECT_EQ(f.distribution.cluster_probability(k) > 0, f.distribution.importance(f.cut)[k] > 0);
  expect_weights_are_reciprocal(f, false);
}

TEST(CutDistribution, NothingLitNothingDrawn) {
  auto lights = wall_lights(100, 1, 1);
  for (auto& light : lights) light.radiance = Vec3(0);
  Fixture f(lights);
  EXPECT_FALSE(f.distribution.build(f.cut, f.guard, 0.05f));
}

TEST(CutDistribution, ExtremePowersKeepEveryLightAlive) {
  for (const auto& [faint, strong] : {std::pair{1e-30f, 1e30f}, {1e-30f, 1.0f}, {1.0f, 1e30f}}) {
    auto lights = mixed_lights(1000, 10, 5);
    for (size_t i = 0; i < lights.size(); ++i) lights[i].radiance = Vec3(i % 3 == 0 ? strong : faint);
    for (const uint32_t most : {1u, 64u, 100000u}) {
      CutSettings settings;
      settings.least = 1, settings.most = most;
      Fixture f(lights, settings);
      ASSERT_TRUE(f.distribution.build(f.cut, f.guard, 0.05f));
      expect_weights_are_reciprocal(f, true);
      std::vector<LightSample> draws(64);
      RandomStream random(1, 2, 3);
      f.distribution.draw(f.cut, random, draws);
      for (const auto& draw : draws) ASSERT_TRUE(std::isfinite(draw.weight) && draw.weight > 0);
    }
  }
}

/// χ² over clusters and over leaves of many stratified sets; each set's strata are checked too.
void expect_draws_follow(const Fixture& f, uint32_t per_set, uint32_t sets) {
  std::vector<double> clusters(f.cut.size), leaves(f.tree.lights.size()), expected_clusters(f.cut.size),
      expected_leaves(f.tree.lights.size());
  std::vector<uint32_t> cluster_of(f.tree.lights.size(), ~0u);
  const double total = static_cast<double>(per_set) * sets;
  for (uint32_t k = 0; k < f.cut.size; ++k) {
    expected_clusters[k] = f.distribution.cluster_probability(k) * total;
    for (uint32_t i = f.cut.begin[k]; i < f.cut.end[k]; ++i) {
      cluster_of[i] = k;
      expected_leaves[i] = f.distribution.probability(f.cut, k, i) * total;
    }
  }
  std::vector<LightSample> draws(per_set);
  for (uint32_t set = 0; set < sets; ++set) {
    RandomStream random(set, 5, 77);
    f.distribution.draw(f.cut, random, draws);
    for (uint32_t j = 0; j < per_set; ++j) {
      ASSERT_GE(draws[j].light, draws[j > 0 ? j - 1 : 0].light);
      const uint32_t k = cluster_of[draws[j].light];
      ASSERT_LT(k, f.cut.size);
      ASSERT_EQ(draws[j].weight, f.distribution.weight(f.cut, k, draws[j].light));
      clusters[k] += 1, leaves[draws[j].light] += 1;
    }
  }
  EXPECT_GT(chi_square_p(clusters, expected_clusters), 1e-3);
  EXPECT_GT(chi_square_p(leaves, expected_leaves), 1e-3);
}

TEST(CutDistribution, DrawsFollowTheProbabilities) {
  CutSettings settings;
  settings.least = settings.most = 40;
  for (const LeafRule rule : {LeafRule::by_power, LeafRule::uniform}) {
    Fixture f(mixed_lights(600, 10, 6), settings);
    ASSERT_TRUE(f.distribution.build(f.cut, f.guard, 0.05f, rule));
    // One draw a set is not stratified: the test's own distribution holds exactly.
    expect_draws_follow(f, 1, 400000);
    expect_draws_follow(f, 37, 4000);
  }
}

TEST(CutDistribution, StratificationLowersTheVarianceOfCounts) {
  Fixture f(mixed_lights(600, 10, 7));
  ASSERT_TRUE(f.distribution.build(f.cut, f.guard, 0.05f));
  // Counts of the first half of the leaves: between neighbours of the mean when strata run along the leaves.
  constexpr uint32_t n = 64;
  double p = 0;
  const uint32_t half = static_cast<uint32_t>(f.tree.lights.size() / 2);
  for (uint32_t k = 0; k < f.cut.size; ++k)
    for (uint32_t i = f.cut.begin[k]; i < std::min(f.cut.end[k], half); ++i)
      p += f.distribution.probability(f.cut, k, i);
  for (uint32_t set = 0; set < 1000; ++set) {
    std::vector<LightSample> draws(n);
    RandomStream random(set, 6, 78);
    f.distribution.draw(f.cut, random, draws);
    const auto count =
        std::count_if(draws.begin(), draws.end(), [&](const auto& d) { return d.light < half; });
    ASSERT_LE(std::abs(static_cast<double>(count) - n * p), 1.0);
  }
}

}  // namespace
}  // namespace halflight
