#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "core/parallel.h"
#include "lights/light_tree.h"
#include "support/random_lights.h"

namespace halflight {
namespace {

/// Everything a tree must satisfy whatever the lights.
void expect_well_formed(const LightTree& tree, const std::vector<VirtualLight>& lights) {
  ASSERT_EQ(tree.lights.size(), lights.size());
  std::vector<uint32_t> seen = tree.original;
  std::sort(seen.begin(), seen.end());
  for (uint32_t i = 0; i < seen.size(); ++i) ASSERT_EQ(seen[i], i);
  for (size_t i = 0; i < lights.size(); ++i)
    EXPECT_EQ(tree.lights[i].position, lights[tree.original[i]].position);

  uint32_t covered = 0;
  for (int kind = 0; kind < light_kind_count; ++kind) {
    if (tree.roots[kind] < 0) continue;
    covered += tree.nodes[tree.roots[kind]].count();
    for (uint32_t i = tree.nodes[tree.roots[kind]].begin; i < tree.nodes[tree.roots[kind]].end; ++i)
      ASSERT_EQ(static_cast<int>(tree.lights[i].kind), kind);
  }
  EXPECT_EQ(covered, lights.size());

  std::vector<int> parents(tree.nodes.size(), 0);
  for (const int32_t root : tree.roots)
    if (root >= 0) ++parents[root];
  for (size_t i = 0; i < tree.nodes.size(); ++i) {
    const LightNode& node = tree.nodes[i];
    ASSERT_LT(node.begin, node.end);
    if (node.left < 0) {
      ASSERT_EQ(node.count(), 1u);
      continue;
    }
    const LightNode &a = tree.nodes[node.left], &b = tree.nodes[node.left + 1];
    ASSERT_GT(static_cast<size_t>(node.left), i);
    ++parents[node.left], ++parents[node.left + 1];
    ASSERT_EQ(a.begin, node.begin);
    ASSERT_EQ(a.end, b.begin);
    ASSERT_EQ(b.end, node.end);
  }
  for (const int count : parents) ASSERT_EQ(count, 1);
}

/// No member lies further from the centre than the node says, along its normal or any other way.
void expect_extents(const LightTree& tree, const LightNode& node) {
  const float slack = 1e-5f * (glm::length(node.high - node.low) + glm::length(node.centre));
  const float length = glm::length(node.normal);
  const Vec3 normal = length > 0 ? node.normal / length : Vec3(1, 0, 0);
  for (const Vec3 direction :
       {normal, Vec3(0, 1, 0), glm::normalize(Vec3(1, -2, 0.5f)), basis_around(normal).tangent}) {
    float extent = 0;
    for (uint32_t i = node.begin; i < node.end; ++i)
      extent = std::max(extent, std::abs(glm::dot(direction, tree.lights[i].position - node.centre)));
    ASSERT_LE(extent, node.extent_along(direction) + slack);
    if (direction == normal) {
      ASSERT_LE(extent, node.thickness + slack);
    }
  }
}

/// Aggregates of a node by summing over its leaves.
void expect_aggregates(const LightTree& tree) {
  for (const LightNode& node : tree.nodes) {
    double measure = 0, power = 0, mean_square = 0;
    Vec3d centre(0), normal(0);
    for (uint32_t i = node.begin; i < node.end; ++i) {
      const VirtualLight& light = tree.lights[i];
      const double l = luminance(light.radiance);
      measure += light.measure, power += l * light.measure, mean_square += l * l * light.measure;
      centre += Vec3d(light.position) * static_cast<double>(light.measure);
      normal += Vec3d(light.normal) * static_cast<double>(light.measure);
      for (int axis = 0; axis < 3; ++axis) {
        ASSERT_GE(light.position[axis], node.low[axis]);
        ASSERT_LE(light.position[axis], node.high[axis]);
      }
    }
    const double mean = power / measure;
    const double variance = std::max(0.0, mean_square / measure - mean * mean);
    ASSERT_NEAR(node.measure, measure, 1e-4 * measure);
    ASSERT_NEAR(node.power, power, 1e-5 * power);
    ASSERT_NEAR(node.error, node.count() * variance,
                1e-4 * node.count() * (variance + 1e-6 * mean_square / measure));
    const Vec3d n = normal / measure;
    ASSERT_LT(glm::length(Vec3d(node.normal) - n), 1e-4);
    const Vec3d c = node.kind == LightKind::environment ? glm::normalize(centre) : centre / measure;
    const double size = glm::length(Vec3d(node.high - node.low)) + 1e-3;
    if (glm::length(centre) / measure > 1e-3) {
      ASSERT_LT(glm::length(Vec3d(node.centre) - c), 1e-2 * size);
    }
    if (node.kind != LightKind::environment) expect_extents(tree, node);
  }
}

TEST(LightTree, IsAPermutationSplitIntoFourKinds) {
  const auto lights = mixed_lights(3000, 10, 1);
  const LightTree tree = build_light_tree(lights);
  expect_well_formed(tree, lights);
  expect_aggregates(tree);
  EXPECT_LT(tree.roots[static_cast<int>(LightKind::emitter)], 0);
}

TEST(LightTree, TakesAnyCount) {
  EXPECT_TRUE(build_light_tree({}).nodes.empty());
  for (const uint32_t count : {1u, 2u, 3u, 7u, 17u, 100u}) {
    const auto lights = wall_lights(count, 1, count);
    expect_well_formed(build_light_tree(lights), lights);
  }
}

TEST(LightTree, IsTheSameForAnyNumberOfThreads) {
  const auto lights = mixed_lights(40000, 10, 2);
  set_thread_count(1);
  const LightTree one = build_light_tree(lights);
  for (const int threads : {2, 5}) {
    set_thread_count(threads);
    const LightTree many = build_light_tree(lights);
    ASSERT_EQ(one.original, many.original);
    for (size_t i = 0; i < one.nodes.size(); ++i) {
      ASSERT_EQ(one.nodes[i].left, many.nodes[i].left);
      ASSERT_EQ(one.nodes[i].power, many.nodes[i].power);
      ASSERT_EQ(one.nodes[i].error, many.nodes[i].error);
    }
  }
  set_thread_count(0);
}

TEST(LightTree, CoincidentAndCollinearLights) {
  auto lights = wall_lights(5000, 1, 3);
  for (auto& light : lights) light.position = Vec3(1, 2, 3), light.normal = Vec3(0, 0, 1);
  expect_well_formed(build_light_tree(lights), lights);
  for (size_t i = 0; i < lights.size(); ++i)
    lights[i].position.x = std::ldexp(1.0f, -static_cast<int>(i % 120));
  expect_well_formed(build_light_tree(lights), lights);  // middle splits take one light off at a time
}

TEST(LightTree, SidesOfASheetPartBeforeItsHalves) {
  std::vector<VirtualLight> lights;
  RandomStream random(0, 0, 9);
  for (uint32_t i = 0; i < 512; ++i) {
    const Vec3 p(random.next(), random.next(), 0);
    for (const float side : {1.0f, -1.0f})
      lights.push_back({p, 1, {0, 0, side}, LightKind::surface, Vec3(1), i});
  }
  const LightTree tree = build_light_tree(lights);
  const LightNode& root = tree.nodes[tree.roots[static_cast<int>(LightKind::surface)]];
  EXPECT_NEAR(std::abs(tree.nodes[root.left].normal.z), 1, 1e-5);
  EXPECT_EQ(tree.nodes[root.left].count(), 512u);
}

// Its box is as deep as it is wide.
TEST(LightTree, ATurnedSheetIsThin) {
  const LightTree tree = build_light_tree(turned(wall_lights(6000, 10, 1)));
  expect_aggregates(tree);
  uint32_t sheets = 0;
  for (const LightNode& node : tree.nodes) {
    if (glm::length(node.normal) < 0.9999f) continue;
    const float size = glm::length(node.high - node.low);
    ASSERT_LE(node.thickness, 5e-3f * size);
    sheets += node.count() > 100 ? 1 : 0;
  }
  EXPECT_GT(sheets, 20u);
}

TEST(LightTree, RelightingEqualsRebuilding) {
  auto lights = mixed_lights(5000, 10, 4);
  LightTree tree = build_light_tree(lights);
  std::vector<Vec3> radiance;
  RandomStream random(7, 7, 7);
  for (auto& light : lights)
    radiance.push_back(light.radiance = Vec3(random.next(), random.next(), random.next()));
  relight(tree, radiance);
  const LightTree rebuilt = build_light_tree(lights);
  ASSERT_EQ(tree.original, rebuilt.original);
  for (size_t i = 0; i < tree.nodes.size(); ++i) {
    ASSERT_EQ(tree.nodes[i].power, rebuilt.nodes[i].power);
    ASSERT_EQ(tree.nodes[i].error, rebuilt.nodes[i].error);
  }
  expect_aggregates(tree);
}

TEST(LightTree, PowersBeyondTheRangeOfFloats) {
  auto lights = wall_lights(64, 1e-4f, 5, 1000);
  for (auto& light : lights) light.radiance *= 1e-30f;
  const LightTree faint = build_light_tree(lights);
  for (const LightNode& node : faint.nodes) EXPECT_GE(node.power, 0);
  EXPECT_GT(faint.nodes[faint.roots[static_cast<int>(LightKind::surface)]].error, 0);
  lights[0].radiance = Vec3(std::numeric_limits<float>::quiet_NaN());
  lights[1].radiance = Vec3(infinity), lights[2].radiance = Vec3(-1);
  for (const uint32_t i : {0u, 1u, 2u}) EXPECT_EQ(leaf_power(lights[i]), 0);
}

}  // namespace
}  // namespace halflight
