#include <gtest/gtest.h>

#include "viewer/camera_controls.h"

namespace halflight {
namespace {

const Camera start = look_at({4, 3, 5}, {1, 0.5f, -1}, {0, 1, 0}, 0.8f);
const Vec3 pivot{1, 0.5f, -1};

/// Where a world point appears, in pixels of a 640×480 view.
Vec2 on_screen(const Camera& camera, Vec3 p) {
  const Vec4 clip = projection_matrix(camera, 640, 480, 0.1f, 100) * view_matrix(camera) * Vec4(p, 1);
  return {(clip.x / clip.w * 0.5f + 0.5f) * 640, (0.5f - clip.y / clip.w * 0.5f) * 480};
}

TEST(CameraControls, OrbitKeepsDistanceAndSight) {
  Camera camera = start;
  for (int i = 0; i < 50; ++i) {
    camera = orbit_by_drag(camera, pivot, {37, -11}, 480);
    EXPECT_NEAR(glm::length(camera.position - pivot), glm::length(start.position - pivot), 1e-3f);
    EXPECT_NEAR(glm::dot(camera.right, camera.up), 0, 1e-4f);
    EXPECT_NEAR(on_screen(camera, pivot).x, 320, 0.5f);
    EXPECT_NEAR(on_screen(camera, pivot).y, 240, 0.5f);
    EXPECT_GT(camera.up.y, -1e-4f) << "upside down after " << i << " drags";
  }
}

TEST(CameraControls, DraggingRightTurnsTheSceneRight) {
  const Vec3 near_side = pivot + glm::normalize(start.position - pivot);
  EXPECT_GT(on_screen(orbit_by_drag(start, pivot, {20, 0}, 480), near_side).x, on_screen(start, near_side).x);
  EXPECT_GT(on_screen(orbit_by_drag(start, pivot, {0, 20}, 480), near_side).y, on_screen(start, near_side).y);
}

TEST(CameraControls, PanKeepsThePivotUnderThePointer) {
  const Vec2 drag{63, -41};
  const Vec2 moved = on_screen(pan_by_drag(start, pivot, drag, 480), pivot) - on_screen(start, pivot);
  EXPECT_NEAR(moved.x, drag.x, 0.2f);
  EXPECT_NEAR(moved.y, drag.y, 0.2f);
}

TEST(CameraControls, ZoomApproachesButNeverReachesThePivot) {
  Camera camera = start;
  float distance = glm::length(camera.position - pivot);
  for (int i = 0; i < 30; ++i) {
    camera = zoom_by_wheel(camera, pivot, 1);
    const float closer = glm::length(camera.position - pivot);
    EXPECT_LT(closer, distance);
    EXPECT_GT(closer, 0);
    distance = closer;
  }
  const Camera there_and_back = zoom_by_wheel(zoom_by_wheel(start, pivot, 3), pivot, -3);
  EXPECT_NEAR(glm::length(there_and_back.position - start.position), 0, 1e-4f);
}

TEST(CameraControls, ZoomWidensAnOrthographicView) {
  Camera camera = start;
  camera.projection = Projection::orthographic;
  const Camera zoomed = zoom_by_wheel(camera, pivot, 2);
  EXPECT_LT(zoomed.half_height, camera.half_height);
  EXPECT_EQ(zoomed.position, camera.position);
}

}  // namespace
}  // namespace halflight
