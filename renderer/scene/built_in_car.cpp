// The car of Wang & Åkerlund's figure 4 is a model that is not ours to pass on; this one has its size and
// kind: a rounded coupé in the manner of about 1960, from a distance field, under light that comes mostly
// from above.
#include "scene/built_in_car.h"

#include "scene/built_in_environments.h"
#include "scene/built_in_lit.h"
#include "scene/built_in_scenes.h"

namespace halflight {

namespace {

/// Signed distance to a simple polygon in the plane, negative inside, its corners rounded by `radius` from
/// outside.
float outline_distance(Vec2 p, std::span<const Vec2> polygon, float radius) {
  float nearest = infinity;
  bool inside = false;
  for (size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
    const Vec2 a = polygon[i], b = polygon[j], edge = b - a, d = p - a;
    const float t = glm::clamp(glm::dot(d, edge) / glm::dot(edge, edge), 0.0f, 1.0f);
    nearest = std::min(nearest, glm::length(d - t * edge));
    if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)) inside = !inside;
  }
  return (inside ? -nearest : nearest) - radius;
}

/// The lines drawn on the skin, as fields that are 0 there: side views in (x, y), front and rear views in
/// (|z|, y).
constexpr Vec2 door_window[] = {{0.425f, 0.925f}, {0.20f, 1.12f}, {-0.28f, 1.14f}, {-0.37f, 0.925f}};
constexpr Vec2 rear_window[] = {{-0.515f, 0.935f}, {-0.455f, 1.125f}, {-0.60f, 1.105f}, {-0.84f, 0.965f}};
constexpr Vec2 windscreen[] = {{-0.70f, 0.95f}, {0.70f, 0.95f}, {0.70f, 1.125f}, {-0.70f, 1.125f}};
constexpr Vec2 backlight[] = {{-0.30f, 1.03f}, {0.30f, 1.03f}, {0.24f, 1.06f}, {-0.24f, 1.06f}};
constexpr Vec2 door[] = {{0.60f, 0.36f},  {0.61f, 0.86f},  {0.27f, 1.185f}, {-0.36f, 1.20f},
                         {-0.42f, 0.90f}, {-0.46f, 0.50f}, {-0.38f, 0.36f}};
constexpr Vec2 hood[] = {{1.60f, -0.20f}, {1.60f, 0.20f}, {1.04f, 0.37f}, {1.04f, -0.37f}};
constexpr Vec2 engine_lid[] = {{-1.46f, -0.28f}, {-1.46f, 0.28f}, {-1.69f, 0.24f}, {-1.69f, -0.24f}};
/// Foot and head of the front pillar's fore edge, seen from the side.
constexpr Vec2 pillar_foot{0.60f, 0.90f}, pillar_head{0.30f, 1.17f};

constexpr float middle_x = -0.15f;  ///< what lies ahead of it is the front

/// The windows' edges. Each is cut for itself: pillars are about as narrow as a triangle is long.
float door_glass(Vec3 p) { return outline_distance({p.x, p.y}, door_window, 0.035f); }
float rear_glass(Vec3 p) { return outline_distance({p.x, p.y}, rear_window, 0.035f); }
float back_glass(Vec3 p) { return std::max(outline_distance({p.z, p.y}, backlight, 0.085f), p.x - middle_x); }
float front_glass(Vec3 p) {
  const Vec2 rake = glm::normalize(pillar_head - pillar_foot), along = Vec2(p.x, p.y) - pillar_foot;
  const float behind_pillar = rake.y * -along.x + rake.x * along.y;
  return std::max(outline_distance({p.z, p.y}, windscreen, 0.05f), behind_pillar);
}

constexpr float (*windows[])(Vec3) = {door_glass, rear_glass, back_glass, front_glass};

/// What the pillars of the sides stand in; their paint is not parted by the doors' edges.
float pillar_zone(Vec3 p) { return std::min({door_glass(p), rear_glass(p), front_glass(p)}) - 0.035f; }

float arch_line(Vec3 p) {
  float nearest = infinity;
  for (const Vec2 axle : axles) nearest = std::min(nearest, glm::length(Vec2(p.x, p.y) - axle) - arch_radius);
  return std::max(nearest, well_depth - std::abs(p.z));
}

/// The doors' and lids' edges.
float shut_line(Vec3 p) {
  const Vec2 plan(p.x, p.z);
  const float doors = std::max(outline_distance(Vec2(p.x, p.y), door, 0.03f), 0.45f - std::abs(p.z));
  const float front = std::max(outline_distance(plan, hood, 0.07f), 0.5f - p.y);
  const float back = std::max(outline_distance(plan, engine_lid, 0.07f), 0.5f - p.y);
  return std::min(doors, std::min(front, back));
}

/// Moves the vertices inwards (negative: outwards) along their normals.
void sink(Mesh& mesh, float depth) {
  for (Vertex& v : mesh.vertices) v.position -= depth * v.normal;
}

CarMaterials add_materials(Scene& scene) {
  const auto add = [&](const char* name, Vec3 diffuse, Vec3 specular, float exponent) {
    return add_material(scene, phong_material(name, diffuse, specular, exponent));
  };
  CarMaterials m{};
  m.paint = add("paint", {0.39f, 0.015f, 0.011f}, Vec3(0.22f), 100);
  m.glass = add("glass", {0.008f, 0.010f, 0.011f}, Vec3(0.30f), 100);
  m.chrome = add("chrome", Vec3(0.03f), {0.80f, 0.81f, 0.83f}, 100);
  m.tyre = add("tyre", Vec3(0.022f), Vec3(0.05f), 12);
  m.rim = add("rim", Vec3(0.16f, 0.16f, 0.165f), Vec3(0.45f), 60);
  m.lamp = add("lamp", {0.30f, 0.30f, 0.29f}, Vec3(0.55f), 100);
  m.tail_lamp = add("tail lamp", {0.30f, 0.010f, 0.006f}, Vec3(0.25f), 100);
  m.dark = add("underside", Vec3(0.012f), Vec3(0), 1);
  return m;
}

/// The floor that it stands on.
void add_ground(Scene& scene) {
  const std::vector<Vec2> profile{{16, 0}, {9, 0}, {5, 0}, {2.5f, 0}, {0, 0}};
  place(scene, lathe_mesh(profile, 64),
        add_material(scene, phong_material("ground", {0.24f, 0.237f, 0.233f}, Vec3(0), 1)));
}

}  // namespace

float car_body_distance(Vec3 p) {
  const Vec3 m(p.x, p.y, std::abs(p.z));
  // The hull between the wheels, rounder in front and behind than at the sides.
  float d = superellipsoid_distance(m, {0, 0.50f, 0}, {1.93f, 0.335f, 0.755f}, {2.9f, 2.9f});
  // Hood, tail, cabin.
  d = blend_union(d, ellipsoid_distance(m, {0.95f, 0.58f, 0}, {1.02f, 0.275f, 0.52f}), 0.10f);
  d = blend_union(d, superellipsoid_distance(m, {-0.95f, 0.56f, 0}, {1.02f, 0.38f, 0.60f}, {2.4f, 2.2f}),
                  0.20f);
  d = blend_union(d, superellipsoid_distance(m, {-0.26f, 0.80f, 0}, {1.04f, 0.47f, 0.615f}, {2.7f, 2.15f}),
                  0.14f);
  // Wings: in front they carry the lamps and fade into the doors, behind they swell over the wheels.
  const Vec3 axis = glm::normalize(lamp_axis);
  d = blend_union(d, rod_distance(m, lamp_middle - 0.13f * axis, {-0.10f, 0.60f, 0.585f}, 0.165f, 0.10f),
                  0.16f);
  d = blend_union(d, ellipsoid_distance(m, {-1.12f, 0.56f, 0.56f}, {0.66f, 0.31f, 0.25f}), 0.16f);
  d = blend_union(d, ellipsoid_distance(m, {1.12f, 0.50f, 0.60f}, {0.60f, 0.27f, 0.20f}), 0.14f);
  // A flat underside with a rounded edge.
  return -blend_union(-d, p.y - car_floor, 0.08f);
}

float reach(Vec3 from, Vec3 direction, float offset) {
  float low = 0, high = 4;
  for (int i = 0; i < 26; ++i) {
    const float middle = 0.5f * (low + high);
    (car_body_distance(from + middle * direction) < offset ? low : high) = middle;
  }
  return low;
}

void add_car_body(Scene& scene, const CarMaterials& materials) {
  Mesh skin = implicit_mesh(car_body_distance, {{-2.16f, 0.12f, -0.96f}, {2.16f, 1.44f, 0.96f}}, 0.06f);
  settle(skin, car_body_distance);
  skin = cut_mesh(skin, car_body_distance, arch_line).outside;
  CutMesh cut = cut_mesh(skin, car_body_distance, [](Vec3 p) { return p.y - (car_floor + 0.035f); });
  place(scene, cut.inside, materials.dark);

  for (const auto& window : windows) {
    cut = cut_mesh(cut.outside, car_body_distance, window);
    place(scene, cut.inside, materials.glass);
    cut = cut_mesh(cut.outside, car_body_distance, [&](Vec3 p) { return window(p) - 0.015f; });
    place(scene, cut.inside, materials.chrome);
  }
  cut = cut_mesh(cut.outside, car_body_distance, pillar_zone);
  place(scene, cut.inside, materials.paint);
  constexpr float gap = 0.0045f;
  CutMesh lids = cut_mesh(cut.outside, car_body_distance, [](Vec3 p) { return shut_line(p) + gap; });
  place(scene, lids.inside, materials.paint);
  lids = cut_mesh(lids.outside, car_body_distance, [](Vec3 p) { return shut_line(p) - gap; });
  sink(lids.inside, 0.004f);
  place(scene, lids.inside, materials.dark);
  place(scene, lids.outside, materials.paint);
}

Scene make_car() {
  Scene scene;
  scene.facts.source = "car";
  add_ground(scene);
  const CarMaterials materials = add_materials(scene);
  add_car_body(scene, materials);
  add_car_wheels(scene, materials);
  add_car_trim(scene, materials);
  scene.environment = make_built_in_environment("skylight");
  add_camera(scene, "main", {4.7f, 1.45f, 4.0f}, {0.14f, 0.54f, -0.12f}, 27.5f);
  add_camera(scene, "side", {0.1f, 1.0f, 7.2f}, {0.02f, 0.62f, 0}, 27);
  add_camera(scene, "rear", {-4.6f, 1.9f, 3.9f}, {-0.05f, 0.58f, 0}, 29);
  update_bounds(scene);
  return scene;
}

}  // namespace halflight
