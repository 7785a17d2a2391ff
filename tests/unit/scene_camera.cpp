// Cameras: rays against matrices, clip planes and orbiting.
#include "scene/camera.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"

using namespace halflight;

namespace {

Camera random_camera(RandomStream& random, bool orthographic) {
  const Vec3 eye = 10.0f * (2.0f * Vec3(random.next2(), random.next()) - 1.0f);
  const Vec3 target = 10.0f * (2.0f * Vec3(random.next2(), random.next()) - 1.0f);
  Camera camera = look_at(eye, target, {0, 1, 0}, 0.3f + 1.5f * random.next());
  if (orthographic)
    camera.projection = Projection::orthographic, camera.half_height = 0.5f + 3 * random.next();
  return camera;
}

/// Where a point is drawn, in pixels from the top left, and its depth in −1..1.
Vec3 project(const Mat4& projection, const Mat4& view, Vec3 p, int width, int height) {
  const Vec4 clip = projection * (view * Vec4(p, 1));
  const Vec3 ndc = Vec3(clip) / clip.w;
  return {0.5f * (ndc.x + 1) * width, 0.5f * (1 - ndc.y) * height, ndc.z};
}

}  // namespace

TEST(SceneCamera, points_of_a_ray_are_drawn_at_its_pixel) {
  RandomStream random(1, 2, 3);
  for (int i = 0; i < 500; ++i) {
    const Camera camera = random_camera(random, i % 4 == 0);
    const int width = 1 + static_cast<int>(700 * random.next()),
              height = 1 + static_cast<int>(500 * random.next());
    const Vec2 pixel = random.next2() * Vec2(width, height), jitter = random.next2() - 0.5f;
    const CameraRay ray = camera_ray(camera, pixel, width, height);
    EXPECT_NEAR(glm::length(ray.direction), 1, 1e-6f);
    const Vec3 p = ray.origin + (1 + 20 * random.next()) * ray.direction;
    const Mat4 projection = projection_matrix(camera, width, height, 1e-4f, 100, jitter);
    const Vec3 drawn = project(projection, view_matrix(camera), p, width, height);
    EXPECT_NEAR(drawn.x, pixel.x + jitter.x, 2e-5f * width + 1e-3f);
    EXPECT_NEAR(drawn.y, pixel.y + jitter.y, 2e-5f * height + 1e-3f);
    EXPECT_GE(drawn.z, -1);
    EXPECT_LE(drawn.z, 1);
  }
}

TEST(SceneCamera, gltf_orientation) {
  // glTF 2.0 "Cameras": looks along −z, +x to the right, +y up; yfov is the whole vertical angle.
  Camera camera;
  camera.vertical_fov = pi / 2;
  const CameraRay centre = camera_ray(camera, {320, 240}, 640, 480);
  EXPECT_NEAR(centre.direction.z, -1, 1e-6f);
  const CameraRay corner = camera_ray(camera, {640, 0}, 640, 480);
  EXPECT_NEAR(corner.direction.x / -corner.direction.z, 4.0f / 3, 1e-5f);
  EXPECT_NEAR(corner.direction.y / -corner.direction.z, 1, 1e-5f);
}

TEST(SceneCamera, depth_runs_from_minus_one_to_one) {
  Camera camera;
  for (const auto projection : {Projection::perspective, Projection::orthographic}) {
    camera.projection = projection;
    const Mat4 m = projection_matrix(camera, 4, 3, 0.5f, 20);
    EXPECT_NEAR(project(m, view_matrix(camera), {0, 0, -0.5f}, 4, 3).z, -1, 1e-5f);
    EXPECT_NEAR(project(m, view_matrix(camera), {0, 0, -20}, 4, 3).z, 1, 1e-5f);
  }
}

TEST(SceneCamera, clip_range_holds_the_bounds) {
  RandomStream random(4, 5, 6);
  for (const float scale : {1e-6f, 1.0f, 1e6f}) {
    for (int i = 0; i < 200; ++i) {
      Camera camera = random_camera(random, false);
      camera.position *= scale;
      Aabb bounds;
      bounds.extend(scale * 4.0f * (Vec3(random.next2(), random.next()) - 0.5f));
      bounds.extend(scale * 4.0f * (Vec3(random.next2(), random.next()) - 0.5f));
      const ClipRange range = clip_range(camera, bounds);
      EXPECT_GT(range.near_plane, 0);
      EXPECT_GT(range.far_plane, range.near_plane);
      EXPECT_LE(range.far_plane / range.near_plane, 1e5f);
      for (int corner = 0; corner < 8; ++corner) {
        const Vec3 p = glm::mix(bounds.low, bounds.high, Vec3(corner & 1, corner >> 1 & 1, corner >> 2));
        const float depth = glm::dot(p - camera.position, -camera.back);
        if (depth <= 0) continue;
        EXPECT_LE(depth, range.far_plane);
        EXPECT_GE(depth, std::min(range.near_plane, range.far_plane / 19000));
      }
    }
  }
  const ClipRange nothing = clip_range(Camera{}, Aabb{});
  EXPECT_GT(nothing.far_plane, nothing.near_plane);
  Aabb point;
  point.extend(Vec3(0));
  const ClipRange degenerate = clip_range(Camera{}, point);
  EXPECT_GT(degenerate.near_plane, 0);
  EXPECT_GT(degenerate.far_plane, degenerate.near_plane);
}

TEST(SceneCamera, look_at_is_orthonormal_and_survives_the_poles) {
  for (const Vec3 target : {Vec3(0, 0, -5), Vec3(0, 7, 0), Vec3(0, -7, 0), Vec3(1e-9f, 3, 0)}) {
    const Camera camera = look_at({0, 0, 0}, target, {0, 1, 0}, 1);
    EXPECT_NEAR(glm::dot(-camera.back, glm::normalize(target)), 1, 1e-6f);
    EXPECT_NEAR(glm::dot(camera.right, camera.up), 0, 1e-6f);
    EXPECT_NEAR(glm::dot(glm::cross(camera.right, camera.up), camera.back), 1, 1e-6f);
  }
  EXPECT_TRUE(is_finite(look_at({1, 1, 1}, {1, 1, 1}, {0, 1, 0}, 1).right));
}

TEST(SceneCamera, orbit_keeps_its_distance_and_never_flips) {
  RandomStream random(7, 8, 9);
  const Vec3 pivot(1, 2, 3);
  Camera camera = look_at({4, 3, 9}, pivot, {0, 1, 0}, 1);
  const float distance = glm::distance(camera.position, pivot);
  for (int i = 0; i < 2000; ++i) {
    const Vec2 u = random.next2();
    camera = orbit(camera, pivot, 2 * u.x - 1, 2 * u.y - 1);
    ASSERT_NEAR(glm::distance(camera.position, pivot), distance, 1e-4f * distance);
    ASSERT_GT(camera.up.y, 0);
    ASSERT_NEAR(camera.right.y, 0, 1e-4f);
    ASSERT_NEAR(glm::dot(-camera.back, glm::normalize(pivot - camera.position)), 1, 1e-4f);
    ASSERT_NEAR(glm::length(camera.up), 1, 1e-5f);
  }
}

TEST(SceneCamera, orbit_directions) {
  const Camera camera = look_at({0, 0, 5}, {0, 0, 0}, {0, 1, 0}, 1);
  // Yaw is counter-clockwise seen from above: +z goes to +x.
  const Camera yawed = orbit(camera, Vec3(0), 0.5f, 0);
  EXPECT_NEAR(yawed.position.x, 5 * std::sin(0.5f), 1e-5f);
  EXPECT_NEAR(yawed.position.z, 5 * std::cos(0.5f), 1e-5f);
  // Positive pitch looks up, so the camera goes below the pivot.
  const Camera pitched = orbit(camera, Vec3(0), 0, 0.5f);
  EXPECT_NEAR(pitched.position.y, -5 * std::sin(0.5f), 1e-5f);
  EXPECT_NEAR(-pitched.back.y, std::sin(0.5f), 1e-5f);
  const Camera pole = orbit(camera, Vec3(0), 0, -10);
  EXPECT_NEAR(pole.position.y, 5, 1e-2f);
  EXPECT_GT(pole.up.y, 0);
}
