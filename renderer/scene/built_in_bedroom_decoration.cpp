// The bedroom's small things: pictures, plants, vases.
#include "scene/built_in_bedroom.h"
#include "scene/built_in_textures.h"

namespace halflight {

namespace {

/// A framed picture facing +z about the origin.
void add_picture(Bedroom& room, const ImageRgba8& image, const char* name, Vec2 size, uint32_t frame,
                 const Mat4& at) {
  Material art = plain_material(name, Vec3(1), 0.8f);
  art.base_color_texture = add_texture(room.scene, image, name, size);
  art.base_color_texture.row_v = {0, -1 / size.y, 0};
  const uint32_t material = add_material(room.scene, art);
  const float mat = 0.05f;
  place(room.scene, rectangle_mesh(Vec3(-0.5f * size, 0.010f), {size.x, 0, 0}, {0, size.y, 0}), material, at);
  const std::vector<Vec2> mount{{0, 0.0105f}, {0.002f, 0.013f}, {mat, 0.013f}};
  place(room.scene, frame_mesh(size, mount), room.paper, at);
  const std::vector<Vec2> moulding{{mat, 0.012f},          {mat + 0.001f, 0.022f}, {mat + 0.006f, 0.026f},
                                   {mat + 0.018f, 0.024f}, {mat + 0.022f, 0.018f}, {mat + 0.022f, 0}};
  place(room.scene, frame_mesh(size, moulding), frame, at);
}

void add_pictures(Bedroom& room) {
  const ImageRgba8 hills =
      landscape_texture(256, {0.35f, 0.48f, 0.52f}, {0.05f, 0.12f, 0.13f}, {0.80f, 0.35f, 0.13f}, 61);
  const ImageRgba8 dunes =
      landscape_texture(256, {0.62f, 0.52f, 0.40f}, {0.33f, 0.12f, 0.06f}, {0.75f, 0.66f, 0.5f}, 67);
  const ImageRgba8 fern = botanical_texture(256, {0.74f, 0.69f, 0.58f}, {0.09f, 0.19f, 0.10f}, 71);
  add_picture(room, hills, "hills", {0.62f, 0.46f}, room.brass, move({bed_centre - 0.40f, 1.74f, 0}));
  add_picture(room, fern, "fern", {0.34f, 0.46f}, room.brass, move({bed_centre + 0.33f, 1.74f, 0}));
  add_picture(room, dunes, "dunes", {0.7f, 0.5f}, room.black,
              move({room_size.x, 1.5f, 2.3f}) * turn(-pi / 2, {0, 1, 0}));
}

/// Upright blades, each a strip with a channel, bent outwards.
void add_plant(Bedroom& room, Vec3 at) {
  const std::vector<Vec2> pot{{0, 0},          {0.12f, 0},      {0.125f, 0.01f}, {0.165f, 0.30f},
                              {0.172f, 0.32f}, {0.160f, 0.32f}, {0.150f, 0.27f}, {0, 0.27f}};
  place(room.scene, lathe_mesh(pot, 40), room.terracotta, move(at));
  for (int i = 0; i < 22; ++i) {
    const float turnaround = 2.4f * i, reach = 0.10f + 0.5f * (i % 7) / 7,
                height = 0.55f + 0.45f * ((i * 5) % 11) / 11.0f;
    const float wide = 0.04f + 0.016f * (i % 3);
    const Mesh blade = grid_mesh({4, 16}, [&](float u, float v) {
      const float x = 2 * u - 1, width = wide * std::sin(pi * (0.10f + 0.90f * v)) * (1 - 0.15f * v);
      const float out = 0.04f + reach * v * v, up = 0.26f + height * (v - 0.35f * reach * v * v * v);
      return Vec3(x * width, up + 0.25f * width * x * x,
                  out - 0.5f * width * x * x + 0.01f * std::sin(9 * v + i));
    });
    place(room.scene, blade, room.leaf, move(at) * turn(turnaround, {0, 1, 0}));
  }
}

}  // namespace

void add_decoration(Bedroom& room) {
  add_pictures(room);
  add_plant(room, {0.42f, 0, 2.74f});
  // Boxes on top of the wardrobe.
  place(room.scene, box_mesh({0.44f, 0.20f, 0.34f}, 0.008f, 1), room.upholstery,
        move({4.25f, 2.255f, 0.36f}) * turn(0.1f, {0, 1, 0}));
  place(room.scene, box_mesh({0.36f, 0.15f, 0.30f}, 0.008f, 1), room.linen,
        move({4.72f, 2.23f, 0.34f}) * turn(-0.15f, {0, 1, 0}));
}

}  // namespace halflight
