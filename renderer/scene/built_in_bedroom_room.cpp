// The bedroom's shell: walls with mouldings, floor, ceiling, window and door.
#include "scene/built_in_bedroom.h"

namespace halflight {

namespace {

constexpr float window_low = 0.75f, window_high = 2.15f, window_near = 0.95f, window_far = 2.45f;

void add_walls(Bedroom& room) {
  const auto [w, h, d] = std::tuple(room_size.x, room_size.y, room_size.z);
  Scene& scene = room.scene;
  place(scene, rectangle_mesh({0, 0, d}, {w, 0, 0}, {0, 0, -d}), room.floor);
  place(scene, rectangle_mesh({0, h, 0}, {w, 0, 0}, {0, 0, d}), room.trim);
  place(scene, rectangle_mesh({0, 0, 0}, {w, 0, 0}, {0, h, 0}), room.feature_wall);
  place(scene, rectangle_mesh({w, 0, d}, {-w, 0, 0}, {0, h, 0}), room.wall);
  place(scene, rectangle_mesh({w, 0, 0}, {0, 0, d}, {0, h, 0}), room.wall);
  // The window's wall: four pieces around the opening.
  const auto piece = [&](float z0, float z1, float y0, float y1) {
    place(scene, rectangle_mesh({0, y0, z1}, {0, 0, z0 - z1}, {0, y1 - y0, 0}), room.wall);
  };
  piece(0, window_near, 0, h);
  piece(window_far, d, 0, h);
  piece(window_near, window_far, 0, window_low);
  piece(window_near, window_far, window_high, h);
}

/// Runs an outline (x away from the wall, y up) along all four walls; mitres are hidden where the runs meet.
void add_run(Bedroom& room, std::span<const Vec2> outline, uint32_t material) {
  const Mesh along_x = extrude_mesh(outline, room_size.x), along_z = extrude_mesh(outline, room_size.z);
  place(room.scene, along_z, material);
  place(room.scene, along_z, material, move({room_size.x, 0, room_size.z}) * turn(pi, {0, 1, 0}));
  place(room.scene, along_x, material, move({room_size.x, 0, 0}) * turn(-pi / 2, {0, 1, 0}));
  place(room.scene, along_x, material, move({0, 0, room_size.z}) * turn(pi / 2, {0, 1, 0}));
}

void add_mouldings(Bedroom& room) {
  const float h = room_size.y;
  add_run(
      room,
      std::vector<Vec2>{{0, 0}, {0.018f, 0}, {0.018f, 0.095f}, {0.012f, 0.11f}, {0.006f, 0.118f}, {0, 0.12f}},
      room.trim);
  const std::vector<Vec2> cove{{0, h - 0.09f},      {0.012f, h - 0.09f},  {0.02f, h - 0.075f},
                               {0.045f, h - 0.06f}, {0.065f, h - 0.035f}, {0.075f, h - 0.012f},
                               {0.09f, h - 0.01f},  {0.09f, h},           {0, h}};
  add_run(room, cove, room.trim);
  // Panels on the wall behind the bed.
  const std::vector<Vec2> bead{{-0.03f, 0},       {-0.028f, 0.010f}, {-0.020f, 0.014f},
                               {-0.012f, 0.009f}, {-0.004f, 0.012f}, {0, 0}};
  const float panels[][4] = {{0.16f, 0.92f, 0.25f, 2.33f}, {1.08f, 3.84f, 0.25f, 2.33f}};
  for (const auto& p : panels)
    place(room.scene, frame_mesh({p[1] - p[0], p[3] - p[2]}, bead), room.feature_wall,
          move({0.5f * (p[0] + p[1]), 0.5f * (p[2] + p[3]), 0}));
}

void add_window(Bedroom& room) {
  Scene& scene = room.scene;
  const float width = window_far - window_near, height = window_high - window_low, depth = 0.16f;
  const Vec3 centre(0, 0.5f * (window_low + window_high), 0.5f * (window_near + window_far));
  // Facing +x, the frame's plane being (−z, y).
  const Mat4 facing = move(centre) * turn(pi / 2, {0, 1, 0});
  const std::vector<Vec2> reveal{{-0.001f, -depth}, {0, 0},          {0, 0.012f},
                                 {0.05f, 0.018f},   {0.07f, 0.010f}, {0.07f, 0}};
  place(scene, frame_mesh({width, height}, reveal), room.trim, facing);
  place(scene, rectangle_mesh({-0.5f * width, -0.5f * height, -depth}, {width, 0, 0}, {0, height, 0}),
        room.glass, facing);
  const auto bar = [&](Vec3 at, Vec3 size) {
    place(scene, box_mesh(size, 0.006f, 1), room.trim, facing * move(at));
  };
  const float z = -depth + 0.02f;
  for (int side = -1; side <= 1; side += 2) {
    bar({side * (0.5f * width - 0.025f), 0, z}, {0.05f, height, 0.05f});
    bar({0, side * (0.5f * height - 0.025f), z}, {width, 0.05f, 0.05f});
    bar({side * 0.25f * width, 0.2f * height, z}, {0.5f * width, 0.025f, 0.03f});
  }
  bar({0, 0, z}, {0.07f, height, 0.05f});
  place(scene, box_mesh({0.14f, 0.035f, width + 0.16f}, 0.008f, 2), room.trim,
        move({-0.02f, window_low - 0.016f, centre.z}));
}

void add_door(Bedroom& room) {
  Scene& scene = room.scene;
  const Mat4 at = move({room_size.x, 0, 3.4f}) * turn(-pi / 2, {0, 1, 0});
  place(scene, box_mesh({0.86f, 2.04f, 0.03f}, 0.004f, 1), room.trim, at * move({0, 1.02f, 0.005f}));
  for (const float side : {-1.0f, 1.0f})
    place(scene, box_mesh({0.085f, 2.06f, 0.035f}, 0.012f, 1), room.trim,
          at * move({side * 0.4925f, 1.03f, 0.0165f}));
  place(scene, box_mesh({1.11f, 0.09f, 0.045f}, 0.012f, 1), room.trim, at * move({0, 2.105f, 0.0215f}));
  const std::vector<Vec2> panel{
      {-0.05f, 0.018f}, {-0.045f, 0.028f}, {-0.03f, 0.024f}, {0, 0.03f}, {0.012f, 0.018f}};
  for (const float y : {0.62f, 1.55f})
    for (const float x : {-0.2f, 0.2f})
      place(scene, frame_mesh({0.26f, y < 1 ? 0.75f : 0.62f}, panel), room.trim, at * move({x, y, 0}));
  const std::vector<Vec2> rose{
      {0, 0.03f}, {0.026f, 0.03f}, {0.026f, 0.036f}, {0.01f, 0.04f}, {0.009f, 0.07f}};
  place(scene, lathe_mesh(rose, 20), room.brass, at * move({-0.36f, 1.02f, 0}) * turn(pi / 2, {1, 0, 0}));
  const std::vector<Vec3> lever{{-0.36f, 1.02f, 0.065f}, {-0.33f, 1.022f, 0.07f}, {-0.25f, 1.018f, 0.068f}};
  place(scene, tube_mesh(smooth_curve(lever, 5), 10, 0.009f), room.brass, at);
}

}  // namespace

void add_room(Bedroom& room) {
  add_walls(room);
  add_mouldings(room);
  add_window(room);
  add_door(room);
}

void add_curtains(Bedroom& room) {
  Scene& scene = room.scene;
  const float top = 2.33f, bottom = 0.025f;
  // Each half hangs from its own rings, drawn together more at the top, its folds drifting on the way down.
  const auto half = [&](float from, float to, uint32_t seed) {
    const Mesh cloth = grid_mesh({132, 24}, [&](float u, float v) {
      const float y = bottom + v * (top - bottom), fall = 1 - v;
      const float wander = 0.6f * gradient_noise({3 * u, 1.2f * v, 0}, seed);
      // No two folds are as wide or as deep.
      const float uneven = 0.55f * gradient_noise({4.3f * u, 0, 11}, seed) +
                           0.15f * gradient_noise({11 * u, 0.8f * v, 13}, seed);
      const float phase = 2 * pi * (8 * u + uneven + 0.25f * wander * fall);
      const float depth =
          (0.024f + 0.036f * fall) * (1 + 0.7f * gradient_noise({5.3f * u, 0.7f * v, 3}, seed));
      const float sway = 0.03f * fall * gradient_noise({2.5f * u, 2 * v, 7}, seed);
      const float z = from + (to - from) * (u + 0.014f * std::sin(2 * phase) + 0.02f * wander * fall);
      return Vec3(0.13f + depth * std::sin(phase) + sway, y, z);
    });
    place(scene, cloth, room.curtain);
  };
  half(1.44f, 0.62f, 41);
  half(2.86f, 2.00f, 42);
  const std::vector<Vec3> rod{{0.13f, 2.38f, 0.52f}, {0.13f, 2.38f, 2.96f}};
  place(scene, tube_mesh(rod, 14, 0.014f), room.brass);
  for (const float z : {0.50f, 2.98f})
    place(scene, superquadric_mesh(Vec3(0.032f), {1, 1}, 20, 12), room.brass, move({0.13f, 2.38f, z}));
  for (int i = 0; i < 18; ++i) {
    const float z = i < 9 ? 0.66f + 0.092f * i : 2.05f + 0.095f * (i - 9);
    std::vector<Vec3> ring;
    for (int k = 0; k <= 12; ++k)
      ring.push_back({0.13f + 0.024f * std::sin(pi * k / 6), 2.368f + 0.026f * std::cos(pi * k / 6), z});
    place(scene, tube_mesh(ring, 4, 0.003f), room.brass);
  }
}

void add_rug(Bedroom& room) {
  // Faintly wavy pile with a rounded edge.
  const Vec2 half(1.45f, 1.0f);
  const Mesh pile = grid_mesh({42, 28}, [&](float u, float v) {
    const Vec2 p = (2.0f * Vec2(u, v) - 1.0f);
    const float edge = std::min(1 - std::abs(p.x), 1 - std::abs(p.y));
    const float height =
        0.014f * std::min(1.0f, 14 * edge) + 0.003f * gradient_noise({6 * p.x, 6 * p.y, 0}, 51);
    return Vec3(p.x * half.x, std::max(0.002f, height), -p.y * half.y);
  });
  Mesh turned = pile;
  for (Vertex& vertex : turned.vertices) vertex.uv[0] = vertex.uv[1] = {vertex.uv[0].y, vertex.uv[0].x};
  const Mat4 at = move({bed_centre, 0, 2.62f}) * turn(0.03f, {0, 1, 0});
  place(room.scene, turned, room.rug, at);
  // Fringes at the short ends.
  for (int end = -1; end <= 1; end += 2)
    for (int i = 0; i < 90; ++i) {
      const float z = half.y * (2 * (i + 0.5f) / 90 - 1),
                  bend = 0.012f * gradient_noise({40 * z, 0, 0}, 60 + end);
      const Vec3 root(end * half.x, 0.006f, z);
      Mesh strand = rectangle_mesh(root - Vec3(0, 0, 0.005f), {end * 0.07f, -0.003f, bend}, {0, 0, 0.009f});
      place(room.scene, strand, room.linen, at);
    }
}

}  // namespace halflight
