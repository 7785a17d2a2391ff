// The bedroom's bed: frame, headboard, mattress, pillows and the cloth over them.
#include <array>

#include "scene/built_in_bedroom.h"

namespace halflight {

namespace {

constexpr float half_width = 0.86f, head = 0.17f, foot = 2.22f;  // of the mattress; z from the wall
constexpr float cloth_top = 0.63f;

/// A point of a cloth that lies over the mattress and hangs down at its sides and foot.
struct Draped {
  Vec3 position, normal;
  float hanging;  ///< length of cloth beyond the edge
  float around;   ///< length along the edge, over the corners too
};

/// `s` across from the middle, `t` from the wall, both measured in the cloth; the bend at the edge has radius
/// `bend`.
Draped drape(float s, float t, float height, float bend) {
  const Vec2 core(half_width - 0.02f, foot - 0.02f);
  const Vec2 flat(glm::clamp(s, -core.x, core.x), std::min(t, core.y));
  const Vec2 over = Vec2(s, t) - flat;
  const float length = glm::length(over);
  if (length < 1e-6f) return {{flat.x, height, flat.y}, {0, 1, 0}, 0, s};
  const Vec2 out = over / length;
  const float angle = std::min(length / bend, pi / 2), rest = std::max(0.0f, length - bend * pi / 2);
  const Vec2 plan = flat + out * (bend * std::sin(angle));
  const Vec3 normal(out.x * std::sin(angle), std::cos(angle), out.y * std::sin(angle));
  const float corner = std::atan2(out.y, std::abs(out.x)) / (pi / 2);
  return {{plan.x, height - bend * (1 - std::cos(angle)) - rest, plan.y},
          normal,
          length,
          s < 0 ? -(flat.y + 0.5f * corner) + flat.x : flat.y + 0.5f * corner + flat.x};
}

/// Height of the duvet's surface above its drape: down filling, creases, and folds where it hangs.
float duvet_relief(float s, float t, const Draped& at) {
  const Vec2 warp(0.25f * gradient_noise({2 * s, 2 * t, 1}, 71),
                  0.25f * gradient_noise({2 * s, 2 * t, 5}, 72));
  const float soft = gradient_noise({2.1f * (s + warp.x), 2.1f * (t + warp.y), 0}, 73);
  const auto crease = [&](float scale, float slant, uint32_t seed) {
    const float n =
        gradient_noise({scale * (s + slant * t + warp.x), 0.45f * scale * (t - slant * s + warp.y), 0}, seed);
    const float ridge = 1 - std::min(1.0f, 2.2f * std::abs(n));
    return ridge * ridge;
  };
  const float flat = 1 - glm::smoothstep(0.0f, 0.12f, at.hanging);
  float relief = 0.026f * soft + 0.020f * crease(2.7f, 0.5f, 74) + 0.020f * crease(3.3f, -0.6f, 75) +
                 0.008f * crease(7, 0.2f, 76);
  relief *= 0.45f + 0.55f * flat;
  const float fold =
      std::sin(2 * pi * (at.around / 0.27f + 0.5f * gradient_noise({3 * at.around, 0, 0}, 77)));
  return relief + 0.026f * fold * glm::smoothstep(0.03f, 0.3f, at.hanging);
}

Vec3 on_duvet(float s, float t, float lift) {
  const Draped at = drape(s, t, cloth_top, 0.075f);
  // Cloth parts from the bed a little as it falls.
  const float flare = 0.10f * std::max(0.0f, at.hanging - 0.1f);
  const Vec3 p = at.position + at.normal * (duvet_relief(s, t, at) + lift + flare);
  return {p.x + bed_centre, p.y, p.z};
}

/// 0 at both ends of [0, 1], 1 between: the thickness of a hemmed cloth.
float hem(float v, float sharpness) { return 1 - std::pow(std::abs(2 * v - 1), sharpness); }

void add_duvet(Bedroom& room) {
  const float side = 1.16f, top = 0.80f, bottom = foot + 0.34f;
  place(room.scene,
        grid_mesh({90, 70},
                  [&](float u, float v) {
                    const float s = side * (2 * u - 1), t = bottom + v * (top - bottom);
                    const float edge = 0.03f * (hem(u, 40) * hem(v, 30) - 1);
                    return on_duvet(s, t, edge);
                  }),
        room.duvet);
  // Turned back at the top, showing the sheet.
  place(room.scene,
        grid_mesh({96, 14},
                  [&](float u, float v) {
                    const float s = (side + 0.005f) * (2 * u - 1);
                    const float t = 1.14f + v * (0.77f - 1.14f) + 0.018f * gradient_noise({3 * u, 0, v}, 81);
                    return on_duvet(s, t, -0.02f + 0.055f * hem(v, 7) * hem(u, 40));
                  }),
        room.linen);
}

void add_throw(Bedroom& room) {
  const float side = 1.06f;
  const auto cloth = [&](float u, float v) {
    const float s = side * (2 * u - 1);
    const float t = 2.10f - 0.52f * v + 0.05f * s + 0.02f * gradient_noise({4 * u, 2 * v, 0}, 91);
    const float rib = 0.003f * std::sin(2 * pi * 11 * v);
    return on_duvet(s, t, -0.008f + 0.026f * hem(v, 12) + rib);
  };
  place(room.scene, grid_mesh({80, 44}, cloth), room.throw_wool);
  for (int end = 0; end < 2; ++end)
    for (int i = 0; i < 34; ++i) {
      const float v = (i + 0.5f) / 34;
      const Vec3 root = cloth(static_cast<float>(end), v);
      const float swing = 0.012f * gradient_noise({9 * v, 0, 0}, 92 + end);
      const std::vector<Vec3> strand{root, root + Vec3(0.004f, -0.03f, swing * 0.4f),
                                     root + Vec3(0.002f, -0.075f, swing)};
      place(room.scene, tube_mesh(strand, 4, [](float t) { return 0.0045f - 0.002f * t; }), room.throw_wool);
    }
}

/// A filled cushion in the xy plane, front to +z: seams on the outline, ears at the corners, creases from
/// them.
Mesh pillow_mesh(Vec2 half, float thickness, int cells, uint32_t seed) {
  Mesh pillow;
  for (int side = -1; side <= 1; side += 2)
    append(pillow, grid_mesh({cells, cells}, [&](float u, float v) {
             const Vec2 p(side * (2 * u - 1), 2 * v - 1), q = p * p;
             const Vec2 outline = half * p * (1.0f - Vec2(0.09f * q.x * (1 - q.y), 0.09f * q.y * (1 - q.x)));
             const float body = std::pow(std::max(0.0f, (1 - q.x) * (1 - q.y)), 0.42f);
             const float crease = gradient_noise({2.5f * p.x, 2.5f * p.y, 2.0f * side}, seed) +
                                  0.4f * gradient_noise({6 * p.x, 6 * p.y, 2.0f * side}, seed + 1);
             const float z = body * thickness * (1 + 0.16f * crease);
             return Vec3(outline, side * z);
           }));
  smooth_normals(pillow, 1.5f);
  return pillow;
}

void add_pillows(Bedroom& room) {
  struct Cushion {
    Vec3 at;
    Vec2 half;
    float thickness, lean, roll, yaw;
    uint32_t material;
  };
  const std::array<Cushion, 7> cushions{{
      {{-0.42f, 0.86f, 0.25f}, {0.37f, 0.27f}, 0.095f, -0.30f, 0.03f, 0.03f, room.linen},
      {{0.42f, 0.86f, 0.25f}, {0.37f, 0.27f}, 0.095f, -0.30f, -0.04f, -0.04f, room.linen},
      {{-0.44f, 0.82f, 0.43f}, {0.35f, 0.24f}, 0.09f, -0.55f, -0.05f, 0.06f, room.duvet},
      {{0.45f, 0.82f, 0.43f}, {0.35f, 0.24f}, 0.09f, -0.55f, 0.04f, -0.05f, room.duvet},
      {{-0.30f, 0.80f, 0.60f}, {0.23f, 0.22f}, 0.08f, -0.62f, 0.10f, 0.15f, room.upholstery},
      {{0.33f, 0.80f, 0.60f}, {0.23f, 0.22f}, 0.08f, -0.62f, -0.08f, -0.12f, room.upholstery},
      {{0.03f, 0.765f, 0.73f}, {0.28f, 0.145f}, 0.075f, -0.75f, 0.03f, 0.02f, room.cushion},
  }};
  uint32_t seed = 100;
  for (const Cushion& c : cushions)
    place(room.scene, pillow_mesh(c.half, c.thickness, 19, seed += 10), c.material,
          move(c.at + Vec3(bed_centre, 0, 0)) * turn(c.yaw, {0, 1, 0}) * turn(c.lean, {1, 0, 0}) *
              turn(c.roll, {0, 0, 1}));
}

void add_headboard(Bedroom& room) {
  const float width = 1.96f, low = 0.18f, high = 1.22f, thickness = 0.055f;
  const int channels = 11;
  // Upright channels, each a soft half round, drawn in at the seams and rolled over at the top.
  const Mesh front = grid_mesh({channels * 10, 22}, [&](float u, float v) {
    const float across = std::abs(std::sin(pi * channels * u)), ends = std::pow(std::abs(2 * u - 1), 24.0f);
    const float top = std::pow(v, 10.0f), bulge = 0.035f * std::sqrt(across) * (1 - 0.8f * top);
    const float z =
        thickness * std::sqrt(std::max(0.0f, 1 - top * top)) * (1 - 0.5f * ends) + bulge * (1 - top);
    return Vec3(bed_centre + width * (u - 0.5f), low + (high - low) * v, 0.03f + z);
  });
  place(room.scene, front, room.upholstery);
  place(room.scene, box_mesh({width, high - low, 0.045f}, 0.01f, 2), room.dark_wood,
        move({bed_centre, 0.5f * (low + high), 0.025f}));
}

}  // namespace

void add_bed(Bedroom& room) {
  Scene& scene = room.scene;
  const float middle = 0.5f * (head + foot), length = foot - head;
  place(scene, box_mesh({2 * half_width + 0.04f, 0.16f, length + 0.04f}, 0.03f, 3), room.upholstery,
        move({bed_centre, 0.22f, middle}));
  place(scene, box_mesh({2 * half_width, 0.27f, length}, 0.06f, 4), room.linen,
        move({bed_centre, 0.435f, middle}));
  for (const float x : {-0.78f, 0.78f})
    for (const float z : {head + 0.08f, foot - 0.08f})
      place(scene, lathe_mesh(std::vector<Vec2>{{0.018f, 0}, {0.030f, 0.15f}}, 16), room.dark_wood,
            move({bed_centre + x, 0, z}));
  add_headboard(room);
  add_duvet(room);
  add_throw(room);
  add_pillows(room);
}

}  // namespace halflight
