// The first scene of Wang & Åkerlund 2009, figure 4: a glossy classical statue of 64K faces under an
// environment, on matt ground. Theirs is a scan of Hebe, the cupbearer of the gods; this one is hers too, as
// a distance field.
#include <algorithm>

#include "scene/built_in_environments.h"
#include "scene/built_in_lit.h"
#include "scene/built_in_scenes.h"
#include "scene/implicit_mesh.h"

namespace halflight {

namespace {

// Metres; y = 0 is the top of the pedestal, and she faces +z. Her right is −x.

float carve(float solid, float tool, float width) { return -blend_union(-solid, tool, width); }
float meet(float a, float b, float width) { return -blend_union(-a, -b, width); }

/// `field` where p is near the ball that holds it; farther off the distance to the ball, which is less.
template <class Distance>
float within(Vec3 p, Vec3 centre, float radius, const Distance& field) {
  const float outside = glm::length(p - centre) - radius;
  return outside > 0.05f ? outside : field(p);
}

/// Height of a fold over its angle, 0 to 1: round on top, a narrow valley between.
float fold(float angle) {
  const float c = std::cos(0.5f * angle);
  return std::sqrt(c * c + 0.03f);
}

// She stands at ease: hips to her right and turned that way, shoulders turned to her left. The upright figure
// below is given in the frame that `at_ease` undoes this to.
constexpr float hip_turn = -0.20f, chest_turn = 0.18f;

Vec3 spun(Vec3 p, float radians) {
  const float c = std::cos(radians), s = std::sin(radians);
  return {c * p.x + s * p.z, p.y, c * p.z - s * p.x};
}

Vec3 at_ease(Vec3 p) {
  const float sway = -0.045f * glm::smoothstep(0.25f, 0.92f, p.y) * (1 - glm::smoothstep(0.95f, 1.38f, p.y));
  p.x -= sway;
  return spun(p, -glm::mix(hip_turn, chest_turn, glm::smoothstep(0.85f, 1.38f, p.y)));
}

/// The left thigh and shin under the cloth: her weight is on the right leg.
float free_leg_distance(Vec3 p) {
  const float thigh = rod_distance(p, {0.085f, 0.95f, 0.01f}, {0.105f, 0.55f, 0.145f}, 0.102f, 0.074f);
  return blend_union(thigh, rod_distance(p, {0.105f, 0.55f, 0.145f}, {0.125f, 0.08f, 0.04f}, 0.074f, 0.052f),
                     0.05f);
}

/// Hips, legs and the cone of the skirt, without folds.
float lower_distance(Vec3 p, float free_leg) {
  const float t = glm::clamp((1.10f - p.y) / 1.10f, 0.0f, 1.0f);
  const float flare = 0.03f * std::exp(-14 * std::max(p.y, 0.0f));
  const float radius = glm::mix(0.118f, 0.196f, t * (0.7f + 0.3f * t)) + flare;
  float d = meet(glm::length(Vec2(p.x / 1.10f, p.z / 0.95f)) - radius, p.y - 1.12f, 0.03f);
  d = blend_union(d, ellipsoid_distance(p, {0, 0.95f, -0.012f}, {0.172f, 0.17f, 0.138f}), 0.07f);
  d = blend_union(d, rod_distance(p, {-0.075f, 0.95f, 0}, {-0.085f, 0.10f, 0}, 0.108f, 0.07f), 0.07f);
  return blend_union(d, free_leg, 0.06f);
}

/// The chiton's skirt: upright folds of uneven width that deepen towards the hem, and lie flat on the free
/// leg.
float skirt_distance(Vec3 p, float lower, float free_leg) {
  if (lower > 0.12f) return lower - 0.06f;
  const float angle = std::atan2(p.x, p.z);
  const float uneven = angle + 0.20f * std::sin(2 * angle + 0.6f) + 0.11f * std::sin(5 * angle + 1.1f + p.y);
  const float phase = 12 * uneven + 1.2f * gradient_noise({3 * p.x, 1.6f * p.y, 3 * p.z}, 7);
  const float height = 0.78f * fold(phase) + 0.22f * fold(2 * phase + 1.3f);
  const float taut = 1 - 0.85f * (1 - glm::smoothstep(0.015f, 0.075f, free_leg));
  const float depth = glm::mix(0.010f, 0.058f, glm::smoothstep(1.0f, 0.1f, p.y)) * taut;
  const float hem = 0.010f + 0.045f * glm::smoothstep(0.3f, 1.0f, std::cos(angle));
  return meet(lower - depth * (height - 0.45f), hem - p.y, 0.014f);
}

/// The mantle about the hips: a twisted roll, and below it cloth in swags that hang from her left hip to her
/// right thigh.
float mantle_distance(Vec3 p, float lower) {
  if (lower > 0.14f) return lower - 0.08f;
  const float angle = std::atan2(p.x, p.z);
  const float roll_y = 1.000f + 0.065f * std::sin(angle + 0.1f);
  const float sag = 0.95f + 1.25f * square(0.5f + 0.5f * std::cos(angle + 0.45f));
  const float noise = gradient_noise(4.0f * p, 11);
  const float drop = (roll_y - p.y) / sag;  // 0 at the roll, about 0.24 at the hem
  const float swag = square(square(std::cos(pi * drop / 0.052f + 0.9f * noise + 0.5f * std::sin(2 * angle))));
  const float depth = 0.021f * glm::smoothstep(0.0f, 0.06f, drop) * (1 + 0.5f * noise);
  const float out = lower - 0.020f - depth * (swag - 0.2f);
  const float end = 0.245f + 0.020f * noise - 0.02f * swag;
  const float cloth = meet(out, 0.8f * sag * std::max(drop - end, -0.03f - drop), 0.010f);
  // The roll, like a rope of cloth.
  const Vec2 across(lower - 0.016f, p.y - roll_y);
  const float twist = 2 * std::atan2(across.y, across.x) + 9 * angle + 2 * noise;
  const float roll = 0.8f * (glm::length(across) - 0.028f - 0.014f * (fold(twist) - 0.5f));
  return blend_union(cloth, roll, 0.012f);
}

float torso_distance(Vec3 p) {
  float torso = ellipsoid_distance(p, {0, 0.97f, -0.005f}, {0.160f, 0.14f, 0.120f});
  torso = blend_union(torso, rod_distance(p, {0, 1.0f, 0}, {0, 1.2f, -0.005f}, 0.118f, 0.112f), 0.08f);
  torso = blend_union(torso, ellipsoid_distance(p, {0, 1.29f, -0.014f}, {0.142f, 0.15f, 0.100f}), 0.06f);
  const Vec3 m(std::abs(p.x), p.y, p.z);
  torso =
      blend_union(torso, ellipsoid_distance(m, {0.066f, 1.266f, 0.070f}, {0.055f, 0.058f, 0.052f}), 0.025f);
  torso = blend_union(torso, rod_distance(m, {0, 1.395f, -0.025f}, {0.150f, 1.395f, -0.022f}, 0.050f, 0.048f),
                      0.06f);
  // Neck, and the muscles from it to the shoulders.
  torso = blend_union(
      torso, rod_distance(m, {0.012f, 1.47f, -0.035f}, {0.12f, 1.415f, -0.03f}, 0.038f, 0.036f), 0.05f);
  return blend_union(torso, rod_distance(p, {0, 1.40f, -0.022f}, {0, 1.57f, 0}, 0.054f, 0.047f), 0.04f);
}

/// The chiton above the hips: gathered under a high belt, open at the neck, pinned on the shoulders.
float bodice_distance(Vec3 p, float torso) {
  if (torso > 0.08f) return torso - 0.03f;
  const float neckline = 1.318f + 6.5f * p.x * p.x + (p.z < -0.03f ? 0.05f : 0.0f);
  const float noise = gradient_noise(6.0f * p, 5);
  const float fan = p.x * (1 + 0.9f * (1.40f - p.y) * glm::smoothstep(1.16f, 1.30f, p.y));
  const float gathered = fold(165 * fan + 1.8f * noise + (p.z < -0.03f ? 1.5f : 0.0f));
  const float below = neckline - p.y;
  const float middle = std::exp(-square(p.x / 0.055f)) * glm::smoothstep(1.17f, 1.21f, p.y);
  const float swag = fold(2 * pi * below / 0.036f + noise);
  const float height =
      glm::mix(0.013f * gathered, 0.011f * swag, middle) * glm::smoothstep(0.0f, 0.03f, below);
  const float cloth = meet(torso - 0.006f - height, -0.6f * below, 0.008f);
  const float belt = meet(std::abs(p.y - 1.172f) - 0.013f, torso - 0.020f, 0.006f);
  return blend_union(cloth, belt, 0.006f);
}

float arm_distance(Vec3 p, Vec3 shoulder, Vec3 elbow, Vec3 hand) {
  float arm = rod_distance(p, shoulder, elbow, 0.050f, 0.036f);
  arm = blend_union(arm, glm::length(p - glm::mix(shoulder, elbow, 0.12f)) - 0.055f, 0.03f);
  const Vec3 belly = glm::mix(elbow, hand, 0.28f);
  arm = blend_union(arm, rod_distance(p, elbow, belly, 0.035f, 0.037f), 0.015f);
  return blend_union(arm, rod_distance(p, belly, hand, 0.037f, 0.022f), 0.02f);
}

/// A hand closed about something: a palm and four fingers that run along `way` to both sides of `axis`.
float hand_distance(Vec3 p, Vec3 palm, Vec3 way, Vec3 axis) {
  float hand = rod_distance(p, palm - 0.022f * axis, palm + 0.022f * axis, 0.024f, 0.023f);
  for (int i = 0; i < 4; ++i) {
    const Vec3 knuckle = palm + (0.031f - 0.020f * static_cast<float>(i)) * axis + 0.020f * way;
    hand = blend_union(hand, rod_distance(p, knuckle, knuckle + 0.040f * way, 0.0115f, 0.009f), 0.005f);
  }
  return blend_union(
      hand, rod_distance(p, palm + 0.025f * axis, palm + 0.05f * axis + 0.035f * way, 0.012f, 0.009f),
      0.008f);
}

float face_distance(Vec3 m) {
  float head = ellipsoid_distance(m, {0, 1.635f, -0.012f}, {0.078f, 0.102f, 0.096f});
  head = blend_union(head, ellipsoid_distance(m, {0, 1.578f, 0.035f}, {0.050f, 0.052f, 0.048f}), 0.035f);
  head = blend_union(head, ellipsoid_distance(m, {0, 1.545f, 0.056f}, {0.024f, 0.019f, 0.021f}), 0.02f);
  head = blend_union(head, ellipsoid_distance(m, {0.042f, 1.605f, 0.048f}, {0.024f, 0.026f, 0.022f}), 0.025f);
  head = carve(head, ellipsoid_distance(m, {0.034f, 1.634f, 0.097f}, {0.025f, 0.013f, 0.022f}), 0.014f);
  head = blend_union(
      head, rod_distance(m, {0.012f, 1.652f, 0.080f}, {0.055f, 1.651f, 0.062f}, 0.007f, 0.006f), 0.012f);
  head =
      blend_union(head, ellipsoid_distance(m, {0.033f, 1.632f, 0.0665f}, {0.019f, 0.0105f, 0.0135f}), 0.004f);
  head = blend_union(head, rod_distance(m, {0, 1.652f, 0.080f}, {0, 1.600f, 0.101f}, 0.007f, 0.010f), 0.012f);
  head = blend_union(head, ellipsoid_distance(m, {0.009f, 1.597f, 0.089f}, {0.009f, 0.007f, 0.010f}), 0.006f);
  head = blend_union(head, ellipsoid_distance(m, {0.006f, 1.574f, 0.079f}, {0.018f, 0.006f, 0.009f}), 0.004f);
  return blend_union(head, ellipsoid_distance(m, {0, 1.564f, 0.078f}, {0.016f, 0.006f, 0.009f}), 0.004f);
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

constexpr Vec3 right_shoulder{-0.158f, 1.402f, 0.006f}, right_elbow{-0.380f, 1.490f, 0.100f},
    right_hand{-0.425f, 1.755f, 0.165f};
constexpr Vec3 left_shoulder{0.154f, 1.392f, -0.050f}, left_elbow{0.250f, 1.140f, -0.010f},
    left_hand{0.190f, 1.165f, 0.235f};

/// The jug, its handle in her right hand, tilted to pour to her left.
float jug_distance(Vec3 p) {
  const Vec3 grip(-0.097f, 0.015f, 0);
  const Mat4 turn_back = turn(0.40f, {0, 0, 1}) * turn(0.25f, {0, 1, 0});
  const Vec3 q = grip + Vec3(turn_back * Vec4(p - right_hand - Vec3(0.006f, 0, 0.028f), 0));
  float jug = ellipsoid_distance(q, Vec3(0), {0.060f, 0.080f, 0.060f});
  jug = blend_union(jug, rod_distance(q, {0, 0.05f, 0}, {0, 0.125f, 0}, 0.028f, 0.025f), 0.03f);
  jug = blend_union(jug, ellipsoid_distance(q, {0.014f, 0.142f, 0}, {0.050f, 0.015f, 0.036f}), 0.012f);
  jug = carve(jug, ellipsoid_distance(q, {0.018f, 0.164f, 0}, {0.040f, 0.024f, 0.027f}), 0.005f);
  jug = blend_union(jug, ellipsoid_distance(q, {0, -0.086f, 0}, {0.038f, 0.013f, 0.038f}), 0.012f);
  float handle = rod_distance(q, {-0.024f, 0.138f, 0}, {-0.084f, 0.128f, 0}, 0.008f, 0.008f);
  handle =
      blend_union(handle, rod_distance(q, {-0.084f, 0.128f, 0}, {-0.098f, 0.02f, 0}, 0.008f, 0.008f), 0.01f);
  handle =
      blend_union(handle, rod_distance(q, {-0.098f, 0.02f, 0}, {-0.050f, -0.03f, 0}, 0.008f, 0.009f), 0.01f);
  return blend_union(jug, handle, 0.008f);
}

/// A shallow cup on a foot, on her left hand.
float cup_distance(Vec3 p) {
  const Vec3 q = p - (left_hand + Vec3(-0.012f, 0.085f, 0.045f));
  float cup = ellipsoid_distance(q, Vec3(0), {0.092f, 0.048f, 0.092f});
  cup = carve(cup, ellipsoid_distance(q, {0, 0.028f, 0}, {0.079f, 0.045f, 0.079f}), 0.004f);
  cup = meet(cup, q.y - 0.020f, 0.004f);
  cup = blend_union(cup, rod_distance(q, {0, -0.03f, 0}, {0, -0.062f, 0}, 0.016f, 0.016f), 0.018f);
  return blend_union(cup, ellipsoid_distance(q, {0, -0.072f, 0}, {0.036f, 0.012f, 0.036f}), 0.010f);
}

float right_arm_distance(Vec3 p) {
  const float arm = arm_distance(p, right_shoulder, right_elbow, right_hand);
  const float hand =
      hand_distance(p, right_hand, {0.25f, 0.10f, 0.96f}, glm::normalize(Vec3(0.35f, 0.93f, -0.1f)));
  return blend_union(blend_union(arm, hand, 0.014f), jug_distance(p), 0.004f);
}

float left_arm_distance(Vec3 p) {
  const float arm = arm_distance(p, left_shoulder, left_elbow, left_hand);
  const float hand = hand_distance(p, left_hand, glm::normalize(Vec3(-0.35f, 0.15f, 0.92f)),
                                   glm::normalize(Vec3(0.93f, 0.1f, 0.35f)));
  return blend_union(blend_union(arm, hand, 0.014f), cup_distance(p), 0.004f);
}

/// The mantle's end over the left forearm, in pipes of cloth side by side: gathered above, uneven below.
float hanging_distance(Vec3 p) {
  constexpr float hems[] = {0.60f, 0.51f, 0.55f, 0.46f, 0.58f};
  float cloth = rod_distance(p, {0.212f, 1.155f, 0.125f}, {0.268f, 1.150f, 0.035f}, 0.046f, 0.046f);
  for (int i = 0; i < 5; ++i) {
    const float side = 0.5f * static_cast<float>(i) - 1;  // -1 to 1
    const float out = (i % 2 == 0 ? 1.0f : -1.0f);
    const Vec3 above(0.245f + 0.040f * side, 1.15f, 0.090f - 0.050f * side);
    const Vec3 below(0.262f + 0.068f * side + 0.012f * out, hems[i], 0.085f - 0.060f * side + 0.012f * out);
    const float sway = 0.014f * std::sin(7 * p.y + 0.9f * static_cast<float>(i));
    const float pipe = rod_distance(p + Vec3(sway, 0, 0), above, below, 0.020f, 0.033f);
    cloth = blend_union(cloth, meet(pipe, hems[i] - p.y, 0.008f), 0.008f);
  }
  return cloth;
}

float feet_distance(Vec3 p) {
  const float right = rod_distance(p, {-0.080f, 0.030f, 0.13f}, {-0.130f, 0.024f, 0.255f}, 0.034f, 0.026f);
  return std::min(right, rod_distance(p, {0.115f, 0.034f, 0.12f}, {0.130f, 0.026f, 0.285f}, 0.034f, 0.026f));
}

float figure_distance(Vec3 p) {
  const Vec3 q = at_ease(p);
  float figure = infinity;
  if (p.y < 1.30f) {
    const float free_leg = free_leg_distance(q), lower = lower_distance(q, free_leg);
    figure = blend_union(skirt_distance(q, lower, free_leg), mantle_distance(q, lower), 0.008f);
    figure = blend_union(figure, within(p, {0.262f, 0.82f, 0.075f}, 0.38f, hanging_distance), 0.012f);
    figure = blend_union(figure, feet_distance(q), 0.010f);
    const float base = meet(std::abs(p.y + 0.02f) - 0.034f, glm::length(Vec2(p.x, p.z)) - 0.335f, 0.008f);
    figure = blend_union(figure, base, 0.01f);
  }
  if (p.y > 0.90f) {
    const float torso = torso_distance(q);
    figure = blend_union(figure, blend_union(torso, bodice_distance(q, torso), 0.003f), 0.012f);
    figure = blend_union(figure, within(p, {0, 1.62f, -0.02f}, 0.19f, head_distance), 0.012f);
    figure = blend_union(figure, within(p, {-0.27f, 1.62f, 0.14f}, 0.36f, right_arm_distance), 0.02f);
    figure = blend_union(figure, within(p, {0.20f, 1.24f, 0.09f}, 0.30f, left_arm_distance), 0.02f);
  }
  return figure;
}

/// Cubes shrink upwards: a head wants finer ones than a skirt. From the grid's frame to the figure's.
Vec3 from_grid(Vec3 g) {
  constexpr float below = 0.85f, over = 0.75f, finest = 0.55f;
  const float t = glm::clamp((g.y - below) / over, 0.0f, 1.0f);
  const float scale = 1 - (1 - finest) * glm::smoothstep(0.0f, 1.0f, t);
  const float beyond = std::max(g.y - below - over, 0.0f);
  return {scale * g.x, g.y - (1 - finest) * (over * t * t * t * (1 - 0.5f * t) + beyond), scale * g.z};
}

void add_figure(Scene& scene) {
  const auto on_grid = [](Vec3 g) { return figure_distance(from_grid(g)); };
  Mesh figure = implicit_mesh(on_grid, {{-0.85f, -0.07f, -0.40f}, {0.65f, 2.55f, 0.65f}}, 0.0158f);
  for (Vertex& v : figure.vertices) v.position = from_grid(v.position);
  settle(figure, figure_distance);
  place(scene, figure,
        add_material(scene, phong_material("marble", {0.64f, 0.61f, 0.56f}, {0.22f, 0.22f, 0.215f}, 100)));
}

void add_pedestal(Scene& scene) {
  const std::vector<Vec2> profile{{0.50f, -0.62f}, {0.50f, -0.54f},  {0.47f, -0.52f},  {0.445f, -0.48f},
                                  {0.40f, -0.46f}, {0.385f, -0.43f}, {0.375f, -0.16f}, {0.385f, -0.13f},
                                  {0.42f, -0.11f}, {0.44f, -0.085f}, {0.44f, -0.05f},  {0.425f, -0.042f},
                                  {0, -0.042f}};
  place(scene, lathe_mesh(profile, 96),
        add_material(scene, phong_material("pedestal", {0.30f, 0.28f, 0.26f}, Vec3(0), 1)));
}

/// The ground, and behind her a parapet that reaches up to the horizon of the camera.
void add_terrace(Scene& scene) {
  constexpr float ground = -0.62f, length = 12;
  const uint32_t paving = add_material(scene, phong_material("ground", {0.34f, 0.32f, 0.29f}, Vec3(0), 1));
  place(scene,
        grid_mesh({16, 16},
                  [](float u, float v) { return Vec3(length * (u - 0.5f), ground, length * (0.5f - v)); }),
        paving);
  const uint32_t stone = add_material(scene, phong_material("parapet", {0.40f, 0.37f, 0.33f}, Vec3(0), 1));
  const auto course = [&](float low, float high, float depth) {
    place(scene, box_mesh({length, high - low, depth}, 0.012f, 1), stone,
          move({0, ground + 0.5f * (low + high), -2.4f}));
  };
  course(0, 0.16f, 0.40f);
  course(0.16f, 0.90f, 0.28f);
  course(0.90f, 1.02f, 0.42f);
}

}  // namespace

Scene make_statue() {
  Scene scene;
  scene.facts.source = "statue";
  add_figure(scene);
  add_pedestal(scene);
  add_terrace(scene);
  scene.environment = make_built_in_environment("sunset");
  scene.environment.rotation = glm::radians(92.0f);
  scene.environment.strength = 1.6f;
  add_camera(scene, "main", {0.66f, 0.40f, 3.85f}, {-0.03f, 0.72f, 0}, 37);
  add_camera(scene, "head", {0.55f, 1.70f, 1.6f}, {-0.02f, 1.45f, 0}, 36);
  update_bounds(scene);
  return scene;
}

}  // namespace halflight
