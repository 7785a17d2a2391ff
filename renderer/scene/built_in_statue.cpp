// The first scene of Wang & Åkerlund 2009, figure 4: a glossy classical statue of 64K faces under an
// environment, on matt ground. Theirs is a scan of Hebe, the cupbearer of the gods; this one is hers too, as
// a distance field.
#include <algorithm>

#include "scene/built_in_lit.h"
#include "scene/built_in_rotunda.h"
#include "scene/built_in_scenes.h"
#include "scene/implicit_mesh.h"

namespace halflight {

namespace {

// Metres; y = 0 is the top of the pedestal, and she faces +z. Her right is −x.

float carve(float solid, float tool, float width) { return -blend_union(-solid, tool, width); }

/// `field` where p is near the ball that holds it; farther off the distance to the ball, which is less.
template <class Distance>
float within(Vec3 p, Vec3 centre, float radius, const Distance& field) {
  const float outside = glm::length(p - centre) - radius;
  return outside > 0.05f ? outside : field(p);
}

/// Ridge of a fold over `angle`: round on top, a crease between.
float fold(float angle) { return 1 - std::abs(std::sin(0.5f * angle)); }

/// Height of the cloth's folds about the vertical axis: many at the hem, fewer and softer above.
float drapery(Vec3 p, float count, float phase) {
  const float angle = std::atan2(p.x, p.z);
  const float sway = 0.9f * gradient_noise({2.2f * p.x, 1.3f * p.y, 2.2f * p.z}, 7) + phase + 0.8f * p.y;
  const float broad = fold(count * angle + 3 * sway);
  const float fine = fold(2.0f * count * angle + 5 * sway + 1);
  return 0.75f * broad * broad + 0.25f * fine;
}

/// A robe's layer between two heights: an elliptic cone with folds that deepen towards its hem.
struct Robe {
  float top, hem, top_radius, hem_radius, folds, depth, phase;
  Vec2 lean;  ///< of the hem's centre, x and z
};

float robe_distance(Vec3 p, const Robe& robe) {
  const float t = std::clamp((robe.top - p.y) / (robe.top - robe.hem), 0.0f, 1.0f);
  const Vec2 centre = robe.lean * t;
  const Vec3 q(p.x - centre.x, p.y, p.z - centre.y);
  const float radius = glm::mix(robe.top_radius, robe.hem_radius, t * (0.55f + 0.45f * t));
  const float around = glm::length(Vec2(q.x / 1.12f, q.z / 0.92f));
  float side = around - radius;
  if (side < 0.08f)
    side -= robe.depth * glm::smoothstep(0.0f, 0.75f, t) * (drapery(q, robe.folds, robe.phase) - 0.5f);
  // The hem rises and falls with the folds.
  const float hem = robe.hem + 0.012f * std::sin(robe.folds * std::atan2(q.x, q.z));
  const float ends = std::max(p.y - robe.top, hem - p.y);
  return 0.8f * -blend_union(-side, -ends, 0.012f);
}

float body_distance(Vec3 p) {
  float body = ellipsoid_distance(p, {0.012f, 0.98f, -0.005f}, {0.168f, 0.14f, 0.125f});
  body = blend_union(body, rod_distance(p, {0.008f, 1.0f, 0}, {0, 1.2f, -0.005f}, 0.128f, 0.118f), 0.08f);
  body = blend_union(body, ellipsoid_distance(p, {0, 1.29f, -0.012f}, {0.148f, 0.14f, 0.102f}), 0.06f);
  for (const float x : {-0.068f, 0.068f})
    body = blend_union(body, ellipsoid_distance(p, {x, 1.262f, 0.078f}, {0.056f, 0.058f, 0.05f}), 0.03f);
  body = blend_union(
      body, rod_distance(p, {-0.155f, 1.405f, -0.02f}, {0.155f, 1.385f, -0.02f}, 0.052f, 0.052f), 0.06f);
  // The girdle, and folds of the bodice that run to the shoulders.
  if (body < 0.06f && p.y > 1.1f && p.y < 1.42f) {
    const float bodice = glm::smoothstep(1.1f, 1.16f, p.y) * (1 - glm::smoothstep(1.34f, 1.42f, p.y));
    const float across = p.x + 0.25f * p.x * (1.42f - p.y) / 0.3f;
    body -= 0.016f * bodice * (fold(150 * across + 4 * gradient_noise(5.0f * p, 5)) - 0.5f);
  }
  const float belt = std::max(std::abs(p.y - 1.128f) - 0.014f, body - 0.010f);
  return blend_union(body, belt, 0.006f);
}

float arm_distance(Vec3 p, Vec3 shoulder, Vec3 elbow, Vec3 hand) {
  float arm = rod_distance(p, shoulder, elbow, 0.05f, 0.037f);
  const Vec3 belly = glm::mix(elbow, hand, 0.28f);
  arm = blend_union(arm, rod_distance(p, elbow, belly, 0.036f, 0.037f), 0.015f);
  return blend_union(arm, rod_distance(p, belly, hand, 0.037f, 0.022f), 0.02f);
}

/// A hand closed about something: a palm and four fingers that run along `way` to both sides of `axis`.
float hand_distance(Vec3 p, Vec3 palm, Vec3 way, Vec3 axis) {
  float hand = rod_distance(p, palm - 0.026f * axis, palm + 0.026f * axis, 0.026f, 0.025f);
  for (int i = 0; i < 4; ++i) {
    const Vec3 knuckle = palm + (0.033f - 0.021f * static_cast<float>(i)) * axis + 0.022f * way;
    const Vec3 bend = knuckle + 0.034f * way;
    hand = blend_union(hand, rod_distance(p, knuckle, bend, 0.0125f, 0.011f), 0.006f);
  }
  return blend_union(
      hand, rod_distance(p, palm + 0.03f * axis, palm + 0.05f * axis + 0.03f * way, 0.013f, 0.01f), 0.008f);
}

float face_distance(Vec3 m) {
  float head = ellipsoid_distance(m, {0, 1.635f, -0.012f}, {0.078f, 0.102f, 0.096f});
  head = blend_union(head, ellipsoid_distance(m, {0, 1.578f, 0.035f}, {0.050f, 0.052f, 0.048f}), 0.035f);
  head = blend_union(head, ellipsoid_distance(m, {0, 1.545f, 0.056f}, {0.024f, 0.019f, 0.021f}), 0.02f);
  head = blend_union(head, ellipsoid_distance(m, {0.042f, 1.605f, 0.048f}, {0.024f, 0.026f, 0.022f}), 0.025f);
  head = carve(head, ellipsoid_distance(m, {0.034f, 1.634f, 0.094f}, {0.025f, 0.014f, 0.022f}), 0.016f);
  head = blend_union(
      head, rod_distance(m, {0.012f, 1.652f, 0.080f}, {0.055f, 1.651f, 0.062f}, 0.007f, 0.006f), 0.012f);
  head = blend_union(head, ellipsoid_distance(m, {0.033f, 1.633f, 0.069f}, {0.016f, 0.011f, 0.013f}), 0.003f);
  head = blend_union(head, rod_distance(m, {0, 1.652f, 0.080f}, {0, 1.600f, 0.101f}, 0.007f, 0.010f), 0.012f);
  head = blend_union(head, ellipsoid_distance(m, {0.009f, 1.597f, 0.089f}, {0.009f, 0.007f, 0.010f}), 0.006f);
  head = blend_union(head, ellipsoid_distance(m, {0.006f, 1.574f, 0.083f}, {0.018f, 0.006f, 0.009f}), 0.004f);
  return blend_union(head, ellipsoid_distance(m, {0, 1.564f, 0.081f}, {0.016f, 0.006f, 0.009f}), 0.004f);
}

/// Waved hair, parted in the middle, with a knot behind and a band.
float hair_distance(Vec3 m) {
  float hair = ellipsoid_distance(m, {0, 1.662f, -0.030f}, {0.088f, 0.095f, 0.098f});
  hair = blend_union(hair, ellipsoid_distance(m, {0.048f, 1.655f, 0.018f}, {0.043f, 0.052f, 0.055f}), 0.02f);
  const float knot = ellipsoid_distance(m, {0, 1.652f, -0.140f}, {0.048f, 0.046f, 0.045f});
  hair = blend_union(hair, knot, 0.02f);
  if (hair < 0.05f) {
    const float strand =
        130 * (m.y - 1.62f) + 65 * std::abs(m.x) - 70 * m.z + 3.0f * gradient_noise(16.0f * m, 3);
    hair -= 0.008f * (fold(strand) - 0.5f);
  }
  // Off the face.
  hair = carve(hair, ellipsoid_distance(m, {0, 1.598f, 0.105f}, {0.062f, 0.098f, 0.075f}), 0.012f);
  const float band = std::max(std::abs(m.y - 1.678f - 0.45f * (m.z + 0.03f)) - 0.008f, hair - 0.007f);
  return blend_union(hair, band, 0.004f);
}

/// The head, turned a little to her left and bent.
float head_distance(Vec3 p) {
  const Vec3 neck(0, 1.5f, -0.01f);
  const Mat4 turn_back = turn(-0.38f, {0, 1, 0}) * turn(0.10f, {0, 0, 1}) * turn(-0.10f, {1, 0, 0});
  const Vec3 q = neck + Vec3(turn_back * Vec4(p - neck, 0));
  const Vec3 m(std::abs(q.x), q.y, q.z);
  return blend_union(face_distance(m), hair_distance(m), 0.006f);
}

constexpr Vec3 right_hand{-0.335f, 1.700f, 0.160f}, left_hand{0.262f, 1.150f, 0.300f};

float jug_distance(Vec3 p) {
  const Vec3 q = p - (right_hand + Vec3(-0.005f, 0.085f, 0.05f));
  float jug = ellipsoid_distance(q, Vec3(0), {0.062f, 0.080f, 0.062f});
  jug = blend_union(jug, rod_distance(q, {0, 0.05f, 0}, {0, 0.135f, 0}, 0.030f, 0.026f), 0.03f);
  jug = blend_union(jug, ellipsoid_distance(q, {0, 0.150f, 0.012f}, {0.038f, 0.014f, 0.050f}), 0.012f);
  jug = carve(jug, ellipsoid_distance(q, {0, 0.172f, 0.014f}, {0.028f, 0.022f, 0.038f}), 0.005f);
  jug = blend_union(jug, ellipsoid_distance(q, {0, -0.085f, 0}, {0.040f, 0.014f, 0.040f}), 0.012f);
  float handle = rod_distance(q, {0, 0.145f, -0.035f}, {0, 0.125f, -0.085f}, 0.008f, 0.008f);
  handle =
      blend_union(handle, rod_distance(q, {0, 0.125f, -0.085f}, {0, 0.0f, -0.062f}, 0.008f, 0.009f), 0.01f);
  return blend_union(jug, handle, 0.008f);
}

float bowl_distance(Vec3 p) {
  const Vec3 q = p - (left_hand + Vec3(-0.005f, 0.055f, 0.035f));
  float bowl = ellipsoid_distance(q, Vec3(0), {0.104f, 0.048f, 0.104f});
  bowl = carve(bowl, ellipsoid_distance(q, {0, 0.032f, 0}, {0.088f, 0.042f, 0.088f}), 0.004f);
  bowl = std::max(bowl, q.y - 0.022f);
  return blend_union(bowl, rod_distance(q, {0, -0.03f, 0}, {0, -0.055f, 0}, 0.022f, 0.034f), 0.015f);
}

float right_hand_distance(Vec3 p) {
  return blend_union(hand_distance(p, right_hand, {0.1f, 0.2f, 0.97f}, {0, 1, 0}), jug_distance(p), 0.004f);
}

float left_hand_distance(Vec3 p) {
  return blend_union(hand_distance(p, left_hand, {-0.1f, 0.12f, 0.98f}, {1, 0, 0}), bowl_distance(p), 0.004f);
}

float legs_distance(Vec3 p) {
  // Her weight is on the right leg; the left knee pushes the cloth forward.
  float legs = rod_distance(p, {0.085f, 0.95f, 0}, {0.105f, 0.56f, 0.135f}, 0.100f, 0.074f);
  legs = blend_union(legs, rod_distance(p, {0.105f, 0.56f, 0.135f}, {0.115f, 0.10f, 0.03f}, 0.074f, 0.055f),
                     0.05f);
  legs =
      blend_union(legs, rod_distance(p, {-0.075f, 0.95f, 0}, {-0.085f, 0.10f, 0.0f}, 0.105f, 0.07f), 0.06f);
  return legs;
}

float feet_distance(Vec3 p) {
  float feet = rod_distance(p, {-0.080f, 0.030f, 0.13f}, {-0.105f, 0.022f, 0.255f}, 0.032f, 0.024f);
  return std::min(feet, rod_distance(p, {0.115f, 0.034f, 0.12f}, {0.165f, 0.024f, 0.250f}, 0.032f, 0.024f));
}

float figure_distance(Vec3 p) {
  const Robe skirt{1.06f, 0.012f, 0.128f, 0.230f, 13, 0.050f, 0.0f, {0.0f, 0.0f}};
  const Robe overfold{1.14f, 0.80f, 0.128f, 0.198f, 10, 0.034f, 2.0f, {0.012f, 0.0f}};
  float cloth = blend_union(robe_distance(p, skirt), 0.9f * legs_distance(p), 0.075f);
  cloth = blend_union(cloth, robe_distance(p, overfold), 0.010f);
  float figure = blend_union(cloth, body_distance(p), 0.025f);
  figure =
      blend_union(figure, rod_distance(p, {0, 1.40f, -0.02f}, {0.004f, 1.56f, 0.0f}, 0.058f, 0.046f), 0.045f);
  figure = blend_union(figure, within(p, {0, 1.62f, -0.02f}, 0.19f, head_distance), 0.012f);
  figure = blend_union(
      figure, arm_distance(p, {-0.165f, 1.40f, -0.02f}, {-0.375f, 1.455f, 0.035f}, right_hand), 0.035f);
  figure = blend_union(figure, arm_distance(p, {0.165f, 1.385f, -0.02f}, {0.268f, 1.135f, 0.03f}, left_hand),
                       0.035f);
  // Sleeves over the shoulders.
  for (const float side : {-1.0f, 1.0f})
    figure = blend_union(
        figure, ellipsoid_distance(p, {side * 0.175f, 1.385f, -0.015f}, {0.062f, 0.068f, 0.064f}), 0.02f);
  figure =
      blend_union(figure, within(p, right_hand + Vec3(0, 0.09f, 0.04f), 0.19f, right_hand_distance), 0.008f);
  figure =
      blend_union(figure, within(p, left_hand + Vec3(0, 0.03f, 0.03f), 0.17f, left_hand_distance), 0.008f);
  figure = blend_union(figure, feet_distance(p), 0.012f);
  const float base = std::max(std::abs(p.y + 0.02f) - 0.034f, glm::length(Vec2(p.x, p.z)) - 0.335f);
  return blend_union(figure, base, 0.01f);
}

void add_pedestal(Scene& scene) {
  const std::vector<Vec2> profile{{0.50f, -0.62f}, {0.50f, -0.54f},  {0.47f, -0.52f},  {0.445f, -0.48f},
                                  {0.40f, -0.46f}, {0.385f, -0.43f}, {0.375f, -0.16f}, {0.385f, -0.13f},
                                  {0.42f, -0.11f}, {0.44f, -0.085f}, {0.44f, -0.05f},  {0.425f, -0.042f},
                                  {0, -0.042f}};
  place(scene, lathe_mesh(profile, 96),
        add_material(scene, phong_material("pedestal", {0.30f, 0.28f, 0.26f}, Vec3(0), 1)));
}

}  // namespace

Scene make_statue() {
  Scene scene;
  scene.facts.source = "statue";
  Mesh figure = implicit_mesh(figure_distance, {{-0.47f, -0.07f, -0.36f}, {0.40f, 1.97f, 0.44f}}, 0.0118f);
  settle(figure, figure_distance);
  place(scene, figure,
        add_material(scene, phong_material("marble", {0.56f, 0.51f, 0.43f}, {0.24f, 0.24f, 0.23f}, 100)));
  add_pedestal(scene);
  place(scene,
        grid_mesh({16, 16}, [](float u, float v) { return Vec3(12 * (u - 0.5f), -0.62f, 12 * (0.5f - v)); }),
        add_material(scene, phong_material("ground", {0.34f, 0.32f, 0.29f}, Vec3(0), 1)));
  scene.environment = rotunda_environment(768);
  add_camera(scene, "main", {0.70f, 1.10f, 3.75f}, {-0.01f, 0.76f, 0}, 37);
  add_camera(scene, "head", {0.55f, 1.70f, 1.6f}, {-0.02f, 1.45f, 0}, 36);
  update_bounds(scene);
  return scene;
}

}  // namespace halflight
