#include "scene/built_in_car.h"
#include "scene/built_in_lit.h"

namespace halflight {

namespace {

/// Turns +y of a part to `axis`, keeping it upright, and moves it to `at`.
Mat4 aim(Vec3 at, Vec3 axis) {
  const Basis basis = basis_along(glm::normalize(axis), Vec3(0, 1, 0));
  Mat4 m(1);
  m[0] = Vec4(basis.bitangent, 0), m[1] = Vec4(basis.normal, 0), m[2] = Vec4(basis.tangent, 0),
  m[3] = Vec4(at, 1);
  return m;
}

/// The same on both sides.
void place_both(Scene& scene, const Mesh& mesh, uint32_t material, const Mat4& transform = Mat4(1)) {
  place(scene, mesh, material, transform);
  place(scene, mesh, material, stretch({1, 1, -1}) * transform);
}

// Sections of a wheel, as (radius, height along its axle), from the inside out.
constexpr Vec2 tyre_profile[] = {{0.215f, -0.075f}, {0.275f, -0.092f}, {0.308f, -0.078f},
                                 {0.322f, -0.045f}, {0.325f, 0},       {0.322f, 0.045f},
                                 {0.308f, 0.078f},  {0.275f, 0.092f},  {0.215f, 0.075f}};
constexpr Vec2 rim_profile[] = {{0.212f, 0.068f}, {0.222f, 0.082f}, {0.216f, 0.090f}, {0.206f, 0.086f},
                                {0.196f, 0.055f}, {0.182f, 0.044f}, {0.158f, 0.046f}, {0.138f, 0.060f},
                                {0.112f, 0.064f}, {0.04f, 0.064f}};
constexpr Vec2 cap_profile[] = {{0.110f, 0.060f}, {0.110f, 0.074f}, {0.098f, 0.087f}, {0.066f, 0.096f},
                                {0.048f, 0.098f}, {0.040f, 0.110f}, {0.022f, 0.117f}, {0, 0.119f}};

void add_wheel(Scene& scene, const CarMaterials& materials, Vec2 axle) {
  const Mat4 at = move({axle.x, axle.y, 0.655f}) * turn(pi / 2, {1, 0, 0});
  place_both(scene, lathe_mesh(tyre_profile, 36, 1.5f), materials.tyre, at);
  place_both(scene, lathe_mesh(rim_profile, 36, 1.0f), materials.rim, at);
  place_both(scene, lathe_mesh(cap_profile, 22, 0.8f), materials.chrome, at);
  // Slots between cap and rim.
  const Mesh slot = superquadric_mesh({0.024f, 0.010f, 0.011f}, {1, 1}, 8, 3);
  for (int i = 0; i < 8; ++i) {
    const float angle = 2 * pi * static_cast<float>(i) / 8;
    place_both(scene, slot, materials.dark, at * turn(angle, {0, 1, 0}) * move({0, 0.046f, 0.166f}));
  }
}

/// The well behind an arch's edge, and the edge's lip.
void add_well(Scene& scene, const CarMaterials& materials, Vec2 axle) {
  constexpr int steps = 30;
  const float lowest = std::asin((car_floor + 0.035f - axle.y) / arch_radius);
  std::vector<Vec3> edge;
  for (int i = 0; i <= steps; ++i) {
    const float angle = glm::mix(lowest, pi - lowest, static_cast<float>(i) / steps);
    const Vec2 at = axle + arch_radius * Vec2(std::cos(angle), std::sin(angle));
    edge.push_back({at.x, at.y, well_depth + reach({at.x, at.y, well_depth}, {0, 0, 1})});
  }
  const auto on_edge = [&](float u) { return edge[static_cast<size_t>(std::lround(u * steps))]; };
  Mesh barrel = grid_mesh({steps, 1}, [&](float u, float v) {
    const Vec3 p = on_edge(u);
    return Vec3(p.x, p.y, glm::mix(p.z, well_depth, v));
  });
  smooth_normals(barrel);
  Mesh wall = grid_mesh({steps, 1}, [&](float u, float v) {
    const Vec3 p = on_edge(u);
    return Vec3(glm::mix(axle.x, p.x, v), glm::mix(car_floor, p.y, v), well_depth + 0.01f);
  });
  smooth_normals(wall);
  place_both(scene, barrel, materials.dark);
  place_both(scene, wall, materials.dark);
  place_both(scene, tube_mesh(edge, 6, 0.013f), materials.paint);
}

/// Points about the body at `offset` from it and at height y, over the angles ±`spread` about the way `ahead`
/// (1 or −1) seen from (x, 0).
std::vector<Vec3> around_end(float x, float y, float ahead, float spread, float offset, int steps) {
  std::vector<Vec3> path;
  for (int i = 0; i <= steps; ++i) {
    const float angle = glm::mix(-spread, spread, static_cast<float>(i) / static_cast<float>(steps));
    const Vec3 direction(ahead * std::cos(angle), 0, std::sin(angle));
    path.push_back(Vec3(x, y, 0) + direction * reach({x, y, 0}, direction, offset));
  }
  return path;
}

void add_bumpers(Scene& scene, const CarMaterials& materials) {
  for (const float ahead : {1.0f, -1.0f}) {
    const float x = ahead * 1.05f, height = 0.40f;
    std::vector<Vec3> path = around_end(x, height, ahead, 0.98f, 0.06f, 32);
    for (Vec3& p : path) p.y = 0;
    // A flattened tube is a blade; its ends taper.
    const Mesh blade =
        tube_mesh(path, 8, [](float t) { return 0.030f * std::min(1.0f, 0.45f + 6 * std::min(t, 1 - t)); });
    place(scene, blade, materials.chrome, move({0, height, 0}) * stretch({1, 1.9f, 1}));
    for (const float z : {-0.34f, 0.34f}) {
      const float out = reach({x, height, z}, {ahead, 0, 0}, 0.06f);
      const Vec3 at(x + ahead * (out + 0.005f), height + 0.015f, z);
      place(scene, superquadric_mesh({0.048f, 0.105f, 0.032f}, {0.8f, 1}, 14, 8), materials.chrome, move(at));
      const Vec3 root(x + ahead * (out - 0.16f), height, z);
      const std::vector<Vec3> bracket{root, at};
      place(scene, tube_mesh(bracket, 8, 0.018f), materials.dark);
    }
  }
}

void add_lamps(Scene& scene, const CarMaterials& materials) {
  constexpr Vec2 pod[] = {{0.127f, -0.20f}, {0.127f, -0.035f}, {0.118f, -0.012f}};
  constexpr Vec2 bezel[] = {
      {0.118f, -0.03f}, {0.121f, 0.008f}, {0.117f, 0.021f}, {0.107f, 0.024f}, {0.100f, 0.014f}};
  constexpr Vec2 lens[] = {
      {0.101f, 0.012f}, {0.085f, 0.027f}, {0.060f, 0.038f}, {0.030f, 0.045f}, {0, 0.047f}};
  const Mat4 head = aim(lamp_middle + 0.045f * glm::normalize(lamp_axis), lamp_axis);
  place_both(scene, lathe_mesh(pod, 32, 1.2f), materials.paint, head);
  place_both(scene, lathe_mesh(bezel, 32, 1.2f), materials.chrome, head);
  place_both(scene, lathe_mesh(lens, 32, 1.2f), materials.lamp, head);
  // Side lamps below, and lamps behind.
  const auto small_lamp = [&](Vec3 from, Vec3 direction, Vec3 half, uint32_t material) {
    const Vec3 at = from + direction * reach(from, direction);
    place_both(scene, superquadric_mesh(half * Vec3(1.25f, 0.8f, 1.25f), {1, 1}, 14, 7), materials.chrome,
               aim(at, direction));
    place_both(scene, superquadric_mesh(half, {1, 1}, 14, 8), material,
               aim(at + 0.012f * direction, direction));
  };
  small_lamp({1.2f, 0.50f, 0.49f}, {1, 0, 0}, {0.036f, 0.032f, 0.028f}, materials.lamp);
  small_lamp({-1.2f, 0.60f, 0.50f}, glm::normalize(Vec3(-1, 0, 0.12f)), {0.036f, 0.030f, 0.062f},
             materials.tail_lamp);
}

/// What stands on the doors and on the sills.
void add_side_trim(Scene& scene, const CarMaterials& materials) {
  const auto beside = [](float x, float y, float offset) {
    return Vec3(x, y, 0.2f + reach({x, y, 0.2f}, {0, 0, 1}, offset));
  };
  std::vector<Vec3> sill;
  for (int i = 0; i <= 16; ++i)
    sill.push_back(beside(glm::mix(axles[1].x + arch_radius + 0.03f, axles[0].x - arch_radius - 0.03f,
                                   static_cast<float>(i) / 16),
                          0.305f, 0.003f));
  place_both(scene, tube_mesh(sill, 6, 0.013f), materials.chrome);
  const std::vector<Vec3> handle =
      smooth_curve(std::vector<Vec3>{beside(-0.23f, 0.80f, 0), beside(-0.235f, 0.80f, 0.028f),
                                     beside(-0.30f, 0.802f, 0.034f), beside(-0.365f, 0.80f, 0.028f),
                                     beside(-0.37f, 0.80f, 0)},
                   4);
  place_both(scene, tube_mesh(handle, 6, 0.010f), materials.chrome);
  // A mirror on a stalk, on the doors.
  const Vec3 foot = beside(0.44f, 0.90f, -0.01f), head = foot + Vec3(0.02f, 0.10f, 0.10f);
  place_both(
      scene,
      tube_mesh(std::vector<Vec3>{foot, 0.5f * (foot + head) + Vec3(0, 0.01f, 0.01f), head}, 8, 0.009f),
      materials.chrome);
  place_both(scene, superquadric_mesh({0.035f, 0.045f, 0.058f}, {1, 1}, 14, 7), materials.chrome,
             move(head + Vec3(0.005f, 0.01f, 0)));
}

void add_ends(Scene& scene, const CarMaterials& materials) {
  // A handle on the hood, a grille on the engine's lid.
  const auto above = [](float x, float z, float offset) {
    return Vec3(x, 0.4f + reach({x, 0.4f, z}, {0, 1, 0}, offset), z);
  };
  std::vector<Vec3> strip;
  for (int i = 0; i <= 16; ++i)
    strip.push_back(above(glm::mix(1.10f, 1.72f, static_cast<float>(i) / 16), 0, 0.004f));
  place(scene, tube_mesh(strip, 8, [](float t) { return 0.006f + 0.012f * t; }), materials.chrome);
  for (int bar = -4; bar <= 4; ++bar) {
    std::vector<Vec3> path;
    const float z = 0.04f * static_cast<float>(bar);
    for (int i = 0; i <= 8; ++i)
      path.push_back(above(glm::mix(-1.44f, -1.65f, static_cast<float>(i) / 8), z, 0.004f));
    place(scene, tube_mesh(path, 6, 0.007f), bar % 4 == 0 ? materials.chrome : materials.dark);
  }
  // Wipers at rest, on their pivots.
  for (const float z : {-0.06f, 0.36f}) {
    std::vector<Vec3> path;
    for (int i = 0; i <= 8; ++i) {
      const float t = static_cast<float>(i) / 8;
      const Vec3 from(0, 0.915f + 0.055f * t, z - 0.36f * t);
      path.push_back(from + Vec3(1, 0, 0) * reach(from, {1, 0, 0}, 0.012f));
    }
    place(scene, tube_mesh(path, 6, 0.006f), materials.dark);
  }
}

}  // namespace

void add_car_wheels(Scene& scene, const CarMaterials& materials) {
  for (const Vec2 axle : axles) add_wheel(scene, materials, axle), add_well(scene, materials, axle);
}

void add_car_trim(Scene& scene, const CarMaterials& materials) {
  add_bumpers(scene, materials);
  add_lamps(scene, materials);
  add_side_trim(scene, materials);
  add_ends(scene, materials);
}

}  // namespace halflight
