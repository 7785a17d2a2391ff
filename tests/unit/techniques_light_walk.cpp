#include <gtest/gtest.h>

#include "support/random_lights.h"
#include "techniques/light_walk.h"

namespace halflight {
namespace {

/// L Ω cos θ of a leaf at a point, bounded geometry.
double sent(const VirtualLight& light, const WalkPoint& point) {
  Scene scene;
  scene.lights.resize(1);
  scene.lights[0].position = light.position, scene.lights[0].intensity = light.radiance;
  VirtualLight known = light;
  if (light.kind == LightKind::punctual) known.source = 0;
  const LightConnection link = connect(known, scene, point.x, GeometryTerm::bounded);
  return luminance(link.irradiance) * std::max(0.0f, glm::dot(link.wi, point.normal));
}

/// Calls visit(child's leaves, its bound, whether it is a leaf) for all children of all nodes.
template <class Visit>
void for_children(const WalkTree& tree, const WalkPoint& point, uint32_t leaf_count, const Visit& visit) {
  struct Open {
    int32_t node;
    uint32_t end;
  };
  std::vector<Open> open{{0, leaf_count}};
  while (!open.empty()) {
    const Open here = open.back();
    open.pop_back();
    const WalkNode& node = tree.nodes[here.node];
    float bound[WalkNode::width];
    bound_children(node, point, bound);
    int count = 0;
    while (count < WalkNode::width && node.guard[count] > 0) ++count;
    for (int c = 0; c < count; ++c) {
      const uint32_t end = c + 1 < count ? node.begin[c + 1] : here.end;
      visit(node.begin[c], end, bound[c], node.child[c] < 0);
      if (node.child[c] >= 0) open.push_back({node.child[c], end});
    }
  }
}

std::vector<WalkPoint> points(float size) {
  std::vector<WalkPoint> all;
  RandomStream random(7, 8, 9);
  for (int i = 0; i < 24; ++i) {
    const Vec3 inside = size * Vec3(random.next(), random.next(), random.next());
    // On the floor, among the lights themselves, and in mid-air.
    const Vec3 x = i % 2 ? inside : Vec3(inside.x, 0, inside.z);
    const Vec3 n = i % 2 ? uniform_sphere(random.next2()) : Vec3(0, 1, 0);
    all.push_back({x, n, 0.5f / pi, true, {n, 1, 0, 0}});
  }
  return all;
}

TEST(LightWalk, BoundsAreNeverFalselyZeroAndExactAtLeaves) {
  const LightTree tree = build_light_tree(mixed_lights(1500, 10, 3));
  WalkTree walk;
  walk.build(tree, 1);
  for (const WalkPoint& point : points(10)) {
    size_t zeros = 0, children = 0;
    const auto leaves = static_cast<uint32_t>(tree.lights.size());
    for_children(walk, point, leaves, [&](uint32_t begin, uint32_t end, float bound, bool leaf) {
      double sum = 0;
      for (uint32_t i = begin; i < end; ++i) sum += sent(tree.lights[i], point);
      ++children, zeros += bound == 0;
      if (leaf) {
        ASSERT_NEAR(bound, sent(tree.lights[begin], point), 2e-4 * bound + 1e-6);
      }
      // Cosines are taken at the centre's distance: nearer members may be seen a little less aslant.
      ASSERT_LE(sum, 4 * bound + 1e-5);
    });
    EXPECT_GT(zeros, children / 20) << "a bound that is never zero tells nothing";
  }
}

TEST(LightWalk, ProbabilitiesOfAllLeavesAddToOne) {
  const LightTree tree = build_light_tree(mixed_lights(1500, 10, 4));
  WalkTree walk;
  walk.build(tree, 1);
  for (const WalkPoint& point : points(10)) {
    double sum = 0;
    for (uint32_t i = 0; i < tree.lights.size(); ++i) {
      const double p = walk_probability(walk, point, 0, i, 1);
      ASSERT_EQ(p > 0, leaf_power(tree.lights[i]) > 0);
      sum += p;
    }
    EXPECT_NEAR(sum, 1, 1e-12);
  }
}

TEST(LightWalk, NumbersRunOutOfBitsWithoutHarm) {
  // Powers over 24 orders of magnitude: paths of probability 1e-20 and less, where 53 bits are long used up.
  std::vector<VirtualLight> lights = wall_lights(4000, 10, 5);
  RandomStream random(3, 2, 1);
  for (VirtualLight& light : lights) light.radiance *= std::pow(10.0f, 24 * random.next() - 24);
  const LightTree tree = build_light_tree(lights);
  WalkTree walk;
  walk.build(tree, 1);
  const WalkPoint point = points(10)[1];
  LightWalk walker;
  std::vector<LightSample> draws(64);
  double mean = 0, expected = 0;
  for (const VirtualLight& light : tree.lights) expected += leaf_power(light) > 0 ? sent(light, point) : 0.0;
  constexpr int rounds = 4000;
  for (int round = 0; round < rounds; ++round) {
    walker.start(draws);
    walker.enter(walk, 0, 64, 1, random);
    walker.finish(walk, point, random);
    for (const LightSample& draw : draws) {
      ASSERT_NEAR(draw.weight * walk_probability(walk, point, 0, draw.light, 1), 1, 1e-6);
      mean += sent(tree.lights[draw.light], point) * draw.weight / (64.0 * rounds);
    }
  }
  EXPECT_NEAR(mean, expected, 0.01 * expected);
}

}  // namespace
}  // namespace halflight
