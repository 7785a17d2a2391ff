// A vaulted hall in the manner of the cathedral that Pharr's instant global illumination is shown on: lamps
// on the galleries shine at the vault, three windows throw their glass on the floor, and the rest is lit by
// what these meet.
#include "scene/built_in_hall.h"

#include <fmt/format.h>

#include "scene/built_in_lit.h"
#include "scene/built_in_scenes.h"
#include "scene/built_in_slides.h"
#include "scene/built_in_textures.h"

namespace halflight {

using namespace hall;

namespace {

/// Glass that is seen glowing. It lights nothing: what comes through it is the projectors' business.
uint32_t add_glass_material(Hall& room, const ImageRgb& slide, const char* name) {
  Material glass = plain_material(name, Vec3(1), 1);
  glass.unlit = true;
  glass.base_color_texture = add_texture(room.scene, encoded(slide), name, Vec2(1));
  return add_material(room.scene, glass);
}

void add_materials(Hall& room) {
  Scene& scene = room.scene;
  room.stone = add_material(scene, plain_material("ashlar", {0.66f, 0.59f, 0.49f}, 0.9f));
  room.vault = add_material(scene, plain_material("vault plaster", {0.80f, 0.75f, 0.66f}, 0.9f));
  room.rib = add_material(scene, plain_material("ribs", {0.58f, 0.50f, 0.41f}, 0.8f));
  room.pier = add_material(scene, plain_material("dressed stone", {0.62f, 0.56f, 0.48f}, 0.55f));
  Material tiles = phong_material("marble floor", Vec3(1), Vec3(0.12f), 90);
  tiles.base_color_texture =
      add_texture(scene, checker_texture(512, 4, {0.66f, 0.61f, 0.53f}, {0.16f, 0.13f, 0.12f}, 91), "marble",
                  {4.8f, 4.8f});
  room.floor = add_material(scene, tiles);
  Material oak = plain_material("oak", Vec3(1), 0.4f);
  oak.base_color_texture = add_texture(
      scene, grain_texture(256, {0.36f, 0.21f, 0.11f}, {0.20f, 0.105f, 0.05f}, 25), "oak", {0.4f, 1.6f});
  room.oak = add_material(scene, oak);
  room.linen = add_material(scene, plain_material("linen", {0.82f, 0.79f, 0.72f}, 0.9f));
  room.brass = add_material(scene, metal_material("brass", {0.89f, 0.66f, 0.34f}, 0.25f));
  room.lead = add_material(scene, plain_material("lead", {0.05f, 0.05f, 0.055f}, 0.5f));
  room.lancet_glass = add_glass_material(room, lancet_slide(256, 0), "lancet glass");
  room.rose_glass = add_glass_material(room, rose_window_slide(256), "rose glass");
}

void add_lights(Hall& room) {
  Scene& scene = room.scene;
  for (int i = 0; i < 3; ++i) {
    const float side = i % 2 == 0 ? 1.0f : -1.0f, z = (2 * i + 1) * bay;
    scene.lights.push_back(
        aimed_spot(fmt::format("uplighter {}", i + 1), {side * (nave - 0.6f), gallery + 0.5f, z},
                   {-side * 1.2f, vault_spring + vault_rise, z}, 74, 250.0f * Vec3(1, 0.82f, 0.60f)));
    scene.lights.back().inner_cone = glm::radians(35.0f);
  }
  for (const float side : {-1.0f, 1.0f}) {
    const float z = 2.5f * bay;
    scene.lights.push_back(aimed_spot(side < 0 ? "left aisle lamp" : "right aisle lamp",
                                      {side * (outer - 0.4f), 2.3f, z}, {side * (outer - 1.6f), 7.5f, z}, 76,
                                      80.0f * Vec3(1, 0.82f, 0.60f)));
    scene.lights.back().inner_cone = glm::radians(20.0f);
  }
  // Afternoon sun through glass of the right clerestory.
  const int32_t first = static_cast<int32_t>(scene.pictures.size());
  for (int i = 0; i < 3; ++i) {
    const float z = (i + 1.5f) * bay + (i > 0 ? bay : 0);
    scene.pictures.push_back(lancet_slide(256, i));
    PunctualLight sun = aimed_spot(fmt::format("window {}", i + 1), {nave - 0.1f, 13.2f, z},
                                   {-1.7f, 0, z + 1.5f}, 10.5f, 4800.0f * Vec3(1, 0.9f, 0.72f));
    sun.picture = first + i;
    scene.lights.push_back(sun);
  }
}

}  // namespace

Scene make_hall() {
  Hall room;
  room.scene.facts.source = "hall";
  add_materials(room);
  add_bays(room);
  add_vaults(room);
  add_ends(room);
  add_pews(room);
  add_sanctuary(room);
  add_lights(room);
  add_camera(room.scene, "main", {-1.1f, 2.6f, length - 0.8f}, {0.3f, 6.9f, 2}, 64);
  add_camera(room.scene, "aisle", {-6.2f, 1.8f, length - 1.5f}, {-4.2f, 3.4f, 6}, 58);
  update_bounds(room.scene);
  return std::move(room.scene);
}

}  // namespace halflight
