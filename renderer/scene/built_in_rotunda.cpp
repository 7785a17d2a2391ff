#include "scene/built_in_rotunda.h"

#include "core/parallel.h"

namespace halflight {

namespace {

// Lengths in metres from the eye, in the axis of the hall.
constexpr float radius = 8, floor_y = -1.8f, spring_y = 5.4f;
constexpr int bays = 14;
constexpr float sun_azimuth = 9.5f * 2 * pi / bays;  ///< from −z towards +x: the middle of a bay
constexpr float sun_height = 0.38f;                  ///< tangent of its elevation

float fraction(float x) { return x - std::floor(x); }

/// 1 where |x| < width, 0 outside, soft over `soft`.
float band(float x, float width, float soft) {
  return 1 - glm::smoothstep(width - soft, width + soft, std::abs(x));
}

Vec3 sky(Vec3 d) {
  const float up = glm::clamp(d.y, 0.0f, 1.0f);
  const Vec3 blue = glm::mix(Vec3(1.8f, 1.74f, 1.62f), Vec3(0.45f, 0.95f, 2.4f), std::pow(up, 0.45f));
  // Meadow, and two rows of hills whose outlines close after a turn.
  const float turn = std::atan2(d.x, -d.z);
  const float near =
      0.045f + 0.020f * std::sin(5 * turn + 1) + 0.010f * std::sin(13 * turn) + 0.004f * std::sin(41 * turn);
  const float far = 0.11f + 0.025f * std::sin(3 * turn) + 0.012f * std::sin(11 * turn + 2);
  Vec3 land(0.34f, 0.40f, 0.17f);
  if (d.y > -0.02f) land = d.y < near ? Vec3(0.11f, 0.17f, 0.07f) : Vec3(0.42f, 0.52f, 0.62f);
  const Vec3 sun = glm::normalize(Vec3(std::sin(sun_azimuth), sun_height, -std::cos(sun_azimuth)));
  const float angle = std::acos(glm::clamp(glm::dot(d, sun), -1.0f, 1.0f));
  if (angle < 0.014f) return {2600, 2250, 1750};
  const Vec3 glow = Vec3(14, 11, 7) * std::exp(-angle / 0.10f);
  return glm::mix(land, blue, glm::smoothstep(far - 0.004f, far + 0.004f, d.y)) + glow;
}

Vec3 floor_radiance(Vec3 p) {
  const float r = std::sqrt(p.x * p.x + p.z * p.z), turn = std::atan2(p.x, -p.z) / (2 * pi) + 0.5f;
  const float ring = r / 0.9f, sector = turn * 36;
  const bool pale = (static_cast<int>(ring) + static_cast<int>(sector)) % 2 == 0;
  const float joint = std::max(band(fraction(ring + 0.5f) - 0.5f, 0.025f, 0.01f),
                               band((fraction(sector + 0.5f) - 0.5f) * r * 0.17f, 0.02f, 0.01f));
  const Vec3 stone = pale ? Vec3(0.62f, 0.56f, 0.47f) : Vec3(0.26f, 0.11f, 0.08f);
  // Lighter towards the windows, but not at the foot of the wall.
  const float light = 0.35f + 0.5f * glm::smoothstep(0.5f, 6.0f, r) - 0.45f * glm::smoothstep(6.9f, 8.0f, r);
  return stone * light * (1 - 0.6f * joint);
}

/// Stone of the wall at `along` (−½ to ½ across a bay) and height y.
Vec3 stone_radiance(float along, float y) {
  const float height = (y - floor_y) / (spring_y - floor_y);
  Vec3 color = Vec3(0.58f, 0.47f, 0.35f) * (0.45f + 0.35f * height);
  // Pilasters between the windows, with flutes.
  const float pilaster = std::abs(std::abs(along) - 0.5f);
  if (pilaster < 0.085f && y < 4.45f && y > -1.3f)
    color = Vec3(0.66f, 0.58f, 0.47f) * (0.42f + 0.4f * height) *
            (0.80f + 0.20f * std::cos(2 * pi * 3.5f * pilaster / 0.085f));
  if (y < -1.3f) color = Vec3(0.30f, 0.20f, 0.15f) * (0.5f + 0.3f * height);
  // Entablature and cornice.
  for (const float edge : {-1.3f, 4.45f, 5.26f})
    color = glm::mix(color, Vec3(0.75f, 0.68f, 0.56f) * 0.8f, band(y - edge, 0.09f, 0.02f));
  for (const float edge : {-1.42f, 4.32f, 5.12f}) color *= 1 - 0.5f * band(y - edge, 0.04f, 0.03f);
  return color;
}

Vec3 wall_radiance(Vec3 d, Vec3 p) {
  const float turn = std::atan2(p.x, -p.z) / (2 * pi) + 1;
  const float along = fraction(turn * bays) - 0.5f, x = along * 2 * pi * radius / bays;
  const float half = 1.10f, sill = -0.75f, spring = 2.6f;
  const float top = spring + std::sqrt(std::max(0.0f, half * half - x * x));
  if (std::abs(x) < half && p.y > sill && p.y < top) {
    const bool bar = std::abs(x) < 0.035f || std::abs(p.y - spring) < 0.035f ||
                     std::abs(p.y - 0.9f) < 0.025f || std::abs(std::abs(x) - 0.52f) < 0.018f;
    return bar ? Vec3(0.06f, 0.05f, 0.045f) : sky(d);
  }
  // A pale surround, lit by its window.
  const float out = p.y > spring ? glm::length(Vec2(x, p.y - spring)) - half : std::abs(x) - half;
  const float surround =
      p.y > sill ? band(out, 0.16f, 0.02f) : band(p.y - sill + 0.08f, 0.08f, 0.02f) * band(x, 1.25f, 0.02f);
  return glm::mix(stone_radiance(along, p.y), Vec3(0.95f, 0.86f, 0.72f), 0.75f * surround);
}

Vec3 dome_radiance(Vec3 d, Vec3 from_spring) {
  const float out = std::sqrt(from_spring.x * from_spring.x + from_spring.z * from_spring.z);
  if (out < 1.15f) return sky(d) * 1.4f;
  const float elevation = std::acos(std::min(out / radius, 1.0f)) / (pi / 2);
  const float turn = std::atan2(from_spring.x, -from_spring.z) / (2 * pi) + 1;
  // Five rings of coffers, each a square that steps inwards; the steps that face the eye of the dome are
  // bright.
  const float ring = elevation * 6.6f - 0.35f, across = turn * 2 * bays;
  const Vec2 in(fraction(across) - 0.5f, fraction(ring) - 0.5f);
  const float step = std::max(std::abs(in.x), std::abs(in.y));
  const float light = 0.30f + 0.55f * elevation;
  const bool coffers = ring > 0 && ring < 5;
  Vec3 color = Vec3(0.66f, 0.60f, 0.52f) * light;
  if (coffers && step < 0.38f)
    color = Vec3(0.42f, 0.40f, 0.40f) * light * (in.y < -0.8f * std::abs(in.x) ? 1.5f : 0.7f);
  if (coffers && step < 0.27f)
    color = Vec3(0.34f, 0.36f, 0.42f) * light * (in.y < -0.8f * std::abs(in.x) ? 1.4f : 0.6f);
  if (coffers && step < 0.17f) color = Vec3(0.20f, 0.24f, 0.34f) * light;
  if (coffers && glm::length(in) < 0.07f) color = Vec3(0.95f, 0.70f, 0.25f) * light;
  // Gilded rim of the eye.
  return glm::mix(color, Vec3(1.1f, 0.8f, 0.35f), band(out - 1.25f, 0.10f, 0.02f));
}

Vec3 rotunda_radiance(Vec3 d) {
  const float flat = std::sqrt(d.x * d.x + d.z * d.z);
  const float wall_y = flat > 1e-6f ? d.y * radius / flat : std::copysign(1e6f, d.y);
  if (wall_y < floor_y) return floor_radiance(d * (floor_y / d.y));
  if (wall_y < spring_y) return wall_radiance(d, d * (radius / flat));
  // The dome: a sphere about the middle of the springing.
  const float along = d.y * spring_y;
  const float distance = along + std::sqrt(along * along + radius * radius - spring_y * spring_y);
  return dome_radiance(d, d * distance - Vec3(0, spring_y, 0));
}

}  // namespace

Environment rotunda_environment(int height) {
  Environment layout;
  layout.map = ImageRgb(2 * height, height);
  ImageRgb& map = layout.map;
  parallel_for(0, static_cast<size_t>(height), 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y)
      for (int x = 0; x < map.width; ++x)
        for (const Vec2 shift :
             {Vec2(0.25f, 0.25f), Vec2(0.75f, 0.25f), Vec2(0.25f, 0.75f), Vec2(0.75f, 0.75f)}) {
          const Vec2 uv = (Vec2(x, static_cast<float>(y)) + shift) / Vec2(map.width, map.height);
          map.at(x, static_cast<int>(y)) += 0.25f * rotunda_radiance(environment_direction(layout, uv));
        }
  });
  return make_environment(std::move(map), "rotunda", EnvironmentLayout::latlong);
}

}  // namespace halflight
