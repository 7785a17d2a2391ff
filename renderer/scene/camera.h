// Cameras: rays, projection, and the view a scene without one gets.
#pragma once

#include "scene/scene.h"

namespace halflight {

struct CameraRay {
  Vec3 origin, direction;  ///< direction is unit
};

/// Rays of a picture's pixels; what they share is found once. Refers to the camera.
class CameraRays {
 public:
  CameraRays(const Camera&, int width, int height);

  /// Ray through `pixel` (x right, y down, in pixels; the centre of pixel (i, j) is (i + ½, j + ½)).
  /// Orthographic rays start in the camera's plane.
  CameraRay through(Vec2 pixel) const;

 private:
  const Camera& camera_;
  Vec2 size_;
  float half_height_, aspect_;
};

/// One of them.
CameraRay camera_ray(const Camera&, Vec2 pixel, int width, int height);

/// World to camera space: x right, y up, looking along −z.
Mat4 view_matrix(const Camera&);
/// OpenGL clip space, depth −1..1; planes along the view direction. `jitter` moves the picture, in pixels
/// right and down: what `camera_ray` sees at `pixel` is drawn at `pixel + jitter`. To see through pixel
/// centres moved by j, pass −j.
Mat4 projection_matrix(const Camera&, int width, int height, float near_plane, float far_plane,
                       Vec2 jitter = Vec2(0));

/// Near and far planes that hold the scene's bounds seen from the camera; near > 0, far/near bounded for
/// 24-bit depth.
struct ClipRange {
  float near_plane, far_plane;
};
ClipRange clip_range(const Camera&, const Aabb& bounds);

/// Perspective camera at `eye` looking at `target`; `vertical_fov` in radians. Any roll where `up` is the
/// view direction.
Camera look_at(Vec3 eye, Vec3 target, Vec3 up, float vertical_fov);

/// Turns a camera rigidly about `pivot`, whose distance and place in the picture stay: `yaw` in radians about
/// the world's +y, `pitch` about the camera's right (positive looks up). Pitch stops just short of the poles
/// and never flips.
Camera orbit(const Camera&, Vec3 pivot, float yaw, float pitch);

}  // namespace halflight
