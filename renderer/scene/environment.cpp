#include "scene/environment.h"

#include <filesystem>

#include "core/parallel.h"
#include "scene/image_files.h"

namespace halflight {

namespace {

/// Where a unit direction falls in the unrotated map.
Vec2 map_uv(Vec3 d) {
  const float u = 0.5f + std::atan2(d.x, -d.z) / (2 * pi);
  // acos loses half its digits near the poles.
  const float v = std::atan2(std::sqrt(d.x * d.x + d.z * d.z), d.y) / pi;
  return {u < 1 ? u : 0.0f, v};
}

Vec3 map_direction(Vec2 uv) {
  const float phi = 2 * pi * (uv.x - 0.5f), theta = pi * uv.y, sin_theta = std::sin(theta);
  return {sin_theta * std::sin(phi), std::cos(theta), -sin_theta * std::cos(phi)};
}

/// Turns about +y by `angle`, counter-clockwise seen from above.
Vec3 turn_about_up(Vec3 d, float angle) {
  if (angle == 0) return d;
  const float c = std::cos(angle), s = std::sin(angle);
  return {c * d.x + s * d.z, d.y, -s * d.x + c * d.z};
}

/// What is no radiance becomes 0; returns the number of such texels. Of a texel with a negative channel the
/// others stay: a saturated sun just outside the gamut is still the sun.
size_t clean_texels(ImageRgb& image) {
  constexpr float brightest = 1e30f;  // so that sums over the map, times strength, stay finite
  size_t bad = 0;
  for (Vec3& texel : image.pixels) {
    if (!is_finite(texel) || std::min({texel.x, texel.y, texel.z}) < 0) ++bad;
    texel = is_finite(texel) ? glm::clamp(texel, 0.0f, brightest) : Vec3(0);
  }
  return bad;
}

/// Debevec's angular map at a direction, bilinear: r = φ/π from the centre, which looks along −z.
Vec3 angular_value(const ImageRgb& image, Vec3 d) {
  const float flat = std::sqrt(d.x * d.x + d.y * d.y);
  const float r = std::atan2(flat, -d.z) / pi;
  const Vec2 unit = flat > 0 ? Vec2(d.x, d.y) / flat * r : Vec2(0);
  const Vec2 p(0.5f * (unit.x + 1) * static_cast<float>(image.width) - 0.5f,
               0.5f * (1 - unit.y) * static_cast<float>(image.height) - 0.5f);
  const int x = static_cast<int>(std::floor(p.x)), y = static_cast<int>(std::floor(p.y));
  const float fx = p.x - static_cast<float>(x), fy = p.y - static_cast<float>(y);
  Vec3 sum(0);
  float weights = 0;
  for (int tap = 0; tap < 4; ++tap) {
    const int i = x + tap % 2, j = y + tap / 2;
    const Vec2 centre = (Vec2(i, j) + 0.5f) / Vec2(image.width, image.height) * 2.0f - 1.0f;
    if (glm::dot(centre, centre) > 1) continue;  // beyond the rim there is no direction, and mostly black
    const float weight = (tap % 2 ? fx : 1 - fx) * (tap / 2 ? fy : 1 - fy);
    sum += image.at(i, j) * weight;
    weights += weight;
  }
  if (weights > 0) return sum / weights;
  const Vec2 inside = (unit * (1 - 2.0f / static_cast<float>(image.width)) * Vec2(1, -1) + 1.0f) * 0.5f;
  return image.at(std::clamp(static_cast<int>(inside.x * image.width), 0, image.width - 1),
                  std::clamp(static_cast<int>(inside.y * image.height), 0, image.height - 1));
}

/// Latitude-longitude map of an angular one, each texel the mean of 4×4 directions in it.
ImageRgb resample_angular(const ImageRgb& image) {
  constexpr int pieces = 4;
  ImageRgb map(2 * image.height, image.height);
  std::vector<Vec3> equator;  // directions at the height of the eye, one a piece of a column
  for (int i = 0; i < pieces * map.width; ++i)
    equator.push_back(
        map_direction({(static_cast<float>(i) + 0.5f) / static_cast<float>(pieces * map.width), 0.5f}));
  parallel_for(0, static_cast<size_t>(map.height), 4, [&](size_t begin, size_t end) {
    for (size_t piece = begin * pieces; piece < end * pieces; ++piece) {
      const float theta = pi * (static_cast<float>(piece) + 0.5f) / static_cast<float>(pieces * map.height);
      const float sine = std::sin(theta), cosine = std::cos(theta);
      Vec3* const row = &map.pixels[piece / pieces * static_cast<size_t>(map.width)];
      for (size_t i = 0; i < equator.size(); ++i)
        row[i / pieces] += angular_value(image, {sine * equator[i].x, cosine, sine * equator[i].z}) *
                           (1.0f / (pieces * pieces));
    }
  });
  return map;
}

/// A clear afternoon: white surfaces facing up look neutral, those that face away from the sun a little blue.
Vec3 sky_radiance(Vec3 d) {
  const Vec3 sun_direction = glm::normalize(Vec3(-0.55f, 0.62f, -0.40f));
  const Vec3 zenith(0.20f, 0.34f, 0.62f), horizon(0.80f, 0.83f, 0.87f), ground(0.21f, 0.19f, 0.165f);
  const Vec3 sunlight(1.0f, 0.80f, 0.52f), halo(1.0f, 0.82f, 0.56f);
  const float height = std::max(d.y, 0.0f), cosine = glm::dot(d, sun_direction);

  // The last few degrees above and below the horizon are warm.
  const Vec3 warmth = glm::mix(Vec3(1), Vec3(1.16f, 0.99f, 0.80f), std::exp(-12 * std::abs(d.y)));

  // Bluer away from the horizon; forward scattering by haze about the sun (Henyey & Greenstein 1941, g =
  // 0.8), and a disc blurred over a few texels.
  constexpr float g = 0.8f;
  const Vec3 clear = glm::mix(horizon, zenith, 1 - std::pow(1 - height, 4.0f)) * warmth;
  const float scattered = (1 - g * g) / std::pow(1 + g * g - 2 * g * cosine, 1.5f);
  const float disc = 330 * std::exp(1100 * (cosine - 1)) + 5 * std::exp(120 * (cosine - 1));
  const Vec3 sky = clear + 0.04f * scattered * halo + disc * sunlight;

  // The ground fades into haze towards the horizon.
  const Vec3 below = glm::mix(ground, 0.62f * horizon, std::exp(9 * std::min(d.y, 0.0f))) * warmth;
  return glm::mix(below, sky, glm::smoothstep(-0.02f, 0.02f, d.y));
}

}  // namespace

Vec2 environment_uv(const Environment& environment, Vec3 direction) {
  return map_uv(turn_about_up(direction, -environment.rotation));
}

Vec3 environment_direction(const Environment& environment, Vec2 uv) {
  return turn_about_up(map_direction(uv), environment.rotation);
}

glm::ivec2 environment_texel(const Environment& environment, Vec2 uv) {
  const ImageRgb& map = environment.map;
  return {std::min(static_cast<int>(uv.x * static_cast<float>(map.width)), map.width - 1),
          std::min(static_cast<int>(uv.y * static_cast<float>(map.height)), map.height - 1)};
}

glm::ivec2 environment_texel(const Environment& environment, Vec3 direction) {
  return environment_texel(environment, environment_uv(environment, direction));
}

Vec3 environment_radiance(const Environment& environment, Vec3 direction) {
  if (!environment.present()) return Vec3(0);
  return environment_radiance(environment, environment_texel(environment, direction));
}

float texel_solid_angle(const Environment& environment, int y) {
  // In double: the difference of two cosines near the pole.
  constexpr double pi_d = 3.141592653589793;
  const double top = std::cos(pi_d * y / environment.map.height),
               low = std::cos(pi_d * (y + 1) / environment.map.height);
  return static_cast<float>((top - low) * 2 * pi_d / environment.map.width);
}

Environment make_environment(ImageRgb image, std::string name, EnvironmentLayout layout) {
  Environment environment;
  environment.name = std::move(name);
  environment.bad_texels = clean_texels(image);
  const bool angular = layout == EnvironmentLayout::angular ||
                       (layout == EnvironmentLayout::automatic && image.width == image.height);
  environment.map = angular ? resample_angular(image) : std::move(image);
  return environment;
}

Environment built_in_sky() {
  ImageRgb map(512, 256);
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      map.at(x, y) = sky_radiance(map_direction((Vec2(x, y) + 0.5f) / Vec2(map.width, map.height)));
  return make_environment(std::move(map), "built-in sky", EnvironmentLayout::latlong);
}

Environment load_environment(const std::filesystem::path& path, const LoadLimits& limits,
                             Messages& messages) {
  Environment environment = make_environment(read_image(path, limits), path.string());
  if (environment.bad_texels > 0)
    messages.warn(fmt::format("{}: {} of its texels are negative or not finite in places; 0 stands for that",
                              path.string(), environment.bad_texels));
  return environment;
}

}  // namespace halflight
