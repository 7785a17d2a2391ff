// Cameras: rays, projection, and the view a scene without one gets.
#pragma once

#include "scene/scene.h"

namespace halflight {

struct CameraRay {
  Vec3 origin, direction;  ///< direction is unit
};

/// Ray through `pixel` (x right, y down, in pixels; the centre of pixel (i, j) is (i + ½, j + ½)).
CameraRay camera_ray(const Camera&, Vec2 pixel, int width, int height);

Mat4 view_matrix(const Camera&);
/// OpenGL clip space, depth −1..1; `near`/`far` along the view direction. `jitter` moves the picture in pixels.
Mat4 projection_matrix(const Camera&, int width, int height, float near_plane, float far_plane, Vec2 jitter = Vec2(0));

/// Near and far planes that hold the scene's bounds seen from the camera; near > 0, far/near bounded for 24-bit depth.
struct ClipRange { float near_plane, far_plane; };
ClipRange clip_range(const Camera&, const Aabb& bounds);

/// Camera at `eye` looking at `target`.
Camera look_at(Vec3 eye, Vec3 target, Vec3 up, float vertical_fov);

/// Moves a camera about `pivot`: `yaw` and `pitch` in radians about the world's +y and the camera's right.
Camera orbit(const Camera&, Vec3 pivot, float yaw, float pitch);

}  // namespace halflight
