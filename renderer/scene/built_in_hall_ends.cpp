// The hall's end walls and what stands in it.
#include "scene/built_in_hall.h"

namespace halflight {

using namespace hall;

namespace {

constexpr ArcadeShape east{2 * nave, 2.8f, vault_spring + vault_rise + 0.1f, 3, 0.8f, 7.2f, 1.7f};

/// Glass of the east wall: three lancets behind its openings, a rose above.
void add_east_glass(Hall& hall) {
  const float pitch = east.width / east.openings, back = -0.45f;
  const float height = east.spring + east.rise - east.low;
  for (int k = 0; k < east.openings; ++k) {
    const float x = -nave + (k + 0.5f) * pitch;
    Mesh pane = rectangle_mesh({x - east.half, east.low, back}, {2 * east.half, 0, 0}, {0, height, 0});
    set_lancet_uv(pane);
    place(hall.scene, pane, hall.lancet_glass);
    for (const float y : {4.0f, 5.2f, 6.4f, 7.6f})
      place(hall.scene,
            tube_mesh(std::vector<Vec3>{{x - east.half, y, back + 0.04f}, {x + east.half, y, back + 0.04f}},
                      5, 0.03f),
            hall.lead);
    std::vector<Vec3> edge{{x - east.half, east.low, 0.02f}};
    for (const Vec2 p : pointed_arch(east.half, east.rise, 8))
      edge.push_back({x + p.x, east.spring + p.y, 0.02f});
    edge.push_back({x + east.half, east.low, 0.02f});
    place(hall.scene, tube_mesh(edge, 8, 0.09f), hall.rib);
  }
  const float radius = 1.75f;
  Mesh rose;
  const int sides = 64;
  for (int i = 0; i < sides; ++i) {
    const float phi = 2 * pi * i / sides;
    add_vertex(rose, {radius * std::cos(phi), radius * std::sin(phi), 0},
               {0.5f + 0.5f * std::cos(phi), 0.5f - 0.5f * std::sin(phi)});
  }
  const uint32_t centre = add_vertex(rose, Vec3(0), Vec2(0.5f));
  for (uint32_t i = 0; i < sides; ++i) rose.triangles.push_back({centre, i, (i + 1) % sides});
  smooth_normals(rose);
  const Mat4 at = move({0, 12.6f, 0.03f});
  place(hall.scene, rose, hall.rose_glass, at);
  const std::vector<Vec2> ring{{radius - 0.06f, -0.1f}, {radius - 0.04f, 0.12f}, {radius + 0.06f, 0.2f},
                               {radius + 0.2f, 0.14f},  {radius + 0.28f, 0.04f}, {radius + 0.3f, -0.1f}};
  // A lathe's axis is y: laid over so that it points at the nave.
  Mesh moulding = lathe_mesh(ring, 64);
  place(hall.scene, moulding, hall.rib, at * turn(pi / 2, {1, 0, 0}));
}

}  // namespace

void add_ends(Hall& hall) {
  Scene& scene = hall.scene;
  place(scene, extrude_mesh(arcade_outline(east, 8), 0.6f), hall.stone, move({-nave, 0, -0.6f}));
  place(scene, box_mesh({2 * nave, east.low, 0.6f}), hall.stone, move({0, 0.5f * east.low, -0.3f}));
  add_east_glass(hall);
  for (const float side : {-1.0f, 1.0f})
    place(scene, box_mesh({outer - nave, 9.5f, 0.6f}), hall.stone,
          move({side * 0.5f * (outer + nave), 4.75f, -0.3f}));
  place(scene,
        rectangle_mesh({outer, 0, length}, {-2 * outer, 0, 0}, {0, vault_spring + vault_rise + 0.1f, 0}),
        hall.stone);
}

void add_pews(Hall& hall) {
  const float width = 2.05f;
  Mesh pew;
  const auto board = [&](Vec3 size, Vec3 at, float lean = 0) {
    append(pew, box_mesh(size, 0.015f, 1), move(at) * turn(lean, {1, 0, 0}));
  };
  board({width, 0.04f, 0.42f}, {0, 0.46f, 0});
  board({width, 0.50f, 0.035f}, {0, 0.74f, 0.22f}, 0.12f);
  board({width, 0.05f, 0.09f}, {0, 1.0f, 0.26f});
  board({width, 0.035f, 0.20f}, {0, 0.80f, 0.38f});
  for (const float side : {-1.0f, 1.0f})
    board({0.07f, 1.06f, 0.58f}, {side * (0.5f * width + 0.02f), 0.53f, 0.08f});
  for (int row = 0; row < 14; ++row)
    for (const float side : {-1.0f, 1.0f})
      place(hall.scene, pew, hall.oak, move({side * 2.02f, 0, 7.4f + 1.0f * row}));
}

void add_sanctuary(Hall& hall) {
  Scene& scene = hall.scene;
  for (int step = 0; step < 3; ++step) {
    const float depth = 4.4f - 0.45f * step;
    place(scene, box_mesh({2 * nave - 0.3f - 0.5f * step, 0.17f, depth}, 0.02f, 1), hall.pier,
          move({0, 0.17f * step + 0.085f, 0.5f * depth}));
  }
  const float floor = 0.51f, z = 1.7f;
  place(scene, box_mesh({2.4f, 0.95f, 0.9f}, 0.02f, 2), hall.pier, move({0, floor + 0.475f, z}));
  place(scene, box_mesh({2.7f, 0.09f, 1.1f}, 0.03f, 2), hall.pier, move({0, floor + 0.99f, z}));
  // The cloth lies over the top and hangs down in front.
  place(scene,
        grid_mesh({40, 24},
                  [&](float u, float v) {
                    const float x = 2.0f * (u - 0.5f), along = 1.75f * v;
                    const float hang = std::max(0.0f, along - 1.12f);
                    const float fold = 0.018f * std::sin(40 * u) * std::min(1.0f, 3 * hang);
                    return Vec3(x, floor + 1.045f - hang, z - 0.54f + std::min(along, 1.115f) + fold);
                  }),
        hall.linen);
  const std::vector<Vec2> stick{{0, 0},         {0.11f, 0},      {0.10f, 0.03f},  {0.03f, 0.06f},
                                {0.02f, 0.2f},  {0.045f, 0.24f}, {0.02f, 0.28f},  {0.02f, 0.42f},
                                {0.07f, 0.46f}, {0.07f, 0.48f},  {0.025f, 0.48f}, {0.025f, 0.8f},
                                {0, 0.81f}};
  for (const float x : {-1.2f, -1.0f, 1.0f, 1.2f})
    place(scene, lathe_mesh(stick, 18), hall.brass, move({x, floor + 1.035f, z - 0.25f}));
}

}  // namespace halflight
