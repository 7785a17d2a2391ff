// A furnished bedroom at night, after the fifth scene of Wang & Åkerlund 2009 (fig. 7): 95K triangles, one
// punctual light. The lamp is an uplighter, so all but the ceiling and the tops of the walls is lit by one
// bounce.
#include "scene/built_in_bedroom.h"

#include <fmt/format.h>

#include "scene/built_in_scenes.h"
#include "scene/built_in_textures.h"
#include "scene/camera.h"

namespace halflight {

namespace {

uint32_t textured(Scene& scene, Material material, TextureUse use) {
  material.base_color_texture = use;
  return add_material(scene, std::move(material));
}

TextureUse scaled(TextureUse use, float u, float v) {
  use.row_u *= u, use.row_v *= v;
  return use;
}

void add_wood_and_metal(Bedroom& room) {
  Scene& scene = room.scene;
  const TextureUse boards =
      add_texture(scene, board_texture(512, 8, {0.52f, 0.33f, 0.18f}, {0.30f, 0.165f, 0.08f}, 3),
                  "floor boards", {1.4f, 2.8f});
  const TextureUse oak = add_texture(
      scene, grain_texture(256, {0.60f, 0.42f, 0.26f}, {0.44f, 0.28f, 0.15f}, 5), "oak", {0.45f, 1.1f});
  const TextureUse walnut = add_texture(
      scene, grain_texture(256, {0.21f, 0.105f, 0.055f}, {0.10f, 0.045f, 0.022f}, 9), "walnut", {0.4f, 1.2f});
  room.floor = textured(scene, plain_material("polished floor", Vec3(1), 0.3f), boards);
  room.light_wood = textured(scene, plain_material("oak", Vec3(1), 0.45f), oak);
  room.dark_wood = textured(scene, plain_material("walnut", Vec3(1), 0.35f), walnut);
  room.brass = add_material(scene, metal_material("brass", {0.89f, 0.66f, 0.34f}, 0.25f));
  room.steel = add_material(scene, metal_material("steel", {0.60f, 0.58f, 0.56f}, 0.15f));
  room.enamel = add_material(scene, plain_material("cream enamel", {0.72f, 0.62f, 0.46f}, 0.25f));
  room.black = add_material(scene, plain_material("black lacquer", {0.012f, 0.012f, 0.014f}, 0.2f));
}

void add_fabrics(Bedroom& room) {
  Scene& scene = room.scene;
  const TextureUse weave = add_texture(scene, weave_texture(256, 32, 0.28f, 21), "weave", {0.12f, 0.12f});
  const auto fabric = [&](const char* name, Vec3 color, float u, float v) {
    return textured(scene, plain_material(name, color, 0.9f), scaled(weave, u, v));
  };
  room.linen = fabric("linen", {0.84f, 0.81f, 0.75f}, 0.06f, 0.06f);
  room.duvet = fabric("duvet", {0.80f, 0.77f, 0.71f}, 1.6f, 1.6f);
  room.upholstery = fabric("upholstery", {0.13f, 0.28f, 0.30f}, 1, 1);
  room.throw_wool = fabric("wool throw", {0.62f, 0.25f, 0.11f}, 0.7f, 0.35f);
  room.cushion = fabric("cushion", {0.70f, 0.42f, 0.10f}, 0.08f, 0.08f);
  room.curtain = fabric("curtain", {0.55f, 0.50f, 0.42f}, 0.3f, 0.3f);
  const ImageRgba8 pattern =
      rug_texture(384, 512, {0.62f, 0.53f, 0.42f}, {0.06f, 0.13f, 0.18f}, {0.42f, 0.10f, 0.06f}, 31);
  room.rug = textured(scene, plain_material("rug", Vec3(1), 1), add_texture(scene, pattern, "rug", {1, 1}));
}

}  // namespace

void add_bedroom_materials(Bedroom& room) {
  Scene& scene = room.scene;
  room.wall = add_material(scene, plain_material("wall paint", {0.82f, 0.79f, 0.74f}, 0.8f));
  room.feature_wall = add_material(scene, plain_material("sage paint", {0.52f, 0.60f, 0.55f}, 0.7f));
  room.trim = add_material(scene, plain_material("satin white", {0.85f, 0.84f, 0.81f}, 0.4f));
  add_wood_and_metal(room);
  add_fabrics(room);
  room.paper = add_material(scene, plain_material("paper", {0.78f, 0.74f, 0.65f}, 0.9f));
  const Vec3 covers[] = {{0.35f, 0.06f, 0.04f}, {0.05f, 0.12f, 0.20f}, {0.55f, 0.42f, 0.22f},
                         {0.07f, 0.16f, 0.11f}, {0.60f, 0.57f, 0.50f}, {0.13f, 0.09f, 0.14f},
                         {0.55f, 0.24f, 0.08f}, {0.20f, 0.32f, 0.36f}};
  for (size_t i = 0; i < room.book_covers.size(); ++i)
    room.book_covers[i] =
        add_material(scene, plain_material(fmt::format("book cover {}", i + 1), covers[i], 0.5f));
  room.ceramic_white = add_material(scene, plain_material("white glaze", {0.80f, 0.79f, 0.76f}, 0.12f));
  room.ceramic_blue = add_material(scene, plain_material("blue glaze", {0.03f, 0.09f, 0.20f}, 0.1f));
  room.terracotta = add_material(scene, plain_material("terracotta", {0.52f, 0.22f, 0.11f}, 0.8f));
  room.leaf = add_material(scene, plain_material("leaf", {0.06f, 0.17f, 0.05f}, 0.4f));
  room.glass = add_material(scene, plain_material("night window", {0.004f, 0.005f, 0.008f}, 0.05f));
}

Scene make_bedroom() {
  Bedroom room;
  room.scene.facts.source = "bedroom";
  add_bedroom_materials(room);
  add_room(room);
  add_bed(room);
  add_curtains(room);
  add_rug(room);
  add_bedside(room);
  add_lamp(room);
  add_wardrobe(room);
  add_desk(room);
  add_bookcase(room);
  add_decoration(room);
  add_tableware(room);

  const auto add_camera = [&](const char* name, Vec3 eye, Vec3 target, float degrees) {
    Camera camera = look_at(eye, target, {0, 1, 0}, glm::radians(degrees));
    camera.name = name;
    room.scene.cameras.push_back(camera);
  };
  add_camera("main", {4.72f, 1.50f, 4.15f}, {1.85f, 0.86f, 0.6f}, 50);
  add_camera("desk", {4.3f, 1.45f, 1.6f}, {0.2f, 1.0f, 2.0f}, 45);
  add_camera("door", {0.9f, 1.55f, 0.9f}, {4.6f, 0.95f, 4.0f}, 55);
  update_bounds(room.scene);
  return std::move(room.scene);
}

}  // namespace halflight
