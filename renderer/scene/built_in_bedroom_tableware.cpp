// The bedroom's small things on tables, desk and bed; glazed and polished, so that their highlights show the
// BRDF.
#include "scene/built_in_bedroom.h"

namespace halflight {

namespace {

void turned(Bedroom& room, std::initializer_list<Vec2> outline, int steps, int segments, uint32_t material,
            const Mat4& at) {
  const std::vector<Vec2> points(outline);
  place(room.scene, lathe_mesh(steps > 1 ? smooth_curve(points, steps) : points, segments), material, at);
}

void bent(Bedroom& room, std::initializer_list<Vec3> path, int sides, float from, float to, uint32_t material,
          const Mat4& at) {
  const auto radius = [=](float t) { return from + t * (to - from); };
  place(room.scene, tube_mesh(smooth_curve(std::vector<Vec3>(path), 5), sides, radius), material, at);
}

void add_cup(Bedroom& room, uint32_t glaze, const Mat4& at) {
  turned(room,
         {{0, 0.004f},
          {0.022f, 0.002f},
          {0.034f, 0.012f},
          {0.041f, 0.04f},
          {0.044f, 0.07f},
          {0.042f, 0.071f},
          {0.038f, 0.04f},
          {0.03f, 0.014f},
          {0, 0.01f}},
         3, 28, glaze, at);
  bent(room, {{0.040f, 0.058f, 0}, {0.062f, 0.058f, 0}, {0.066f, 0.035f, 0}, {0.038f, 0.022f, 0}}, 8, 0.0045f,
       0.004f, glaze, at);
}

void add_teapot(Bedroom& room, const Mat4& at) {
  const uint32_t glaze = room.ceramic_blue;
  turned(room,
         {{0, 0.003f},
          {0.045f, 0.003f},
          {0.05f, 0.008f},
          {0.082f, 0.045f},
          {0.084f, 0.08f},
          {0.06f, 0.118f},
          {0.038f, 0.128f}},
         3, 30, glaze, at);
  turned(room,
         {{0.040f, 0.127f},
          {0.042f, 0.131f},
          {0.030f, 0.140f},
          {0.010f, 0.147f},
          {0.007f, 0.153f},
          {0.012f, 0.162f},
          {0.008f, 0.170f},
          {0, 0.171f}},
         2, 28, glaze, at);
  bent(room, {{0.07f, 0.05f, 0}, {0.105f, 0.065f, 0}, {0.12f, 0.10f, 0}, {0.14f, 0.125f, 0}}, 12, 0.018f,
       0.009f, glaze, at);
  bent(room,
       {{-0.072f, 0.098f, 0},
        {-0.11f, 0.112f, 0},
        {-0.128f, 0.085f, 0},
        {-0.112f, 0.05f, 0},
        {-0.078f, 0.042f, 0}},
       10, 0.007f, 0.007f, glaze, at);
}

void add_tray(Bedroom& room, const Mat4& at) {
  const float width = 0.44f, depth = 0.30f;
  place(room.scene, box_mesh({width, 0.010f, depth}, 0.003f, 1), room.dark_wood, at * move({0, 0.005f, 0}));
  for (const float side : {-1.0f, 1.0f}) {
    place(room.scene, box_mesh({width, 0.035f, 0.010f}, 0.003f, 1), room.dark_wood,
          at * move({0, 0.018f, side * 0.5f * depth}));
    place(room.scene, box_mesh({0.010f, 0.045f, depth}, 0.003f, 1), room.dark_wood,
          at * move({side * 0.5f * width, 0.022f, 0}));
  }
  add_teapot(room, at * move({-0.08f, 0.010f, 0.01f}) * turn(0.5f, {0, 1, 0}));
  for (const Vec3 cup : {Vec3(0.11f, 0.010f, 0.065f), Vec3(0.10f, 0.010f, -0.07f)}) {
    turned(room,
           {{0, 0},
            {0.03f, 0},
            {0.055f, 0.008f},
            {0.065f, 0.014f},
            {0.063f, 0.015f},
            {0.03f, 0.006f},
            {0, 0.005f}},
           2, 28, room.ceramic_white, at * move(cup));
    add_cup(room, room.ceramic_white, at * move(cup + Vec3(0, 0.004f, 0)) * turn(cup.z * 20, {0, 1, 0}));
  }
}

/// A bottle vase with bare branches and a few leaves.
void add_vase(Bedroom& room, uint32_t glaze, float scale, const Mat4& at) {
  const Mat4 here = at * stretch(Vec3(scale));
  turned(room,
         {{0, 0.002f},
          {0.05f, 0},
          {0.075f, 0.03f},
          {0.085f, 0.075f},
          {0.07f, 0.125f},
          {0.032f, 0.165f},
          {0.024f, 0.20f},
          {0.032f, 0.225f},
          {0.028f, 0.225f},
          {0.018f, 0.19f},
          {0.018f, 0.16f}},
         3, 30, glaze, here);
  for (int i = 0; i < 5; ++i) {
    const float phi = 2.4f * i, lean = 0.10f + 0.03f * i, height = 0.52f - 0.04f * i;
    const Vec3 out(std::cos(phi), 0, std::sin(phi));
    const std::vector<Vec3> stem{{0, 0.15f, 0},
                                 out * (0.25f * lean) + Vec3(0, 0.25f, 0),
                                 out * (0.6f * lean) + Vec3(0.01f, 0.38f, 0),
                                 out * (1.3f * lean) + Vec3(0, height, 0.01f)};
    const std::vector<Vec3> curve = smooth_curve(stem, 5);
    place(room.scene, tube_mesh(curve, 5, [](float t) { return 0.0025f - 0.0015f * t; }), room.dark_wood,
          here);
    // Round leaves in pairs along the upper half, each a bent oval.
    for (size_t k = 6; k < curve.size(); ++k) {
      const Mesh leaf = grid_mesh({2, 5}, [](float u, float v) {
        const float x = 2 * u - 1, wide = 0.017f * std::sin(pi * (0.04f + 0.96f * v));
        return Vec3(x * wide, 0.012f * v * v + 0.15f * wide * x * x, 0.004f + 0.05f * v);
      });
      const float side = k % 2 == 0 ? 0 : pi;
      place(room.scene, leaf, room.leaf,
            here * move(curve[k]) * turn(phi + side + 0.5f * k, {0, 1, 0}) * turn(-0.5f, {1, 0, 0}));
    }
  }
}

void add_clock(Bedroom& room, const Mat4& at) {
  const Mat4 face = at * move({0, 0.055f, 0}) * turn(pi / 2, {1, 0, 0});
  turned(room,
         {{0, -0.02f},
          {0.043f, -0.02f},
          {0.047f, -0.012f},
          {0.047f, 0.016f},
          {0.044f, 0.021f},
          {0.041f, 0.018f}},
         1, 40, room.brass, face);
  turned(room, {{0.041f, 0.016f}, {0, 0.016f}}, 1, 40, room.ceramic_white, face);
  const auto hand = [&](float angle, float length) {
    place(room.scene, box_mesh({0.003f, length, 0.001f}), room.black,
          at * move({0, 0.055f, 0.0175f}) * turn(angle, {0, 0, 1}) * move({0, 0.4f * length, 0}));
  };
  hand(0.9f, 0.030f);
  hand(-1.4f, 0.022f);
  for (const float x : {-0.026f, 0.026f})
    bent(room, {{x, 0.016f, 0}, {1.2f * x, 0.008f, 0}, {1.4f * x, 0, 0}}, 8, 0.005f, 0.004f, room.brass, at);
}

/// An open laptop, its screen dark.
void add_laptop(Bedroom& room, const Mat4& at) {
  place(room.scene, box_mesh({0.32f, 0.014f, 0.22f}, 0.005f, 2), room.steel, at * move({0, 0.007f, 0}));
  place(room.scene, box_mesh({0.27f, 0.002f, 0.10f}), room.black, at * move({0, 0.0145f, -0.03f}));
  const Mat4 lid = at * move({0, 0.014f, -0.108f}) * turn(-0.35f, {1, 0, 0});
  place(room.scene, box_mesh({0.32f, 0.21f, 0.007f}, 0.003f, 2), room.steel, lid * move({0, 0.105f, 0}));
  place(room.scene, rectangle_mesh({-0.15f, 0.008f, 0.0040f}, {0.30f, 0, 0}, {0, 0.19f, 0}), room.glass, lid);
}

void add_pencils(Bedroom& room, const Mat4& at) {
  turned(
      room,
      {{0, 0}, {0.036f, 0}, {0.038f, 0.002f}, {0.038f, 0.10f}, {0.035f, 0.10f}, {0.035f, 0.01f}, {0, 0.008f}},
      1, 28, room.brass, at);
  for (int i = 0; i < 6; ++i) {
    const float phi = 1.1f * i, lean = 0.02f + 0.004f * i;
    const Vec3 low(-0.5f * lean * std::cos(phi), 0.01f, -0.5f * lean * std::sin(phi)),
        high(lean * std::cos(phi), 0.165f + 0.008f * (i % 3), lean * std::sin(phi));
    place(room.scene, tube_mesh(std::vector<Vec3>{low, high}, 6, 0.0036f), i % 2 ? room.cushion : room.black,
          at);
  }
}

}  // namespace

void add_tableware(Bedroom& room) {
  const Mat4 left = move({bed_centre - 1.28f, 0.56f, 0.27f}),
             right = move({bed_centre + 1.28f, 0.56f, 0.27f});
  const Mat4 lying = turn(pi / 2, {0, 0, 1});
  add_books(room, 4, left * move({0.16f, 0.001f, 0.10f}) * turn(0.25f, {0, 1, 0}) * lying, 11);
  turned(room,
         {{0, 0.002f},
          {0.045f, 0},
          {0.055f, 0.02f},
          {0.056f, 0.07f},
          {0.045f, 0.12f},
          {0.022f, 0.16f},
          {0.020f, 0.19f},
          {0.028f, 0.215f}},
         3, 28, room.ceramic_blue, left * move({-0.14f, 0, 0.02f}));
  add_vase(room, room.ceramic_white, 1, right * move({0.10f, 0, -0.04f}));
  add_clock(room, right * move({-0.13f, 0, 0.08f}) * turn(0.45f, {0, 1, 0}));
  add_books(room, 5, right * move({-0.19f, -0.351f, 0.12f}), 17);
  add_books(room, 3, left * move({0.16f, -0.351f, 0.12f}) * lying, 29);

  const Mat4 desk = move({0.50f, 0.745f, 1.75f}) * turn(pi / 2, {0, 1, 0});
  add_books(room, 7, desk * move({-0.60f, 0, -0.06f}), 23);
  add_laptop(room, desk * move({-0.02f, 0, 0.0f}) * turn(0.15f, {0, 1, 0}));
  add_pencils(room, desk * move({0.34f, 0, -0.12f}));
  add_cup(room, room.ceramic_white, desk * move({0.30f, 0, 0.10f}));
  add_vase(room, room.terracotta, 0.9f, desk * move({0.53f, 0, -0.10f}));
  add_tray(room, move({bed_centre + 0.34f, 0.665f, 1.40f}) * turn(0.35f, {0, 1, 0}));
}

}  // namespace halflight
