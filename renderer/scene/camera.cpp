#include "scene/camera.h"

namespace halflight {

namespace {

// A 24-bit depth buffer resolves z to z · (far/near) / 2²⁴: one part in 800 at the far plane.
constexpr float greatest_clip_ratio = 20000;

// Orbiting stops this far from the poles, where left and right would exchange.
constexpr float greatest_elevation = 89.5f * pi / 180;

/// Half of the height seen at unit distance (orthographic: at any).
float half_height_seen(const Camera& camera) {
  return camera.projection == Projection::perspective ? std::tan(0.5f * camera.vertical_fov)
                                                      : camera.half_height;
}

float aspect_ratio(int width, int height) { return static_cast<float>(width) / static_cast<float>(height); }

Vec3 rotate_about(Vec3 v, Vec3 axis, float angle) {
  // Rodrigues' formula.
  const float c = std::cos(angle), s = std::sin(angle);
  return v * c + glm::cross(axis, v) * s + axis * (glm::dot(axis, v) * (1 - c));
}

void orthonormalise(Camera& camera) {
  camera.back = glm::normalize(camera.back);
  camera.right = glm::normalize(camera.right - camera.back * glm::dot(camera.right, camera.back));
  camera.up = glm::cross(camera.back, camera.right);
}

}  // namespace

CameraRays::CameraRays(const Camera& camera, int width, int height)
    : camera_(camera),
      size_(width, height),
      half_height_(half_height_seen(camera)),
      aspect_(aspect_ratio(width, height)) {}

CameraRay CameraRays::through(Vec2 pixel) const {
  const float x = (2 * pixel.x / size_.x - 1) * half_height_ * aspect_;
  const float y = (1 - 2 * pixel.y / size_.y) * half_height_;
  const Vec3 offset = x * camera_.right + y * camera_.up;
  if (camera_.projection == Projection::orthographic) return {camera_.position + offset, -camera_.back};
  return {camera_.position, glm::normalize(offset - camera_.back)};
}

CameraRay camera_ray(const Camera& camera, Vec2 pixel, int width, int height) {
  return CameraRays(camera, width, height).through(pixel);
}

Mat4 view_matrix(const Camera& camera) {
  const Vec3 &r = camera.right, &u = camera.up, &b = camera.back, &p = camera.position;
  return {{r.x, u.x, b.x, 0},
          {r.y, u.y, b.y, 0},
          {r.z, u.z, b.z, 0},
          {-glm::dot(r, p), -glm::dot(u, p), -glm::dot(b, p), 1}};
}

Mat4 projection_matrix(const Camera& camera, int width, int height, float near_plane, float far_plane,
                       Vec2 jitter) {
  const float half_height = half_height_seen(camera);
  const float half_width = half_height * aspect_ratio(width, height);
  const Vec2 shift(2 * jitter.x / static_cast<float>(width), -2 * jitter.y / static_cast<float>(height));
  const float depth = far_plane - near_plane;
  Mat4 m(0);
  m[0][0] = 1 / half_width;
  m[1][1] = 1 / half_height;
  if (camera.projection == Projection::perspective) {
    m[2] = {-shift.x, -shift.y, -(far_plane + near_plane) / depth, -1};
    m[3] = {0, 0, -2 * far_plane * near_plane / depth, 0};
  } else {
    m[2][2] = -2 / depth;
    m[3] = {shift.x, shift.y, -(far_plane + near_plane) / depth, 1};
  }
  return m;
}

ClipRange clip_range(const Camera& camera, const Aabb& bounds) {
  if (bounds.empty()) return {1.0f / greatest_clip_ratio, 1.0f};
  // A box's extent along a direction: its centre plus or minus the absolute sum of its half extents.
  const float centre = glm::dot(bounds.centre() - camera.position, -camera.back);
  const float reach = glm::dot(0.5f * bounds.extent(), glm::abs(camera.back));
  // Room for rounding, and for scenes that are flat or lie in one point.
  const float margin = 0.001f * reach + 1e-5f * glm::length(bounds.centre() - camera.position) + 1e-30f;
  const float far_plane = centre + reach + margin;
  if (!(far_plane > 0)) return {reach / greatest_clip_ratio + 1e-30f, reach + 1e-25f};
  return {std::max(centre - reach - margin, far_plane / greatest_clip_ratio), far_plane};
}

Camera look_at(Vec3 eye, Vec3 target, Vec3 up, float vertical_fov) {
  Camera camera;
  camera.position = eye;
  camera.vertical_fov = vertical_fov;
  const Vec3 back = eye - target;
  const float distance = glm::length(back);
  if (!(distance > 0) || !std::isfinite(distance)) return camera;
  camera.back = back / distance;
  const Vec3 right = glm::cross(up, camera.back);
  // Looking along `up`: any right will do, the world's x first.
  const float sine = glm::length(right);
  camera.right = sine > 1e-6f * glm::length(up) ? right / sine : basis_along(camera.back, {1, 0, 0}).tangent;
  camera.up = glm::cross(camera.back, camera.right);
  return camera;
}

Camera orbit(const Camera& camera, Vec3 pivot, float yaw, float pitch) {
  Camera moved = camera;
  Vec3 offset = camera.position - pivot;
  const float distance = glm::length(offset);

  // A turn by p about `right` takes atan2(back.y, up.y), the elevation, down by p; it stays between the
  // poles.
  const float elevation = std::atan2(camera.back.y, camera.up.y);
  const float lowest = std::min(-greatest_elevation, elevation),
              highest = std::max(greatest_elevation, elevation);
  const float turn = elevation - std::clamp(elevation - pitch, lowest, highest);

  for (Vec3* v : {&moved.up, &moved.back, &offset}) *v = rotate_about(*v, camera.right, turn);
  for (Vec3* v : {&moved.right, &moved.up, &moved.back, &offset}) *v = rotate_about(*v, {0, 1, 0}, yaw);
  orthonormalise(moved);
  const float rotated = glm::length(offset);
  moved.position = pivot + (rotated > 0 ? offset * (distance / rotated) : Vec3(0));
  return moved;
}

}  // namespace halflight
