// The camera a scene without one gets: rooms from inside, boxes with an open side through it, objects from
// outside.
#include <array>
#include <mutex>
#include <vector>

#include "core/parallel.h"
#include "scene/camera.h"
#include "scene/load.h"
#include "scene/ray_grid.h"

namespace halflight {

namespace {

constexpr float picture_aspect = 4.0f / 3;
constexpr float object_fov = 40 * pi / 180, room_fov = 65 * pi / 180;  // vertical
constexpr float object_fill = 0.92f;                                   // of the picture's half sides

// A point is enclosed where this share of the directions around it meets the front of a surface; a scene is a
// room where such points take this share of its bounds. Hollow objects show their insides' backs, so theirs
// are not.
constexpr float enclosed_share = 0.8f, room_share = 0.33f;
// An axis is open where this share of the enclosed points look out along it.
constexpr float open_share = 0.6f;

constexpr int probe_directions = 48;
constexpr size_t most_probes = 2000, most_eyes = 300;
constexpr int yaw_steps = 24;
constexpr std::array<float, 3> fan_pitches{-0.35f, -0.05f, 0.25f};  // radians

/// Direction i of n spread evenly over the sphere (spherical Fibonacci lattice).
Vec3 lattice_direction(int i, int n) {
  const float golden_angle = 2.39996323f, z = 1 - (2 * static_cast<float>(i) + 1) / static_cast<float>(n);
  const float r = std::sqrt(1 - z * z), phi = golden_angle * static_cast<float>(i);
  return {r * std::cos(phi), z, r * std::sin(phi)};
}

/// Unit direction; yaw 0 is +z, positive towards +x.
Vec3 yaw_direction(float yaw, float pitch) {
  return {std::cos(pitch) * std::sin(yaw), std::sin(pitch), std::cos(pitch) * std::cos(yaw)};
}

/// Every `stride`-th cell along each axis that leaves at most `most` of them; `total` counts the full ones
/// too.
std::vector<UVec3> probe_cells(const RayGrid& grid, size_t most, size_t& total) {
  const UVec3 n = grid.size();
  uint32_t stride = 1;
  const auto count = [&](uint32_t s) {
    const UVec3 c = (n + s - 1u) / s;
    return static_cast<size_t>(c.x) * c.y * c.z;
  };
  while (count(stride) > most) ++stride;
  std::vector<UVec3> cells;
  total = 0;
  const auto first = [&](uint32_t size) { return std::min(stride / 2, size - 1); };
  for (uint32_t z = first(n.z); z < n.z; z += stride) {
    for (uint32_t y = first(n.y); y < n.y; y += stride) {
      for (uint32_t x = first(n.x); x < n.x; x += stride) {
        ++total;
        if (grid.empty({x, y, z})) cells.push_back({x, y, z});
      }
    }
  }
  return cells;
}

/// Distance to the nearest surface around a point.
float clearance(const RayGrid& grid, Vec3 p) {
  float nearest = infinity;
  for (int i = 0; i < probe_directions; ++i)
    nearest = std::min(nearest, grid.cast(p, lattice_direction(i, probe_directions)).distance);
  return nearest;
}

/// Whether a point is enclosed; most are seen not to be after a few directions.
bool is_enclosed(const RayGrid& grid, Vec3 p) {
  constexpr int most_others = static_cast<int>((1 - enclosed_share) * probe_directions);
  int others = 0;
  for (int i = 0; i < probe_directions && others <= most_others; ++i)
    others += !grid.cast(p, lattice_direction(i, probe_directions)).front;
  return others <= most_others;
}

/// Centres of the probed cells that are enclosed; empty where they are too few for a room.
std::vector<Vec3> enclosed_points(const RayGrid& grid) {
  size_t total = 0;
  const std::vector<UVec3> cells = probe_cells(grid, most_probes, total);
  std::vector<uint8_t> enclosed(cells.size());
  parallel_for(0, cells.size(), 16, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      enclosed[i] = is_enclosed(grid, grid.cell_centre(cells[i]));
    }
  });
  std::vector<Vec3> points;
  for (size_t i = 0; i < cells.size(); ++i) {
    if (enclosed[i]) points.push_back(grid.cell_centre(cells[i]));
  }
  if (static_cast<float>(points.size()) < room_share * static_cast<float>(total)) points.clear();
  return points;
}

/// The horizontal axis direction most enclosed points look out along; zero where the room is closed.
Vec3 open_side(const RayGrid& grid, const std::vector<Vec3>& points) {
  Vec3 open(0);
  float best = open_share;
  for (const Vec3 side : {Vec3(0, 0, 1), Vec3(1, 0, 0), Vec3(0, 0, -1), Vec3(-1, 0, 0)}) {
    size_t escaping = 0;
    for (const Vec3& p : points) escaping += !grid.cast(p, side).found();
    const float share = static_cast<float>(escaping) / static_cast<float>(points.size());
    if (share > best) open = side, best = share;
  }
  return open;
}

/// Where a camera of given orientation has to stand so that points just fill its picture: each pair of
/// opposite frustum planes touches them, which fixes the eye across the view and how far back it is; the
/// farther pair decides.
class PictureFit {
 public:
  PictureFit(const Camera& camera, Vec3 origin)
      : camera_(camera), origin_(origin), ky_(object_fill * std::tan(0.5f * camera.vertical_fov)) {}

  void add(Vec3 point) {
    const Vec3 p = point - origin_;
    const float x = glm::dot(p, camera_.right), y = glm::dot(p, camera_.up), z = glm::dot(p, camera_.back);
    right_ = std::max(right_, x + kx_ * z), left_ = std::max(left_, -x + kx_ * z);
    top_ = std::max(top_, y + ky_ * z), bottom_ = std::max(bottom_, -y + ky_ * z);
    nearest_ = std::max(nearest_, z);
  }

  /// Of the same camera: what another has been given too.
  void add(const PictureFit& other) {
    right_ = std::max(right_, other.right_), left_ = std::max(left_, other.left_);
    top_ = std::max(top_, other.top_), bottom_ = std::max(bottom_, other.bottom_);
    nearest_ = std::max(nearest_, other.nearest_);
  }

  /// The camera moved, at least `least_distance` before the nearest point.
  Camera camera(float least_distance) const {
    const float back =
        std::max({(right_ + left_) / (2 * kx_), (top_ + bottom_) / (2 * ky_), nearest_ + least_distance});
    Camera moved = camera_;
    moved.position = origin_ + 0.5f * (right_ - left_) * camera_.right +
                     0.5f * (top_ - bottom_) * camera_.up + back * camera_.back;
    return moved;
  }

 private:
  Camera camera_;
  Vec3 origin_;
  float ky_, kx_ = ky_ * picture_aspect;
  float right_ = -infinity, left_ = -infinity, top_ = -infinity, bottom_ = -infinity, nearest_ = -infinity;
};

float least_distance(const Scene& scene) {
  const float size = scene.bounds.diagonal();
  return size > 0 ? 0.05f * size : 1.0f;
}

Camera fit_to_bounds(const Scene& scene, const Camera& orientation) {
  PictureFit fit(orientation, scene.bounds.centre());
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 side(corner & 1, corner >> 1 & 1, corner >> 2);
    fit.add(glm::mix(scene.bounds.low, scene.bounds.high, side));
  }
  return fit.camera(least_distance(scene));
}

Camera fit_to_vertices(const Scene& scene, const Camera& orientation) {
  PictureFit fit(orientation, scene.bounds.centre());
  std::mutex mutex;
  parallel_for(0, scene.triangles.size(), 16384, [&](size_t begin, size_t end) {
    PictureFit piece(orientation, scene.bounds.centre());
    for (size_t i = begin; i < end; ++i)
      for (int corner = 0; corner < 3; ++corner)
        piece.add(scene.vertices[scene.triangles[i][corner]].position);
    const std::lock_guard lock(mutex);
    fit.add(piece);
  });
  return fit.camera(least_distance(scene));
}

/// Direction from the scene to the eye: three quarters, slightly above; what is flat is seen from its broad
/// side.
Vec3 object_direction(Vec3 extent) {
  constexpr float flat = 0.2f;
  if (extent.y < flat * std::min(extent.x, extent.z)) return {0.45f, 0.8f, 0.8f};
  if (extent.z < flat * extent.x) return {0.2f, 0.12f, 1};
  if (extent.x < flat * extent.z) return {1, 0.12f, 0.2f};
  return {0.5f, 0.35f, 0.8f};
}

/// Share of a picture's rays that meet fronts, less those that meet backs.
float front_excess(const RayGrid& grid, const Camera& camera) {
  constexpr int columns = 24, rows = 18;
  int excess = 0;
  for (int i = 0; i < columns * rows; ++i) {
    const Vec2 pixel(static_cast<float>(i % columns) + 0.5f, static_cast<float>(i / columns) + 0.5f);
    const CameraRay ray = camera_ray(camera, pixel, columns, rows);
    const RayGrid::Hit hit = grid.cast(ray.origin, ray.direction);
    if (hit.found()) excess += hit.front ? 1 : -1;
  }
  return static_cast<float>(excess) / (columns * rows);
}

Camera frame_object(const Scene& scene, const RayGrid& grid) {
  const Vec3 direction = object_direction(scene.bounds.extent());
  Camera best;
  float best_excess = -infinity;
  // Models face +z (glTF 2.0, "Coordinate System"): other quarters must show clearly more fronts, as of an
  // open stage.
  for (const Vec2 signs : {Vec2(1, 1), Vec2(-1, 1), Vec2(1, -1), Vec2(-1, -1)}) {
    const Vec3 to_eye(signs.x * direction.x, direction.y, signs.y * direction.z);
    const Camera camera = fit_to_bounds(scene, look_at(to_eye, Vec3(0), {0, 1, 0}, object_fov));
    const float excess = front_excess(grid, camera);
    if (excess > best_excess + 0.1f) best = camera, best_excess = excess;
  }
  return fit_to_vertices(scene, best);
}

// ---- Inside a room ----

/// A place to stand: free around, between a floor and a ceiling.
struct Eye {
  Vec3 position;
  float room_height;
};

/// Enclosed cells at eye height that nothing stands close to, thinned to a bounded number.
std::vector<Eye> standing_places(const RayGrid& grid) {
  size_t total = 0;
  std::vector<UVec3> cells = probe_cells(grid, std::numeric_limits<size_t>::max(), total);
  std::vector<Eye> eyes(cells.size(), Eye{Vec3(0), 0});
  parallel_for(0, cells.size(), 64, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const Vec3 p = grid.cell_centre(cells[i]);
      const RayGrid::Hit floor = grid.cast(p, {0, -1, 0});
      if (!floor.front) continue;
      const RayGrid::Hit ceiling = grid.cast(p, {0, 1, 0});
      if (!ceiling.front) continue;
      const float height = floor.distance + ceiling.distance, at = floor.distance / height;
      if (at >= 0.5f && at <= 0.72f) eyes[i] = {p, height};
    }
  });
  float tallest = 0;
  for (const Eye& eye : eyes) tallest = std::max(tallest, eye.room_height);
  // Lower places are under tables and in cupboards.
  std::erase_if(eyes,
                [&](const Eye& eye) { return eye.room_height < 0.6f * tallest || eye.room_height <= 0; });
  std::vector<Eye> kept;
  const size_t step = eyes.size() / most_eyes + 1;
  for (size_t i = 0; i < eyes.size(); i += step) {
    const Vec3 p = eyes[i].position;
    if (is_enclosed(grid, p) && clearance(grid, p) >= 0.12f * eyes[i].room_height) kept.push_back(eyes[i]);
  }
  return kept;
}

struct View {
  float score = -infinity;
  float yaw = 0;
};

/// The direction with most free space in the picture. Rays that leave the room or meet backs show nothing of
/// it.
View best_view(const RayGrid& grid, const Eye& eye) {
  std::array<float, yaw_steps> column{};
  std::array<float, yaw_steps> nearest;
  for (int i = 0; i < yaw_steps; ++i) {
    nearest[i] = infinity;
    for (const float pitch : fan_pitches) {
      const RayGrid::Hit hit = grid.cast(eye.position, yaw_direction(2 * pi * i / yaw_steps, pitch));
      if (hit.front) column[i] += hit.distance / fan_pitches.size();
      nearest[i] = std::min(nearest[i], hit.distance);
    }
  }
  View best;
  // Half of the picture's width is 40 degrees: the columns up to two steps of 15 degrees away, the third for
  // half.
  for (int centre = 0; centre < yaw_steps; ++centre) {
    float sum = 0, closest = infinity;
    for (int offset = -3; offset <= 3; ++offset) {
      const int i = (centre + offset + yaw_steps) % yaw_steps;
      sum += std::abs(offset) == 3 ? 0.5f * column[i] : column[i];
      closest = std::min(closest, nearest[i]);
    }
    // Something close before the lens hides what the free distance promises.
    const float score = sum * std::min(1.0f, 0.4f + closest / eye.room_height);
    if (score > best.score) best = {score, 2 * pi * static_cast<float>(centre) / yaw_steps};
  }
  return best;
}

/// A view from inside; not generated where nobody could stand.
Camera frame_room(const RayGrid& grid) {
  const std::vector<Eye> eyes = standing_places(grid);
  std::vector<View> views(eyes.size());
  parallel_for(0, eyes.size(), 8, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) views[i] = best_view(grid, eyes[i]);
  });
  Camera camera;
  float best = -infinity;
  for (size_t i = 0; i < eyes.size(); ++i) {
    if (views[i].score <= best) continue;
    best = views[i].score;
    constexpr float pitch = -0.12f;  // a little down, where furniture is
    camera = look_at(Vec3(0), yaw_direction(views[i].yaw, pitch), {0, 1, 0}, room_fov);
    camera.position = eyes[i].position;
    camera.generated = true;
  }
  return camera;
}

Camera frame(const Scene& scene) {
  const float size = scene.bounds.diagonal();
  // Nothing but the background, or coordinates whose squares overflow.
  if (scene.bounds.empty() || !std::isfinite(size))
    return look_at({0, 0, 0}, {0, 0, -1}, {0, 1, 0}, room_fov);
  // All in one point, or so small that squares vanish.
  if (size == 0) return fit_to_bounds(scene, look_at({0, 0, 1}, Vec3(0), {0, 1, 0}, object_fov));

  const RayGrid grid(scene);
  const std::vector<Vec3> enclosed = enclosed_points(grid);
  if (!enclosed.empty()) {
    const Vec3 open = open_side(grid, enclosed);
    if (open != Vec3(0)) return fit_to_vertices(scene, look_at(open, Vec3(0), {0, 1, 0}, object_fov));
    const Camera inside = frame_room(grid);
    if (inside.generated) return inside;
  }
  return frame_object(scene, grid);
}

}  // namespace

void complete_camera(Scene& scene, Messages&) {
  if (!scene.cameras.empty()) return;
  Camera camera = frame(scene);
  camera.name = "framed";
  camera.generated = true;
  scene.facts.added_camera = true;
  scene.cameras.push_back(camera);
}

}  // namespace halflight
