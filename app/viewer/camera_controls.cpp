#include "viewer/camera_controls.h"

namespace halflight {

Camera orbit_by_drag(const Camera& camera, Vec3 pivot, Vec2 pixels, int view_height) {
  const Vec2 angle = pixels * (pi / static_cast<float>(std::max(view_height, 1)));
  return orbit(camera, pivot, -angle.x, -angle.y);
}

Camera pan_by_drag(const Camera& camera, Vec3 pivot, Vec2 pixels, int view_height) {
  const float depth = std::max(-glm::dot(pivot - camera.position, camera.back), 0.0f);
  const float half_height = camera.projection == Projection::orthographic
                                ? camera.half_height
                                : depth * std::tan(0.5f * camera.vertical_fov);
  const float unit = 2 * half_height / static_cast<float>(std::max(view_height, 1));
  Camera moved = camera;
  moved.position += (-pixels.x * camera.right + pixels.y * camera.up) * unit;
  return moved;
}

Camera zoom_by_wheel(const Camera& camera, Vec3 pivot, float clicks) {
  const float scale = std::pow(0.88f, clicks);
  Camera moved = camera;
  if (camera.projection == Projection::orthographic) {
    moved.half_height *= scale;
  } else {
    moved.position = pivot + (camera.position - pivot) * scale;
  }
  return moved;
}

}  // namespace halflight
