// The bedroom's furniture beside the bed.
#include "core/random.h"
#include "scene/built_in_bedroom.h"
#include "scene/built_in_textures.h"

namespace halflight {

namespace {

void add_box(Bedroom& room, uint32_t material, Vec3 size, Vec3 centre, const Mat4& at = Mat4(1),
             float radius = 0.004f) {
  place(room.scene, box_mesh(size, radius, 1), material, at * move(centre));
}

/// A turned knob on a face towards +z.
void add_knob(Bedroom& room, Vec3 centre, const Mat4& at) {
  const std::vector<Vec2> outline{{0.005f, 0},      {0.005f, 0.012f}, {0.013f, 0.018f},
                                  {0.014f, 0.024f}, {0.009f, 0.029f}, {0, 0.03f}};
  place(room.scene, lathe_mesh(outline, 16), room.brass, at * move(centre) * turn(pi / 2, {1, 0, 0}));
}

void add_bedside_table(Bedroom& room, Vec3 at) {
  const Mat4 here = move(at);
  const float width = 0.50f, depth = 0.40f, top = 0.56f;
  add_box(room, room.dark_wood, {width, 0.022f, depth}, {0, top - 0.011f, 0}, here, 0.006f);
  add_box(room, room.dark_wood, {width - 0.02f, 0.018f, depth - 0.02f}, {0, 0.20f, 0}, here);
  for (const float x : {-1.0f, 1.0f})
    add_box(room, room.dark_wood, {0.018f, 0.37f, depth - 0.02f}, {x * (0.5f * width - 0.014f), 0.365f, 0},
            here);
  add_box(room, room.dark_wood, {width - 0.03f, 0.36f, 0.012f}, {0, 0.37f, -0.5f * depth + 0.02f}, here);
  add_box(room, room.dark_wood, {width - 0.044f, 0.145f, 0.02f}, {0, 0.466f, 0.5f * depth - 0.02f}, here,
          0.005f);
  add_box(room, room.dark_wood, {width - 0.044f, 0.012f, depth - 0.05f}, {0, 0.386f, 0}, here);
  add_knob(room, {0, 0.466f, 0.5f * depth - 0.01f}, here);
  for (const float x : {-1.0f, 1.0f})
    for (const float z : {-1.0f, 1.0f}) {
      const Vec3 foot(x * (0.5f * width - 0.025f), 0, z * (0.5f * depth - 0.03f)),
          up(x * (0.5f * width - 0.05f), 0.195f, z * (0.5f * depth - 0.05f));
      place(room.scene,
            tube_mesh(std::vector<Vec3>{foot, up}, 12, [](float t) { return 0.010f + 0.008f * t; }),
            room.brass, here);
    }
}

}  // namespace

float add_books(Bedroom& room, int count, const Mat4& transform, uint32_t seed) {
  RandomStream random(seed, 0, 7);
  float along = 0;
  for (int i = 0; i < count; ++i) {
    const float thick = 0.018f + 0.024f * random.next(), high = 0.19f + 0.07f * random.next(),
                deep = 0.13f + 0.035f * random.next();
    const uint32_t cover = room.book_covers[static_cast<size_t>(random.next() * 8)];
    const Mat4 at = transform * move({along + 0.5f * thick, 0, 0});
    const float z = -0.5f * deep;
    add_box(room, room.paper, {thick - 0.006f, high - 0.008f, deep - 0.006f}, {0, 0.5f * high, z - 0.003f},
            at, 0);
    for (const float side : {-1.0f, 1.0f})
      add_box(room, cover, {0.003f, high, deep}, {side * (0.5f * thick - 0.0015f), 0.5f * high, z}, at, 0);
    // The back is a little rounded.
    const Mesh back = grid_mesh({6, 1}, [&](float u, float v) {
      const float phi = pi * u;
      return Vec3(-0.5f * thick * std::cos(phi), high * v, 0.005f * std::sin(phi));
    });
    place(room.scene, back, cover, at);
    along += thick + 0.001f;
  }
  return along;
}

void add_bedside(Bedroom& room) {
  const Vec3 left(bed_centre - 1.28f, 0, 0.27f), right(bed_centre + 1.28f, 0, 0.27f);
  add_bedside_table(room, left);
  add_bedside_table(room, right);
}

void add_lamp(Bedroom& room) {
  Scene& scene = room.scene;
  const Mat4 at = move({lamp_position.x, 0, lamp_position.z});
  const std::vector<Vec2> foot{{0, 0},          {0.155f, 0},     {0.16f, 0.006f}, {0.155f, 0.018f},
                               {0.10f, 0.028f}, {0.03f, 0.036f}, {0.016f, 0.06f}, {0.0125f, 0.09f}};
  place(scene, lathe_mesh(foot, 48), room.enamel, at);
  const float rim = lamp_position.y;
  place(scene, tube_mesh(std::vector<Vec3>{{0, 0.08f, 0}, {0, rim - 0.165f, 0}}, 20, 0.0115f), room.enamel,
        at);
  // An opaque bowl, open at the top; the light stands at its rim, so that nothing below the rim is lit
  // directly.
  const std::vector<Vec2> outside{{0.0115f, rim - 0.187f}, {0.03f, rim - 0.172f},  {0.07f, rim - 0.152f},
                                  {0.125f, rim - 0.102f},  {0.165f, rim - 0.047f}, {0.185f, rim - 0.004f}};
  std::vector<Vec2> bowl = smooth_curve(outside, 3);
  bowl.push_back({0.187f, rim});
  bowl.push_back({0.184f, rim});
  for (int i = static_cast<int>(bowl.size()) - 4; i >= 3; --i)
    bowl.push_back(bowl[i] - Vec2(0.003f, -0.003f));
  bowl.push_back({0, rim - 0.172f});
  place(scene, lathe_mesh(bowl, 48), room.enamel, at);

  PunctualLight light;
  light.name = "uplighter";
  light.kind = PunctualKind::spot;
  light.position = lamp_position;
  // Tilted away from the corner, its lower edge level: the far walls get their share, nothing shines into the
  // bowl.
  const float tilt = glm::radians(20.0f);
  const Vec2 away = glm::normalize(Vec2(0.77f, 0.64f)) * std::sin(tilt);
  light.direction = {away.x, std::cos(tilt), away.y};
  light.up = basis_along(light.direction, {0, 0, -1}).tangent;
  light.intensity = 27.0f * Vec3(1.0f, 0.84f, 0.66f);
  light.inner_cone = glm::radians(46.0f), light.outer_cone = pi / 2 - tilt;
  scene.lights.push_back(light);
}

void add_wardrobe(Bedroom& room) {
  const float width = 0.98f, height = 2.12f, depth = 0.58f;
  const Mat4 at = move({room_size.x - 0.03f - 0.5f * width, 0, 0.02f});
  add_box(room, room.light_wood, {width, height - 0.08f, depth - 0.022f},
          {0, 0.5f * height + 0.04f, 0.5f * depth - 0.011f}, at);
  add_box(room, room.light_wood, {width - 0.04f, 0.08f, depth - 0.06f}, {0, 0.04f, 0.5f * depth - 0.03f}, at);
  add_box(room, room.light_wood, {width + 0.05f, 0.035f, depth + 0.045f}, {0, height + 0.018f, 0.5f * depth},
          at, 0.01f);
  const float door = 0.5f * width - 0.006f;
  for (const float side : {-1.0f, 1.0f}) {
    const Mat4 leaf = at * move({side * 0.25f * width, 0.5f * height + 0.04f, depth});
    add_box(room, room.light_wood, {door, height - 0.09f, 0.018f}, {0, 0, -0.009f}, leaf);
    const std::vector<Vec2> stile{{0, 0}, {0.004f, 0.010f}, {0.010f, 0.013f}, {0.07f, 0.013f}, {0.072f, 0}};
    place(room.scene, frame_mesh({door - 0.15f, height - 0.24f}, stile), room.light_wood, leaf);
    add_box(room, room.light_wood, {door - 0.14f, 0.07f, 0.013f}, {0, -0.28f, 0.0065f}, leaf, 0.003f);
    const std::vector<Vec3> grip{{-side * (0.5f * door - 0.036f), -0.10f, 0.012f},
                                 {-side * (0.5f * door - 0.036f), -0.098f, 0.04f},
                                 {-side * (0.5f * door - 0.036f), 0.098f, 0.04f},
                                 {-side * (0.5f * door - 0.036f), 0.10f, 0.012f}};
    place(room.scene, tube_mesh(smooth_curve(grip, 4), 10, 0.006f), room.brass, leaf);
  }
}

namespace {

void add_chair(Bedroom& room, const Mat4& at) {
  const auto leg = [&](Vec3 foot, Vec3 up, float r) {
    place(room.scene,
          tube_mesh(std::vector<Vec3>{foot, up}, 10, [r](float t) { return r * (0.65f + 0.35f * t); }),
          room.light_wood, at);
  };
  for (const float x : {-1.0f, 1.0f}) {
    leg({x * 0.22f, 0, 0.21f}, {x * 0.185f, 0.44f, 0.17f}, 0.018f);
    const std::vector<Vec3> back{{x * 0.215f, 0, -0.24f},
                                 {x * 0.19f, 0.44f, -0.185f},
                                 {x * 0.195f, 0.66f, -0.205f},
                                 {x * 0.20f, 0.84f, -0.26f}};
    place(room.scene, tube_mesh(smooth_curve(back, 5), 10, 0.0165f), room.light_wood, at);
    add_box(room, room.light_wood, {0.02f, 0.025f, 0.36f}, {x * 0.2f, 0.30f, -0.01f}, at);
  }
  add_box(room, room.light_wood, {0.40f, 0.03f, 0.022f}, {0, 0.415f, 0.17f}, at);
  add_box(room, room.light_wood, {0.40f, 0.03f, 0.022f}, {0, 0.415f, -0.18f}, at);
  place(room.scene, superquadric_mesh({0.225f, 0.04f, 0.215f}, {0.45f, 0.45f}, 36, 14), room.upholstery,
        at * move({0, 0.455f, 0}));
  // The bent back rest.
  const Mesh rest = grid_mesh({16, 8, false, true}, [](float u, float v) {
    const float x = 0.215f * (2 * u - 1), bow = 0.05f * (1 - square(2 * u - 1)), phi = 2 * pi * v;
    return Vec3(x, 0.76f + 0.085f * std::sin(phi),
                -0.235f - bow + 0.010f * std::cos(phi) - 0.03f * std::sin(phi));
  });
  place(room.scene, rest, room.light_wood, at);
}

}  // namespace

void add_desk(Bedroom& room) {
  const Mat4 at = move({0.50f, 0, 1.75f}) * turn(pi / 2, {0, 1, 0});
  const float width = 1.30f, depth = 0.56f, top = 0.745f;
  add_box(room, room.light_wood, {width, 0.028f, depth}, {0, top - 0.014f, 0}, at, 0.008f);
  add_box(room, room.light_wood, {width - 0.10f, 0.09f, depth - 0.10f}, {0, top - 0.073f, 0}, at);
  for (const float x : {-0.28f, 0.28f}) {
    add_box(room, room.light_wood, {0.52f, 0.07f, 0.016f}, {x, top - 0.073f, 0.5f * depth - 0.045f}, at);
    add_knob(room, {x, top - 0.073f, 0.5f * depth - 0.038f}, at);
  }
  for (const float x : {-1.0f, 1.0f})
    for (const float z : {-1.0f, 1.0f}) {
      const Vec3 foot(x * (0.5f * width - 0.05f), 0, z * (0.5f * depth - 0.05f)),
          up(x * (0.5f * width - 0.08f), top - 0.03f, z * (0.5f * depth - 0.08f));
      place(room.scene,
            tube_mesh(std::vector<Vec3>{foot, up}, 14, [](float t) { return 0.014f + 0.012f * t; }),
            room.light_wood, at);
    }
  add_chair(room, move({1.08f, 0, 1.78f}) * turn(-pi / 2 + 0.35f, {0, 1, 0}));
}

void add_bookcase(Bedroom& room) {
  const float width = 1.5f, height = 1.85f, depth = 0.28f, board = 0.022f;
  const int shelves = 5;
  const Mat4 at = move({2.3f, 0, room_size.z - 0.02f}) * turn(pi, {0, 1, 0});
  for (const float side : {-1.0f, 1.0f})
    add_box(room, room.light_wood, {board, height, depth},
            {side * 0.5f * (width - board), 0.5f * height, 0.5f * depth}, at);
  add_box(room, room.light_wood, {width - board, height - 0.06f, 0.008f}, {0, 0.5f * height, 0.006f}, at, 0);
  for (int i = 0; i <= shelves; ++i) {
    const float y = 0.07f + (height - 0.07f - 0.5f * board) * static_cast<float>(i) / shelves;
    add_box(room, room.light_wood, {width - 2 * board, board, depth - 0.01f}, {0, y, 0.5f * depth}, at);
    if (i == shelves) break;
    // Books from the left or the right end, the rest of the shelf free.
    const float start = i % 2 == 0 ? -0.5f * width + board + 0.01f : -0.12f;
    add_books(room, i == 2 ? 8 : 13 + i % 3, at * move({start, y + 0.5f * board, 0.24f}),
              40 + static_cast<uint32_t>(i));
  }
}

}  // namespace halflight
