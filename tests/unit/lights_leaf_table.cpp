#include <gtest/gtest.h>

#include "lights/cut_importance.h"
#include "lights/leaf_table.h"
#include "support/random_lights.h"
#include "support/statistics.h"

namespace halflight {
namespace {

struct Fixture {
  LightTree tree;
  Cut cut;
  CutDistribution distribution;
  LeafTable table;

  explicit Fixture(std::vector<VirtualLight> lights) : tree(build_light_tree(std::move(lights))) {
    cut = illumination_cut(tree, {});
    illumination_importance(cut, distribution.importance(cut));
    const bool drawable = distribution.build(cut, {}, 0);
    table.build(cut, distribution, static_cast<uint32_t>(tree.lights.size()), drawable);
  }
};

TEST(LeafTable, HasTheProbabilitiesOfTheCut) {
  const Fixture f(mixed_lights(3000, 10, 4));
  ASSERT_TRUE(f.table.drawable());
  double sum = 0;
  for (uint32_t k = 0; k < f.cut.size; ++k) {
    for (uint32_t i = f.cut.begin[k]; i < f.cut.end[k]; ++i) {
      const double p = f.table.probability(i), expected = f.distribution.probability(f.cut, k, i);
      ASSERT_NEAR(p, expected, 0x1p-40 + 1e-8 * expected);
      if (leaf_power(f.tree.lights[i]) > 0) {
        ASSERT_NEAR(p * f.table.weight(i), 1, 1e-6);
      }
      sum += p;
    }
  }
  EXPECT_NEAR(sum, 1, 1e-12);
}

TEST(LeafTable, DrawsFollowItStratified) {
  const Fixture f(mixed_lights(300, 10, 5));
  RandomStream random(1, 2, 3);
  constexpr uint32_t rounds = 2000;
  std::vector<LightSample> draws(97);
  std::vector<double> observed(f.tree.lights.size()), expected(f.tree.lights.size());
  for (uint32_t round = 0; round < rounds; ++round) {
    f.table.draw(random, draws);
    double before = 0;
    for (uint32_t i = 0, j = 0; i < f.tree.lights.size(); ++i) {
      uint32_t count = 0;
      for (; j < draws.size() && draws[j].light == i; ++j) ++count;
      // One draw a stratum: the draws up to leaf i differ from their expected number by less than one.
      before += count - 97 * f.table.probability(i);
      ASSERT_LT(std::abs(before), 1 + 1e-9);
      observed[i] += count;
    }
    for (const LightSample& draw : draws) ASSERT_EQ(draw.weight, f.table.weight(draw.light));
  }
  for (uint32_t i = 0; i < expected.size(); ++i) expected[i] = 97.0 * rounds * f.table.probability(i);
  EXPECT_GT(chi_square_p(observed, expected), 1e-3);
}

TEST(LeafTable, DarknessCannotBeDrawn) {
  std::vector<VirtualLight> lights = wall_lights(100, 1, 1);
  for (VirtualLight& light : lights) light.radiance = Vec3(0);
  EXPECT_FALSE(Fixture(lights).table.drawable());
  EXPECT_FALSE(Fixture({}).table.drawable());
}

TEST(EqualRadianceCut, KnowsPlacesAndNotTheirLight) {
  std::vector<VirtualLight> lights = mixed_lights(2000, 10, 6);
  const LightTree tree = build_light_tree(lights);
  const Cut lit = illumination_cut(tree, {});
  const Cut blind = equal_radiance_cut(tree, lit);
  ASSERT_EQ(blind.size, lit.size);
  uint32_t punctual = 0;
  for (uint32_t k = 0; k < blind.size; ++k) {
    EXPECT_EQ(blind.radiance[k], 1);
    EXPECT_EQ(blind.power[k], blind.measure[k]);
    double measure = 0;
    for (uint32_t i = blind.begin[k]; i < blind.end[k]; ++i) measure += tree.lights[i].measure;
    for (uint32_t i = blind.begin[k]; i < blind.end[k]; ++i) {
      const double share = blind.share(i) / blind.leaf_range[k].total;
      ASSERT_NEAR(share, tree.lights[i].measure / measure, 1e-5 / (blind.end[k] - blind.begin[k]));
    }
    if (blind.kind[k] == LightKind::punctual) {
      ++punctual;
      // Half the diagonal of a room of edge 10, nearly.
      const double omega = (blind.end[k] - blind.begin[k]) * 4 * 3.14159265 / tree.lights.size();
      EXPECT_NEAR(blind.measure[k], omega * 75, 0.03 * omega * 75);
    } else {
      EXPECT_NEAR(blind.measure[k], measure, 1e-5 * measure);
    }
  }
  EXPECT_GT(punctual, 0u);
}

}  // namespace
}  // namespace halflight
