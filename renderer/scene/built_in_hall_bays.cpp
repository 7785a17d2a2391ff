// The hall's bays: piers, arcades, gallery and windows.
#include "scene/built_in_hall.h"

namespace halflight {

using namespace hall;

std::vector<Vec2> pointed_arch(float half, float rise, int steps) {
  std::vector<Vec2> points;
  for (int i = -steps; i <= steps; ++i) {
    const float angle = pi / 3 * (1 - std::abs(static_cast<float>(i)) / steps);
    const float out = i == 0 ? 0 : std::copysign(2 * std::cos(angle) - 1, static_cast<float>(i));
    points.push_back({half * out, rise * std::sin(angle) / std::sin(pi / 3)});
  }
  return points;
}

std::vector<Vec2> arcade_outline(const ArcadeShape& shape, int steps) {
  const float pitch = shape.width / shape.openings;
  std::vector<Vec2> outline{{0, shape.low}};
  for (int k = 0; k < shape.openings; ++k) {
    const Vec2 spring((k + 0.5f) * pitch, shape.spring);
    if (shape.spring > shape.low) outline.push_back({spring.x - shape.half, shape.low});
    for (const Vec2 p : pointed_arch(shape.half, shape.rise, steps)) outline.push_back(spring + p);
    if (shape.spring > shape.low) outline.push_back({spring.x + shape.half, shape.low});
  }
  outline.insert(outline.end(), {{shape.width, shape.low}, {shape.width, shape.high}, {0, shape.high}});
  return outline;
}

void set_lancet_uv(Mesh& pane) {
  const Vec2 corners[4] = {{0.26f, 0.985f}, {0.74f, 0.985f}, {0.74f, 0.015f}, {0.26f, 0.015f}};
  for (int i = 0; i < 4; ++i) pane.vertices[i].uv[0] = corners[i];
}

namespace {

constexpr ArcadeShape arcade{bay, arcade_spring, gallery, 1, 1.65f, arcade_spring, 2.6f};
constexpr ArcadeShape blind{bay, gallery + 0.3f, gallery_top, 3, 0.5f, gallery + 0.9f, 0.85f};
constexpr ArcadeShape clerestory{bay, gallery_top + 0.6f, vault_spring + vault_rise + 0.1f, 1, 0.95f, 13.4f,
                                 1.6f};
constexpr ArcadeShape aisle_window{bay, 2.0f, 8.2f, 1, 0.75f, 4.9f, 1.3f};

/// Outline coordinates (along, up, depth) to a wall whose nearer face is at x = `face`, from z on.
Mat4 along_nave(float face, float depth, float z) {
  return move({face < 0 ? face : face + depth, 0, z}) * turn(-pi / 2, {0, 1, 0});
}

/// A round moulding that follows an opening's edge at x.
void add_moulding(Hall& hall, const ArcadeShape& shape, float x, float z, float radius) {
  const float pitch = shape.width / shape.openings;
  for (int k = 0; k < shape.openings; ++k) {
    std::vector<Vec3> path;
    if (shape.spring > shape.low) path.push_back({x, shape.low, z + (k + 0.5f) * pitch - shape.half});
    for (const Vec2 p : pointed_arch(shape.half, shape.rise, 7))
      path.push_back({x, shape.spring + p.y, z + (k + 0.5f) * pitch + p.x});
    if (shape.spring > shape.low) path.push_back({x, shape.low, z + (k + 0.5f) * pitch + shape.half});
    place(hall.scene, tube_mesh(path, 6, radius), hall.rib);
  }
}

/// Glass behind an opening, a mullion and a ring of lead before it. `inwards` is the way from the glass to
/// the room.
void add_glass(Hall& hall, const ArcadeShape& shape, float x, float z, float inwards) {
  const float top = shape.spring + shape.rise, middle = z + 0.5f * shape.width;
  const float half = shape.half + 0.02f;  // let into the jambs
  Mesh pane = rectangle_mesh({x, shape.low - 0.02f, middle + inwards * half}, {0, 0, -2 * inwards * half},
                             {0, top - shape.low + 0.04f, 0});
  set_lancet_uv(pane);
  place(hall.scene, pane, hall.lancet_glass);
  const float front = x + inwards * 0.05f;
  place(hall.scene,
        tube_mesh(std::vector<Vec3>{{front, shape.low, middle}, {front, top - 0.05f, middle}}, 6, 0.05f),
        hall.rib);
  for (const float share : {0.3f, 0.6f}) {
    const float y = glm::mix(shape.low, shape.spring, share);
    place(hall.scene,
          tube_mesh(std::vector<Vec3>{{front, y, middle - shape.half}, {front, y, middle + shape.half}}, 5,
                    0.025f),
          hall.lead);
  }
}

void add_pier(Hall& hall, Vec3 at) {
  Scene& scene = hall.scene;
  // Eight shafts in a bundle.
  const Mesh bundle = grid_mesh({64, 1, true, false}, [](float u, float v) {
    const float phi = -2 * pi * u, r = 0.37f + 0.13f * std::sqrt(std::abs(std::cos(4 * phi)));
    return Vec3(r * std::cos(phi), 0.5f + (arcade_spring - 1.0f) * v, r * std::sin(phi));
  });
  place(scene, bundle, hall.pier, move(at));
  const std::vector<Vec2> base{{0.62f, 0.25f}, {0.62f, 0.32f}, {0.55f, 0.38f},
                               {0.57f, 0.45f}, {0.50f, 0.52f}, {0.3f, 0.56f}};
  const std::vector<Vec2> bell{{0.36f, 4.42f}, {0.53f, 4.46f}, {0.55f, 4.52f}, {0.50f, 4.58f},
                               {0.56f, 4.74f}, {0.66f, 4.86f}, {0.67f, 4.9f}};
  place(scene, lathe_mesh(base, 32), hall.pier, move(at));
  place(scene, lathe_mesh(smooth_curve(bell, 2), 32), hall.pier, move(at));
  place(scene, box_mesh({1.34f, 0.26f, 1.34f}, 0.03f, 1), hall.pier, move(at + Vec3(0, 0.13f, 0)));
  place(scene, box_mesh({1.30f, 0.14f, 1.30f}, 0.03f, 1), hall.pier, move(at + Vec3(0, 4.95f, 0)));
}

/// The shaft that carries the vault's ribs, on the nave's face of the wall.
void add_wall_shaft(Hall& hall, float side, float z) {
  const float x = side * (nave - 0.03f);
  place(hall.scene,
        tube_mesh(std::vector<Vec3>{{x, arcade_spring, z}, {x, vault_spring - 0.2f, z}}, 12, 0.17f),
        hall.pier);
  const std::vector<Vec2> bell{{0.16f, -0.32f}, {0.21f, -0.30f}, {0.18f, -0.25f},
                               {0.26f, -0.06f}, {0.28f, 0.0f},   {0, 0.01f}};
  place(hall.scene, lathe_mesh(bell, 20), hall.pier, move({x, vault_spring, z}));
}

void add_side(Hall& hall, float side) {
  const float inner = side < 0 ? -arcade_back : nave, thickness = arcade_back - nave;
  const auto wall = [&](const Mesh& mesh, float depth, float face, float z) {
    // Outline walls start at their face nearest to x = 0 on the right, at the farther one on the left.
    place(hall.scene, mesh, hall.stone, along_nave(side < 0 ? -face : face, depth, z));
  };
  const Mesh arcade_wall = extrude_mesh(arcade_outline(arcade, 9), thickness);
  const Mesh blind_wall = extrude_mesh(arcade_outline(blind, 5), 0.4f);
  const Mesh window_wall = extrude_mesh(arcade_outline(clerestory, 7), thickness);
  const Mesh aisle_wall = extrude_mesh(arcade_outline(aisle_window, 6), 0.5f);
  const float middle = 0.5f * length;
  for (int i = 0; i < bays; ++i) {
    const float z = i * bay;
    wall(arcade_wall, thickness, nave, z);
    wall(blind_wall, 0.4f, nave, z);
    wall(window_wall, thickness, nave, z);
    wall(aisle_wall, 0.5f, outer, z);
    add_moulding(hall, arcade, side * (nave - 0.02f), z, 0.10f);
    add_moulding(hall, blind, side * (nave - 0.01f), z, 0.05f);
    add_moulding(hall, clerestory, side * (nave - 0.01f), z, 0.07f);
    add_glass(hall, clerestory, side * (arcade_back - 0.15f), z, -side);
    add_glass(hall, aisle_window, side * (outer + 0.35f), z, -side);
  }
  for (int i = 0; i <= bays; ++i) {
    add_pier(hall, {side * 0.5f * (nave + arcade_back), 0, i * bay});
    add_wall_shaft(hall, side, i * bay);
  }
  const auto course = [&](Vec3 size, Vec2 at) {
    place(hall.scene, box_mesh(size, 0.04f, 1), hall.rib, move({side * at.x, at.y, middle}));
  };
  // Below and behind the gallery, under the clerestory, and the low wall of the aisle.
  place(hall.scene, box_mesh({thickness, 0.3f, length}), hall.stone,
        move({inner + 0.5f * thickness, gallery + 0.15f, middle}));
  place(hall.scene, box_mesh({0.4f, gallery_top - gallery, length}), hall.stone,
        move({side * (nave + 0.6f), 0.5f * (gallery + gallery_top), middle}));
  place(hall.scene, box_mesh({thickness, 0.6f, length}), hall.stone,
        move({inner + 0.5f * thickness, gallery_top + 0.3f, middle}));
  place(hall.scene, box_mesh({0.5f, 2.0f, length}), hall.stone, move({side * (outer + 0.25f), 1.0f, middle}));
  course({0.30f, 0.22f, length}, {nave, gallery + 0.11f});
  course({0.26f, 0.16f, length}, {nave, gallery_top + 0.05f});
  course({0.24f, 0.14f, length}, {outer, 1.95f});
}

}  // namespace

void add_bays(Hall& hall) {
  place(hall.scene, rectangle_mesh({-outer, 0, length}, {2 * outer, 0, 0}, {0, 0, -length}), hall.floor);
  add_side(hall, -1);
  add_side(hall, 1);
}

namespace {

/// Four cells over a rectangle of the given half sides: where two pointed barrels cross, the higher one.
Mesh vault_mesh(Vec2 half, float rise, int cells) {
  const auto out = [](float t) { return t >= 1 ? 0 : 2 * std::cos(pi / 3 * t) - 1; };
  const auto up = [](float t) { return std::sin(pi / 3 * t) / std::sin(pi / 3); };
  Mesh vault;
  for (const Vec2 sign : {Vec2(1, 1), Vec2(1, -1), Vec2(-1, 1), Vec2(-1, -1)})
    append(vault, grid_mesh({cells, cells}, [&](float u, float v) {
             // From the corner inwards, so that the groin is the cells' common diagonal; fronts look down.
             if (sign.x * sign.y < 0) std::swap(u, v);
             return Vec3(sign.x * half.x * out(u), rise * up(std::max(u, v)), sign.y * half.y * out(v));
           }));
  smooth_normals(vault, 0.5f);
  return vault;
}

void add_vault(Hall& hall, Vec3 springing, Vec2 half, float rise, float radius, int sides) {
  // Let into the walls and, under the ribs, into its neighbours.
  place(hall.scene, vault_mesh(half + 0.02f, rise, 9), hall.vault, move(springing));
  const auto rib = [&](Vec2 direction, Vec3 offset) {
    std::vector<Vec3> path;
    for (const Vec2 p : pointed_arch(1, rise, 10))
      path.push_back(springing + offset + Vec3(p.x * direction.x, p.y - 0.3f * radius, p.x * direction.y));
    place(hall.scene, tube_mesh(path, sides, radius), hall.rib);
  };
  rib({half.x, half.y}, Vec3(0));
  rib({half.x, -half.y}, Vec3(0));
  rib({half.x, 0}, {0, 0, half.y});
  const std::vector<Vec2> boss{{0, -0.16f}, {0.16f, -0.13f}, {0.24f, -0.02f}, {0.2f, 0.08f}};
  place(hall.scene, lathe_mesh(boss, 14), hall.rib,
        move(springing + Vec3(0, rise - 0.1f, 0)) * stretch(Vec3(radius / 0.13f)));
}

}  // namespace

void add_vaults(Hall& hall) {
  const float aisle_middle = 0.5f * (arcade_back + outer), aisle_half = 0.5f * (outer - arcade_back);
  for (int i = 0; i < bays; ++i) {
    const float z = (i + 0.5f) * bay;
    add_vault(hall, {0, vault_spring, z}, {nave, 0.5f * bay}, vault_rise, 0.13f, 8);
    for (const float side : {-1.0f, 1.0f})
      add_vault(hall, {side * aisle_middle, arcade_spring, z}, {aisle_half, 0.5f * bay}, 2.7f, 0.09f, 6);
  }
}

}  // namespace halflight
