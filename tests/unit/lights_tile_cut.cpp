#include "lights/tile_cut.h"

#include <gtest/gtest.h>

#include "lights/cut_distribution.h"
#include "support/cuts.h"
#include "support/random_lights.h"

namespace halflight {
namespace {

constexpr float most_reach = 0.5f;

/// The box between two points that look in all directions.
PointGroup points_at(Vec3 centre, float half_side) {
  PointGroup points;
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      Vec3 normal(0);
      normal[axis] = side;
      points.add(centre - side * half_side, normal);
    }
  return points;
}

struct Fixture {
  LightTree tree;
  Cut base;
  TileCut tile_cut;

  explicit Fixture(std::vector<VirtualLight> lights)
      : tree(build_light_tree(std::move(lights))), base(illumination_cut(tree, {})), tile_cut(tree, base) {}

  /// A member of the tree that lies somewhere.
  Vec3 near_a_light() const {
    const auto root = static_cast<size_t>(tree.roots[static_cast<int>(LightKind::surface)]);
    return tree.lights[tree.nodes[root].begin].position;
  }
};

TEST(TileCut, CoversEveryLitLeafOnceWhicheverBlockCameBefore) {
  Fixture f(mixed_lights(6000, 10, 1));
  for (const Vec3 centre : {f.near_a_light(), Vec3(1e4f), Vec3(0), f.near_a_light()})
    expect_covers_every_lit_leaf_once(f.tree, f.tile_cut.refine(points_at(centre, 0.2f), most_reach));
}

TEST(TileCut, IsTheBaseCutFarAway) {
  Fixture f(mixed_lights(6000, 10, 2));
  f.tile_cut.refine(points_at(f.near_a_light(), 0.2f), most_reach);
  ASSERT_GT(f.tile_cut.cut().size, f.base.size);
  const Cut& far = f.tile_cut.refine(points_at(Vec3(1e6f), 1), most_reach);
  EXPECT_EQ(far.size, f.base.size);
  EXPECT_EQ(far.node, f.base.node);
  EXPECT_EQ(far.power, f.base.power);
}

TEST(TileCut, SplitsUntilNothingReachesFar) {
  Fixture f(wall_lights(3000, 10, 3));
  const PointGroup points = points_at(f.near_a_light() + Vec3(0.3f), 0.05f);
  const Aabb& box = points.box();
  const Cut& cut = f.tile_cut.refine(points, most_reach);
  ASSERT_GT(cut.size, f.base.size);
  ASSERT_LT(cut.size, f.base.size + TileCut::most_new) << "there was room";
  for (uint32_t k = 0; k < cut.size; ++k) {
    const Vec3 centre(cut.centre_x[k], cut.centre_y[k], cut.centre_z[k]);
    const float distance = glm::length(glm::max(glm::max(box.low - centre, centre - box.high), Vec3(0)));
    if (cut.end[k] - cut.begin[k] > 1) {
      EXPECT_LE(cut.radius[k], most_reach * distance * (1 + 1e-5f));
    }
  }
}

TEST(TileCut, WhatLiesInThePointsOwnPlaneStaysWhole) {
  const std::vector<VirtualLight> lights = wall_lights(30000, 10, 4);
  Fixture f(turned(lights));
  const auto middle = std::find_if(lights.begin(), lights.end(), [](const VirtualLight& light) {
    return glm::length(light.position - Vec3(0, 5, 5)) < 0.5f;
  });
  const VirtualLight own = turned({*middle}).front();
  const auto parts_for = [&](std::initializer_list<std::pair<float, float>> heights_and_sides) {
    PointGroup points;
    for (const auto [height, side] : heights_and_sides)
      points.add(own.position + height * own.normal, side * own.normal);
    return f.tile_cut.refine(points, most_reach).size - f.base.size;
  };
  const uint32_t seen = parts_for({{0.2f, -1.0f}});
  ASSERT_GT(seen, 30u);
  // A few clusters hold members of two walls.
  EXPECT_LT(parts_for({{0, 1}}), seen / 5);
  EXPECT_LT(parts_for({{0, 1}, {0, -1}}), seen / 5) << "nor is anything behind it";
  EXPECT_GE(parts_for({{0, 1}, {0.2f, -1}}), seen) << "another point of the group sees them";
}

TEST(TileCut, SpendsWhatRoomThereIsOnAllThatIsNear) {
  // As large as all of the lights: every cluster touches it, and no room suffices.
  Fixture f(wall_lights(60000, 10, 4));
  const Cut& cut = f.tile_cut.refine(points_at(f.near_a_light(), 100), most_reach);
  EXPECT_EQ(cut.size, f.base.size + TileCut::most_new);
  uint32_t whole = 0, single = 0;
  for (uint32_t k = 0; k < cut.size; ++k) {
    whole += std::find(f.base.node.begin(), f.base.node.end(), cut.node[k]) != f.base.node.end() ? 1 : 0;
    single += cut.end[k] - cut.begin[k] == 1 ? 1 : 0;
  }
  EXPECT_LT(whole, f.base.size / 2) << "most clusters are split";
  EXPECT_LT(single, cut.size / 20) << "before any is split to the ground";
}

TEST(TileCut, PartsDrawTheirOwnLeavesByPower) {
  Fixture f(mixed_lights(3000, 10, 5));
  const Cut& cut = f.tile_cut.refine(points_at(f.near_a_light(), 0.2f), most_reach);
  ASSERT_GT(cut.size, f.base.size);
  CutDistribution distribution;
  for (float& importance : distribution.importance(cut)) importance = 1;
  ASSERT_TRUE(distribution.build(cut, {}, 0));
  std::vector<LightSample> draws(1 << 17);
  RandomStream random(1, 2, 3);
  distribution.draw(cut, random, draws);
  std::vector<double> drawn(f.tree.lights.size(), 0);
  for (const LightSample& draw : draws) {
    ASSERT_GE(draw.light, cut.begin[draw.cluster]);
    ASSERT_LT(draw.light, cut.end[draw.cluster]);
    ASSERT_EQ(draw.weight, distribution.weight(cut, draw.cluster, draw.light));
    ++drawn[draw.light];
  }
  for (uint32_t k = 0; k < cut.size; ++k) {
    for (uint32_t i = cut.begin[k]; i < cut.end[k]; ++i) {
      const double share = leaf_power(f.tree.lights[i]) / f.tree.nodes[cut.node[k]].power;
      const double p = distribution.probability(cut, k, i);
      ASSERT_NEAR(p, share / cut.size, 1e-6 / cut.size);
      // Strata run along the leaves: at both ends one may be missed.
      ASSERT_NEAR(drawn[i], p * static_cast<double>(draws.size()), 2);
    }
  }
}

}  // namespace
}  // namespace halflight
