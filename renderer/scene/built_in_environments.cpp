#include "scene/built_in_environments.h"

#include "core/errors.h"
#include "core/parallel.h"
#include "core/random.h"

namespace halflight {

namespace {

constexpr int map_height = 256;

/// A map whose texels are each the mean of `radiance(direction)` at 3 × 3 places in it.
template <class Radiance>
Environment computed_map(const char* name, Radiance&& radiance) {
  constexpr int pieces = 3;
  Environment layout;
  layout.map = ImageRgb(2 * map_height, map_height);
  ImageRgb& map = layout.map;
  parallel_for(0, static_cast<size_t>(map.height), 8, [&](size_t begin, size_t end) {
    for (size_t y = begin; y < end; ++y)
      for (int x = 0; x < map.width; ++x) {
        Vec3 sum(0);
        for (int piece = 0; piece < pieces * pieces; ++piece) {
          const Vec2 shift = (Vec2(piece % pieces, piece / pieces) + 0.5f) / static_cast<float>(pieces);
          const Vec2 uv = (Vec2(x, static_cast<float>(y)) + shift) / Vec2(map.width, map.height);
          sum += radiance(environment_direction(layout, uv));
        }
        map.at(x, static_cast<int>(y)) = sum / static_cast<float>(pieces * pieces);
      }
  });
  return make_environment(std::move(map), name, EnvironmentLayout::latlong);
}

/// Azimuth from −z towards +x and elevation, in degrees, as a direction.
Vec3 direction_at(float azimuth, float elevation) {
  const float a = glm::radians(azimuth), e = glm::radians(elevation);
  return {std::cos(e) * std::sin(a), std::sin(e), -std::cos(e) * std::cos(a)};
}

float angle_between(Vec3 a, Vec3 b) { return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)); }

/// Sets every texel whose centre lies within `radius` (radians) of `towards`, and the one that holds it, to
/// `radiance`.
void add_disc(Environment& environment, Vec3 towards, float radius, Vec3 radiance) {
  ImageRgb& map = environment.map;
  const Vec2 size(map.width, map.height), centre = environment_uv(environment, towards) * size;
  const int row = std::min(static_cast<int>(centre.y), map.height - 1);
  const int rows = static_cast<int>(radius / pi * size.y) + 1;
  for (int y = std::max(row - rows, 0); y <= std::min(row + rows, map.height - 1); ++y)
    for (int x = 0; x < map.width; ++x) {
      const Vec3 d = environment_direction(environment, (Vec2(x, y) + 0.5f) / size);
      const bool holds = y == row && x == static_cast<int>(centre.x);
      if (holds || angle_between(d, towards) < radius) map.at(x, y) = radiance;
    }
}

Environment make_uniform() {
  return computed_map("uniform", [](Vec3) { return Vec3(1); });
}

/// Moon & Spencer 1942 (the CIE's standard overcast sky), three times as bright at the zenith as at the
/// horizon, with a brighter break about the zenith; the ground reflects a sixth.
Environment make_overcast() {
  return computed_map("overcast", [](Vec3 d) {
    const Vec3 zenith(1.90f, 1.98f, 2.10f), earth(0.19f, 0.175f, 0.15f);
    const float up = std::max(d.y, 0.0f);
    const Vec3 sky = zenith * (1 + 2 * up) / 3.0f;
    const Vec3 thinner = Vec3(2.4f, 2.2f, 1.9f) * std::pow(up, 12.0f);
    const Vec3 ground = earth * (1 + 0.8f * std::exp(8 * std::min(d.y, 0.0f)));
    return glm::mix(ground, sky + thinner, glm::smoothstep(-0.012f, 0.012f, d.y));
  });
}

Vec3 sunset_sky(Vec3 d, Vec3 sun) {
  const float up = std::max(d.y, 0.0f), angle = angle_between(d, sun),
              nearness = 0.5f + 0.5f * glm::dot(d, sun);
  const Vec3 high(0.07f, 0.13f, 0.33f), band(0.95f, 0.36f, 0.13f), away(0.30f, 0.20f, 0.30f);
  const Vec3 low = glm::mix(away, band, nearness * nearness);
  Vec3 color = glm::mix(low, high, 1 - std::exp(-4.5f * up));
  color += Vec3(3.2f, 1.25f, 0.32f) * std::exp(-angle / 0.16f) + Vec3(14, 7, 2) * std::exp(-angle / 0.045f);
  // Strips of cloud, lit from below towards the sun.
  const float strip = std::sin(38 * d.y + 1.6f * std::sin(3 * std::atan2(d.x, -d.z))) *
                      (1 - glm::smoothstep(0.1f, 0.45f, d.y));
  if (strip > 0.4f)
    color = glm::mix(color, Vec3(1.5f, 0.42f, 0.22f) * (0.12f + nearness * nearness), 0.7f * (strip - 0.4f));
  return color;
}

/// The sun half a hand above the horizon (3.5 degrees), its disc spread over 1.2 degrees.
Environment make_sunset() {
  const Vec3 sun = direction_at(-55, 3.5f);
  Environment environment = computed_map("sunset", [sun](Vec3 d) {
    const Vec3 glow = sunset_sky(Vec3(d.x, 0, d.z), sun);
    const Vec3 ground = Vec3(0.035f, 0.028f, 0.026f) + 0.10f * glow * std::exp(7 * std::min(d.y, 0.0f));
    return glm::mix(ground, sunset_sky(d, sun), glm::smoothstep(-0.008f, 0.008f, d.y));
  });
  add_disc(environment, sun, glm::radians(1.2f), {950, 420, 95});
  return environment;
}

/// A lit rectangle on the sphere about the room: seen from its middle, `half` are the tangents of its half
/// angles.
struct SoftBox {
  Vec3 towards;
  Vec2 half;
  Vec3 radiance;
};

/// Radiance of the box towards `d`, brighter in the middle as cloth before a lamp is; 0 outside.
Vec3 soft_box(const SoftBox& box, Vec3 d) {
  const Basis basis = basis_along(
      box.towards, std::abs(box.towards.y) < 0.99f ? glm::cross(Vec3(0, 1, 0), box.towards) : Vec3(1, 0, 0));
  const Vec3 local = basis.to_local(d);
  if (local.z <= 0) return Vec3(0);
  const Vec2 at = Vec2(local.x, local.y) / local.z / box.half;
  if (std::max(std::abs(at.x), std::abs(at.y)) > 1) return Vec3(0);
  return box.radiance * (0.72f + 0.28f * std::exp(-1.5f * glm::dot(at, at)));
}

/// A dark room with a large box overhead, a key and a fill at the sides, and two strips behind.
Environment make_studio() {
  const SoftBox boxes[] = {
      {direction_at(0, 90), {0.95f, 0.62f}, {1.9f, 1.9f, 1.95f}},
      {direction_at(-105, 34), {0.34f, 0.52f}, {4.4f, 4.1f, 3.7f}},
      {direction_at(95, 22), {0.62f, 0.40f}, {0.85f, 0.92f, 1.05f}},
      {direction_at(-32, 20), {0.07f, 0.62f}, {4, 4, 4}},
      {direction_at(38, 20), {0.07f, 0.62f}, {4, 4, 4}},
      {direction_at(176, 14), {0.22f, 0.14f}, {0.9f, 0.8f, 0.7f}},
  };
  return computed_map("studio", [&](Vec3 d) {
    // Walls fade upwards; the floor takes light from overhead.
    Vec3 color = Vec3(0.030f, 0.031f, 0.034f) * (1.2f - 0.5f * std::abs(d.y));
    color += Vec3(0.10f, 0.098f, 0.095f) * glm::smoothstep(0.05f, -0.45f, d.y);
    for (const SoftBox& box : boxes) color += soft_box(box, d);
    return color;
  });
}

/// A hall whose roof is mostly glass: four rows of three bays to a bright sky, the beams between them, and
/// walls that darken upwards.
Environment make_skylight() {
  return computed_map("skylight", [](Vec3 d) {
    const float rise = glm::clamp(d.y, 0.0f, 1.0f);
    const Vec3 floor = Vec3(0.30f, 0.297f, 0.292f) * (1 - 0.5f * glm::clamp(-d.y, 0.0f, 1.0f));
    const Vec3 wall = glm::mix(Vec3(0.11f, 0.115f, 0.125f), floor, std::exp(-9 * rise));
    Vec3 color = d.y < 0 ? floor : wall;
    if (d.y < 0.25f) return color;
    const Vec2 at = Vec2(d.x, d.z) / d.y;
    const Vec2 bay(at.x / 1.1f, at.y + 0.5f), in = glm::abs(bay - glm::floor(bay) - 0.5f);
    const bool roof = std::abs(at.x) < 2.2f && std::abs(at.y) < 1.5f;
    if (roof && in.x < 0.44f && in.y < 0.44f)
      color = glm::mix(Vec3(2.5f, 2.6f, 2.75f), Vec3(3.3f, 3.25f, 3.15f), rise);
    return color;
  });
}

/// Windows of a street's fronts between the horizon and a skyline, before a sky lit from below.
Vec3 night_fronts(Vec3 d) {
  const float turn = std::atan2(d.x, -d.z) / (2 * pi) + 0.5f;
  constexpr float houses = 40;
  const float house = std::floor(turn * houses);
  const uint64_t key = hash_combine(71, static_cast<uint64_t>(house));
  const float height = 0.10f + 0.42f * square(to_unit_float(static_cast<uint32_t>(key >> 32)));
  const float rise = d.y / std::max(std::hypot(d.x, d.z), 1e-4f);
  if (rise < 0) return Vec3(0.018f, 0.016f, 0.015f) + Vec3(0.05f, 0.034f, 0.018f) * std::exp(6 * rise);
  if (rise > height)
    return glm::mix(Vec3(0.045f, 0.034f, 0.028f), Vec3(0.006f, 0.008f, 0.016f),
                    std::sqrt(std::max(d.y, 0.0f)));
  const float across = turn * houses * 9, up = rise * 52;
  const uint64_t window = hash_combine(key, static_cast<uint64_t>(across) * 1000 + static_cast<uint64_t>(up));
  const bool pane =
      std::abs(across - std::floor(across) - 0.5f) < 0.29f && std::abs(up - std::floor(up) - 0.5f) < 0.30f;
  if (!pane || to_unit_float(static_cast<uint32_t>(window >> 32)) > 0.30f) return {0.010f, 0.010f, 0.012f};
  const float warmth = to_unit_float(static_cast<uint32_t>(window));
  return glm::mix(Vec3(0.45f, 0.50f, 0.56f), Vec3(0.85f, 0.48f, 0.16f), warmth);
}

/// Street lamps in two rows, signs and headlamps: 220 of them, each a texel or a few.
Environment make_city_night() {
  Environment environment = computed_map("city-night", night_fronts);
  const Vec3 tints[] = {{1.0f, 0.62f, 0.24f}, {1.0f, 0.74f, 0.42f}, {0.92f, 0.96f, 1.0f},
                        {1.0f, 0.10f, 0.06f}, {0.10f, 0.55f, 1.0f}, {0.15f, 1.0f, 0.40f}};
  RandomStream random(0, 0, 1971);
  for (int lamp = 0; lamp < 220; ++lamp) {
    const float kind = random.next(), far = random.next(), size = random.next();
    // Seven in ten are white or warm lamps overhead; the others are signs on the fronts.
    const bool street = kind < 0.7f;
    const float elevation = street ? 1.0f + 34 * std::pow(far, 3.0f) : 1.0f + 13 * far;
    const Vec3 tint =
        tints[street ? static_cast<int>(kind / 0.7f * 2.99f) : 3 + static_cast<int>((kind - 0.7f) * 9.99f)];
    const float brightness = (street ? 55.0f : 9.0f) * std::exp(2.2f * (random.next() - 0.5f));
    add_disc(environment, direction_at(360 * random.next(), elevation),
             glm::radians(0.25f + 0.75f * size * size * size), tint * brightness);
  }
  return environment;
}

/// Five lamps of one texel or a few over dim grey: nearly all light comes from less than a thousandth of the
/// sphere.
Environment make_spikes() {
  struct Spike {
    float azimuth, elevation, degrees, radiance;
    Vec3 tint;
  };
  const Spike spikes[] = {{-48, 52, 0.8f, 9000, {1, 0.93f, 0.82f}},
                          {70, 33, 0.4f, 12000, {0.70f, 0.84f, 1}},
                          {158, 64, 0.4f, 8000, {1, 0.80f, 0.55f}},
                          {-140, 24, 0.4f, 6500, {1, 0.50f, 0.34f}},
                          {12, 16, 0.4f, 4000, {0.62f, 1, 0.74f}}};
  Environment environment = computed_map("spikes", [](Vec3 d) {
    return glm::mix(Vec3(0.022f), Vec3(0.055f, 0.060f, 0.068f), glm::smoothstep(-0.1f, 0.6f, d.y));
  });
  for (const Spike& s : spikes)
    add_disc(environment, direction_at(s.azimuth, s.elevation), glm::radians(s.degrees), s.tint * s.radiance);
  return environment;
}

}  // namespace

const std::vector<BuiltInEnvironment>& built_in_environments() {
  static const std::vector<BuiltInEnvironment> environments = {
      {"city-night", "a street at night: 220 lamps and signs before lit windows", make_city_night},
      {"overcast", "a cloudy sky, brightest at the zenith", make_overcast},
      {"skylight", "a hall lit through its roof", make_skylight},
      {"spikes", "five lamps of a few texels over dim grey", make_spikes},
      {"studio", "soft boxes in a dark room, the largest overhead", make_studio},
      {"sunset", "the sun just above the horizon, strips of cloud", make_sunset},
      {"uniform", "radiance 1 from everywhere", make_uniform},
  };
  return environments;
}

Environment make_built_in_environment(std::string_view name) {
  std::vector<std::string> names;
  for (const BuiltInEnvironment& built_in : built_in_environments()) {
    names.emplace_back(built_in.name);
    if (built_in.name == name) return built_in.make();
  }
  throw unknown_name("environment", name, names);
}

}  // namespace halflight
