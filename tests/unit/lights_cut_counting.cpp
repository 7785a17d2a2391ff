#include <gtest/gtest.h>

#include "core/warp.h"
#include "lights/cut_counting.h"
#include "support/random_lights.h"

namespace halflight {
namespace {

/// Whether a ray meets the box, in double; `margin` widens (> 0) or narrows (< 0) it relative to its size and
/// place.
bool meets(const Cut& cut, uint32_t k, Vec3 x, Vec3 d, double margin) {
  const Vec3d low(cut.low_x[k], cut.low_y[k], cut.low_z[k]),
      high(cut.high_x[k], cut.high_y[k], cut.high_z[k]);
  if (cut.kind[k] == LightKind::environment) {
    for (int a = 0; a < 3; ++a)
      if (d[a] < low[a] - margin || d[a] > high[a] + margin) return false;
    return true;
  }
  double near_distance = 0, far_distance = 1e30;
  const double wide = margin * 20;
  for (int a = 0; a < 3; ++a) {
    const double direction = std::abs(d[a]) > 1e-15 ? d[a] : 1e-15;
    const double s = (low[a] - wide - x[a]) / direction, t = (high[a] + wide - x[a]) / direction;
    near_distance = std::max(near_distance, std::min(s, t)),
    far_distance = std::min(far_distance, std::max(s, t));
  }
  return near_distance <= far_distance;
}

struct Fixture {
  LightTree tree = build_light_tree(mixed_lights(4000, 10, 1));
  Cut cut = illumination_cut(tree, {});
};

void fill(RayBundle& rays, Vec3 axis, float exponent, uint32_t count, uint64_t seed) {
  RandomStream random(1, 2, seed);
  rays.clear();
  const Basis basis = basis_around(axis);
  for (uint32_t i = 0; i < count; ++i)
    rays.add(glm::normalize(basis.to_world(cosine_power_lobe(random.next2(), exponent))));
}

TEST(ClusterCounter, MeetsTheBoxesThatTheRaysMeet) {
  const Fixture f;
  RayBundle rays;
  ClusterCounter counter;
  RandomStream random(9, 9, 9);
  for (int bundle = 0; bundle < 60; ++bundle) {
    const Vec3 x = Vec3(1) + 8.0f * Vec3(random.next(), random.next(), random.next());
    const float exponent = bundle % 3 == 0 ? 1.0f : bundle % 3 == 1 ? 50.0f : 1e5f;
    fill(rays, uniform_sphere(random.next2()), exponent, 61, bundle);
    std::vector<float> found(f.cut.size, 0.0f);
    for (const auto& [k, hits] : counter.count(f.cut, x, {}, rays, CountRule::whole)) found[k] = hits;
    for (uint32_t k = 0; k < f.cut.size; ++k) {
      int most = 0, least = 0;
      for (uint32_t i = 0; i < rays.size; ++i) {
        const Vec3 d(rays.x[i], rays.y[i], rays.z[i]);
        most += meets(f.cut, k, x, d, 1e-5), least += meets(f.cut, k, x, d, -1e-5);
      }
      if (f.cut.kind[k] == LightKind::punctual) {
        ASSERT_EQ(found[k], 0);
        continue;
      }
      ASSERT_LE(found[k], most);
      // Boxes of a single light have no inside; flat ones vanish when narrowed.
      ASSERT_GE(found[k], least);
    }
  }
}

TEST(ClusterCounter, SharedRaysAddUpToThoseThatMeetSomething) {
  const Fixture f;
  RayBundle rays;
  ClusterCounter counter;
  for (const float exponent : {1.0f, 100.0f, 1e4f}) {
    fill(rays, glm::normalize(Vec3(1, 2, 3)), exponent, 64, 3);
    const Vec3 x(5, 5, 5);
    double sum = 0;
    std::vector<bool> met(rays.size, false);
    for (const auto& [k, hits] : counter.count(f.cut, x, {}, rays, CountRule::shared)) sum += hits;
    for (uint32_t k = 0; k < f.cut.size; ++k)
      for (uint32_t i = 0; i < rays.size; ++i)
        if (f.cut.has_extent[k] > 0 && meets(f.cut, k, x, Vec3(rays.x[i], rays.y[i], rays.z[i]), 1e-6))
          met[i] = true;
    EXPECT_NEAR(sum, std::count(met.begin(), met.end(), true), 1.01);
  }
}

TEST(ClusterCounter, PassesOverClustersThatSendNothing) {
  const Fixture f;
  RayBundle rays;
  ClusterCounter counter;
  fill(rays, {0, 1, 0}, 1, 64, 4);
  std::vector<float> arriving(f.cut.padded_size(), 0.0f);
  EXPECT_TRUE(counter.count(f.cut, Vec3(5), arriving, rays, CountRule::shared).empty());
  rays.clear();
  EXPECT_TRUE(counter.count(f.cut, Vec3(5), {}, rays, CountRule::shared).empty());
}

// All lights lie in the plane of the point: rays that leave it upwards meet none.
TEST(ClusterCounter, ThePointsOwnWallIsNotMet) {
  std::vector<VirtualLight> lights;
  RandomStream random(2, 2, 2);
  for (uint32_t i = 0; i < 1000; ++i)
    lights.push_back({{random.next(), 0, random.next()}, 1e-3f, {0, 1, 0}, LightKind::surface, Vec3(1), i});
  const std::vector<VirtualLight> turned_lights = turned(lights);
  RayBundle rays;
  ClusterCounter counter;
  for (const CountRule rule : {CountRule::whole, CountRule::shared}) {
    fill(rays, {0, 1, 0}, 1, 64, 5);
    EXPECT_TRUE(counter.count(illumination_cut(build_light_tree(lights), {}), {0.5f, 0, 0.5f}, {}, rays, rule)
                    .empty());
  }
  // Boxes of turned clusters are deep, and the printed rule counts what meets a box.
  const Cut cut = illumination_cut(build_light_tree(turned_lights), {});
  const VirtualLight& own = turned_lights[500];
  fill(rays, own.normal, 1, 64, 5);
  EXPECT_FALSE(counter.count(cut, own.position, {}, rays, CountRule::whole).empty());
  EXPECT_TRUE(counter.count(cut, own.position, {}, rays, CountRule::shared).empty());
  fill(rays, -own.normal, 1, 64, 5);
  EXPECT_FALSE(counter.count(cut, own.position + 0.1f * own.normal, {}, rays, CountRule::shared).empty())
      << "from beside its plane they do";
}

}  // namespace
}  // namespace halflight
