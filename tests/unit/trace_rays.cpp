#include <gtest/gtest.h>

#include <algorithm>

#include "core/parallel.h"
#include "core/random.h"
#include "core/warp.h"
#include "support/simple_scenes.h"
#include "trace/ray_scene.h"

namespace halflight {
namespace {

/// A floor with a smaller table 1 above it.
Scene table_scene(float scale = 1) {
  Scene scene = floor_scene(10 * scale);
  add_patch(scene, scale * Vec3(-1, 1, 1), scale * Vec3(2, 0, 0), scale * Vec3(0, 0, -2));
  return scene;
}

ShadowRay upward(float x, float z, float length = infinity) { return {x, 0.001f, z, 0, 0, 1, 0, 0, length}; }

TEST(Rays, ClosestHitIsWhereItShouldBe) {
  const Scene scene = table_scene();
  const RayScene rays(scene);
  RayCounters counters;
  RayHit hit;
  ASSERT_TRUE(rays.intersect({0.25f, 5, 0.5f}, {0, -1, 0}, 0, infinity, 0, hit, counters));
  EXPECT_FLOAT_EQ(hit.distance, 4);
  EXPECT_GE(hit.point.triangle, 2u);
  const Vec3 place = surface_position(scene, hit.point);
  EXPECT_NEAR(place.x, 0.25f, 1e-6f);
  EXPECT_NEAR(place.y, 1, 1e-6f);
  EXPECT_NEAR(place.z, 0.5f, 1e-6f);
  EXPECT_FALSE(rays.intersect({0, 5, 0}, {0, 1, 0}, 0, infinity, 0, hit, counters));
  EXPECT_EQ(counters.closest, 2u);
  EXPECT_GT(rays.memory_bytes(), 0u);
}

TEST(Rays, NoneSlipsThroughTheEdgesThatTrianglesShare) {
  // A sheet of patches; rays straight at their corners and at points of their edges, which float arithmetic
  // puts on either side of them.
  constexpr int side = 12;
  Scene scene;
  scene.materials.emplace_back();
  for (int i = 0; i < side; ++i)
    for (int j = 0; j < side; ++j)
      add_patch(scene, Vec3(0.25f * i, 0, 0.25f * j), Vec3(0.25f, 0, 0), Vec3(0, 0, 0.25f));
  const RayScene rays(scene);
  RayCounters counters;
  RandomStream random(5, 0, 0);
  for (int k = 0; k < 20000; ++k) {
    const int i = 1 + static_cast<int>(random.next() * (side - 1)),
              j = 1 + static_cast<int>(random.next() * (side - 1));
    const float along = k % 2 == 0 ? 0.0f : 0.25f * random.next();
    const Vec3 target(0.25f * i + (k % 4 == 1 ? along : 0), 0, 0.25f * j + (k % 4 == 3 ? along : 0));
    const Vec3 eye(3.0f * random.next(), 0.5f + 3 * random.next(), 3.0f * random.next());
    RayHit hit;
    ASSERT_TRUE(rays.intersect(eye, glm::normalize(target - eye), 0, infinity, 0, hit, counters)) << k;
    ShadowRay shadow{eye.x, eye.y, eye.z, 0, target.x - eye.x, target.y - eye.y, target.z - eye.z, 0, 2};
    rays.occluded({&shadow, 1}, 0, counters);
    ASSERT_TRUE(shadow.blocked()) << k;
  }
}

TEST(Rays, TinyComponentsOfDirectionsLetNothingThrough) {
  // Embree's streams lose a batch's rays over one whose direction has a component of -1e-19.
  Scene scene;
  scene.materials.emplace_back();
  for (int shell = 0; shell < 8; ++shell)
    for (int axis = 0; axis < 3; ++axis)
      for (const float side : {-1.0f, 1.0f}) {
        Vec3 n(0), u(0), v(0);
        const float size = 0.5f + 0.05f * static_cast<float>(shell);
        n[axis] = side * size, u[(axis + 1) % 3] = 2 * size, v[(axis + 2) % 3] = 2 * size;
        add_patch(scene, n - 0.5f * (u + v), u, v);
      }
  const RayScene rays(scene);
  RayCounters counters;
  RandomStream random(9, 0, 0);
  for (const float tiny : {-3e-19f, -1e-30f, -1e-40f, 3e-19f, -0.0f})
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<ShadowRay> batch;
      for (int i = 0; i < 500; ++i) {
        const Vec3 o = 0.9f * Vec3(random.next(), random.next(), random.next()) - 0.45f;
        Vec3 d = uniform_sphere(random.next2());
        if (i % 25 == 0) d[axis] = 0, d = glm::normalize(d), d[axis] = tiny;
        batch.push_back({o.x, o.y, o.z, 0, d.x, d.y, d.z, 0, infinity});
      }
      rays.occluded(batch, 0, counters);
      EXPECT_EQ(std::count_if(batch.begin(), batch.end(), [](const ShadowRay& r) { return !r.blocked(); }), 0)
          << tiny << " along axis " << axis;
    }
  EXPECT_EQ(counters.rejected, 0u);
}

TEST(Rays, BatchesOfAnySizeAgreeWithSingleRays) {
  const Scene scene = table_scene();
  const RayScene rays(scene);
  for (const size_t count : {1u, 2u, 15u, 16u, 17u, 63u, 64u, 1000u}) {
    std::vector<ShadowRay> batch;
    RandomStream random(count, 0, 0);
    for (size_t i = 0; i < count; ++i) {
      const Vec2 u = random.next2();
      batch.push_back(upward(4 * u.x - 2, 4 * u.y - 2, random.next() < 0.2f ? 0.5f : infinity));
    }
    std::vector<ShadowRay> single = batch;
    RayCounters counters;
    rays.occluded(batch, 0, counters);
    EXPECT_EQ(counters.visibility, count);
    for (size_t i = 0; i < count; ++i) {
      const bool under =
          std::abs(single[i].origin_x) < 1 && std::abs(single[i].origin_z) < 1 && single[i].far_distance > 1;
      rays.occluded({&single[i], 1}, 0, counters);
      EXPECT_EQ(batch[i].blocked(), single[i].blocked());
      EXPECT_EQ(batch[i].blocked(), under);
    }
  }
}

TEST(Rays, TheGateRejectsWhatEmbreeWouldAbortOn) {
  const Scene scene = table_scene();
  const RayScene rays(scene);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<ShadowRay> bad(9, upward(0, 0));
  bad[0].origin_x = nan;
  bad[1].direction_y = nan;
  bad[2].near_distance = nan;
  bad[3].far_distance = nan;
  bad[4].near_distance = -1;
  bad[5].origin_z = infinity;
  bad[6].direction_x = 2e18f;
  bad[7].origin_y = -3e18f;
  bad[8].far_distance = -1;
  std::vector<ShadowRay> batch = bad;
  batch.insert(batch.begin() + 4, upward(5, 0));  // a good one among them
  batch.push_back(upward(0, 0));
  RayCounters counters;
  rays.occluded(batch, 0, counters);
  EXPECT_EQ(counters.rejected, bad.size());
  EXPECT_EQ(counters.visibility, 2u);
  EXPECT_FALSE(batch[4].blocked());
  for (size_t i = 0; i < batch.size(); ++i) {
    if (i != 4) {
      EXPECT_TRUE(batch[i].blocked()) << i;
    }
  }
  RayHit hit;
  EXPECT_FALSE(rays.intersect({nan, 0, 0}, {0, 1, 0}, 0, infinity, 0, hit, counters));
  EXPECT_FALSE(rays.intersect({0, 0, 0}, {0, infinity, 0}, 0, infinity, 0, hit, counters));
  EXPECT_EQ(counters.rejected, bad.size() + 2);
}

TEST(Rays, AnEmptySceneBlocksNothing) {
  const Scene scene;
  const RayScene rays(scene);
  RayCounters counters;
  ShadowRay ray = upward(0, 0);
  rays.occluded({&ray, 1}, 0, counters);
  EXPECT_FALSE(ray.blocked());
  rays.occluded({}, 0, counters);
  EXPECT_EQ(counters.visibility, 1u);
}

TEST(Rays, MasksAndBlendsLetTheirShareThrough) {
  for (const AlphaMode mode : {AlphaMode::mask, AlphaMode::blend}) {
    Scene scene = floor_scene(10);
    Material pane = diffuse_material(Vec3(0.5f));
    pane.alpha_mode = mode;
    pane.base_color.a = 0.3f;
    pane.alpha_cutoff = 0.25f;
    scene.materials.push_back(pane);
    add_patch(scene, {-1, 1, 1}, {2, 0, 0}, {0, 0, -2}, 1);
    const RayScene rays(scene);
    constexpr size_t count = 20000;
    std::vector<ShadowRay> batch;
    RandomStream random(1, 2, 3);
    for (size_t i = 0; i < count; ++i) {
      const Vec2 u = random.next2();
      batch.push_back(upward(1.9f * u.x - 0.95f, 1.9f * u.y - 0.95f));
    }
    std::vector<ShadowRay> again = batch;
    RayCounters counters;
    rays.occluded(batch, 7, counters);
    rays.occluded(again, 7, counters);
    size_t blocked = 0;
    for (size_t i = 0; i < count; ++i) {
      blocked += batch[i].blocked();
      EXPECT_EQ(batch[i].blocked(), again[i].blocked()) << "one seed is one fixed scene";
    }
    const double share = static_cast<double>(blocked) / count;
    if (mode == AlphaMode::mask)
      EXPECT_EQ(share, 1);  // 0.3 ≥ the cutoff
    else
      EXPECT_NEAR(share, 0.3, 4 * std::sqrt(0.3 * 0.7 / count));
  }
}

TEST(Rays, ClosestHitsGoThroughHoles) {
  Scene scene = floor_scene(10);
  Material pane = diffuse_material(Vec3(0.5f));
  pane.alpha_mode = AlphaMode::mask;
  scene.materials.push_back(pane);
  add_patch(scene, {-1, 1, 1}, {2, 0, 0}, {0, 0, -2}, 1);
  for (const float alpha : {0.4f, 0.6f}) {
    scene.materials[1].base_color.a = alpha;
    const RayScene rays(scene);
    RayCounters counters;
    RayHit hit;
    ASSERT_TRUE(rays.intersect({0.1f, 3, 0.2f}, {0, -1, 0}, 0, infinity, 0, hit, counters));
    EXPECT_FLOAT_EQ(hit.distance, alpha < pane.alpha_cutoff ? 3 : 2);
    EXPECT_EQ(scene.triangle_material[hit.point.triangle], alpha < pane.alpha_cutoff ? 0u : 1u);
    EXPECT_NEAR(surface_position(scene, hit.point).x, 0.1f, 1e-6f);

    // A stream of them meets and counts the same.
    RayCounters of_stream;
    std::array<ClosestRay, 1> stream{ClosestRay{{0.1f, 3, 0.2f, 0, 0, -1, 0, 0, infinity}}};
    rays.intersect(stream, true, 0, of_stream);
    ASSERT_TRUE(stream[0].met());
    EXPECT_EQ(rays.hit_of(stream[0]).point.triangle, hit.point.triangle);
    EXPECT_EQ(of_stream.alpha_tests, counters.alpha_tests);
    EXPECT_GT(of_stream.alpha_tests, 0u);
  }
}

/// Boxes of many sizes and turns.
Scene cluttered_scene(float scale) {
  Scene scene = floor_scene(10 * scale);
  RandomStream random(8, 8, 8);
  for (int i = 0; i < 300; ++i) {
    const Vec2 a = random.next2(), b = random.next2(), c = random.next2();
    const Vec3 corner(8 * a.x - 4, 4 * a.y, 8 * b.x - 4);
    const Vec3 u = 0.6f * uniform_sphere(c), v = 0.6f * uniform_sphere({b.y, c.x});
    add_patch(scene, scale * corner, scale * u, scale * v);
  }
  return scene;
}

TEST(Rays, VisibilityDoesNotHangOnTheUnitOfLength) {
  // Powers of two change no digit: each ray must have the same answer.
  std::vector<bool> first;
  for (const float scale : {1.0f, 0x1p-20f, 0x1p20f}) {
    const Scene scene = cluttered_scene(scale);
    const RayScene rays(scene);
    std::vector<ShadowRay> batch;
    RandomStream random(3, 1, 4);
    for (int i = 0; i < 20000; ++i) {
      const auto pick = [&] {
        const auto triangle =
            static_cast<uint32_t>(random.next() * static_cast<float>(scene.triangles.size()));
        return SurfacePoint{triangle, uniform_triangle(random.next2())};
      };
      const SurfacePoint a = pick(), b = pick();
      const Vec3 from = surface_position(scene, a), offset = surface_position(scene, b) - from;
      const float distance = glm::length(offset);
      if (!(distance > 0)) continue;
      batch.push_back(shadow_ray(scene, from, glm::normalize(triangle_cross(scene, a.triangle)),
                                 offset / distance, distance));
    }
    RayCounters counters;
    rays.occluded(batch, 0, counters);
    EXPECT_EQ(counters.rejected, 0u);
    std::vector<bool> blocked;
    for (const ShadowRay& ray : batch) blocked.push_back(ray.blocked());
    if (first.empty()) first = blocked;
    EXPECT_EQ(blocked, first) << scale;
  }
  const auto share = static_cast<double>(std::count(first.begin(), first.end(), true)) / first.size();
  EXPECT_GT(share, 0.1);
  EXPECT_LT(share, 0.9);
}

TEST(Rays, ShadowRaysStartAndEndOffTheSurfaces) {
  // Rays between points of the floor and of the table's underside meet neither end, at any scale of the
  // scene.
  for (const float scale : {0x1p-20f, 1.0f, 0x1p20f}) {
    const Scene scene = table_scene(scale);
    const RayScene rays(scene);
    RandomStream random(5, 5, 5);
    RayCounters counters;
    for (int i = 0; i < 2000; ++i) {
      const Vec2 a = random.next2(), b = random.next2();
      const Vec3 from = scale * Vec3(8 * a.x - 4, 0, 8 * a.y - 4),
                 to = scale * Vec3(1.9f * b.x - 0.95f, 1, 1.9f * b.y - 0.95f);
      const float distance = glm::length(to - from);
      ShadowRay ray = shadow_ray(scene, from, {0, 1, 0}, (to - from) / distance, distance);
      rays.occluded({&ray, 1}, 0, counters);
      EXPECT_FALSE(ray.blocked()) << scale << " " << i;
      ShadowRay beyond = shadow_ray(scene, from, {0, 1, 0}, (to - from) / distance, 1.01f * distance);
      rays.occluded({&beyond, 1}, 0, counters);
      EXPECT_TRUE(beyond.blocked()) << scale << " " << i;
    }
  }
}

}  // namespace
}  // namespace halflight
