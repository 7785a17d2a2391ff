#include <algorithm>

#include "core/parallel.h"
#include "core/random.h"
#include "core/tables.h"
#include "core/warp.h"
#include "lights/light_points.h"
#include "lights/spherical_fibonacci.h"

namespace halflight {

namespace {

constexpr double double_pi = 3.141592653589793;

VirtualLight distant_light(Vec3 direction, float solid_angle, Vec3 radiance, uint32_t source) {
  VirtualLight light;
  light.position = direction;
  light.measure = solid_angle;
  light.normal = -direction;
  light.kind = LightKind::environment;
  light.radiance = radiance;
  light.source = source;
  return light;
}

/// Luminance × solid angle of each texel.
std::vector<float> texel_powers(const Environment& environment) {
  const ImageRgb& map = environment.map;
  std::vector<float> powers;
  powers.reserve(map.pixels.size());
  for (int y = 0; y < map.height; ++y) {
    const float solid_angle = texel_solid_angle(environment, y);
    for (int x = 0; x < map.width; ++x) powers.push_back(luminance(map.at(x, y)) * solid_angle);
  }
  return powers;
}

Vec2 texel_uv(const ImageRgb& map, size_t texel, Vec2 inside) {
  const auto x = static_cast<float>(texel % static_cast<size_t>(map.width));
  const auto y = static_cast<float>(texel / static_cast<size_t>(map.width));
  return (Vec2(x, y) + inside) / Vec2(map.width, map.height);
}

/// Texels that hold more power than a few cells should, brightest first: suns and lamps get a point of their
/// own.
std::vector<size_t> bright_texels(const Environment& environment, uint32_t count) {
  const std::vector<float> powers = texel_powers(environment);
  double total = 0;
  for (const float power : powers) total += static_cast<double>(power);
  constexpr double cells_worth = 2;
  const double threshold = cells_worth * total / count;
  std::vector<size_t> bright;
  for (size_t i = 0; i < powers.size(); ++i) {
    // Texels larger than a cell are resolved by several cells.
    const int y = static_cast<int>(i / static_cast<size_t>(environment.map.width));
    if (static_cast<double>(powers[i]) > threshold &&
        static_cast<double>(texel_solid_angle(environment, y)) < 4 * double_pi / count)
      bright.push_back(i);
  }
  std::stable_sort(bright.begin(), bright.end(), [&](size_t a, size_t b) { return powers[a] > powers[b]; });
  bright.resize(std::min<size_t>(bright.size(), count / 2));
  return bright;
}

/// What the texels nearest to one point add up to.
struct Cell {
  double solid_angle = 0;
  Vec3d flux{0}, direction{0}, middle{0};

  void add(Vec3 towards, Vec3 radiance, double omega) {
    solid_angle += omega;
    flux += Vec3d(radiance) * omega;
    // Centred by power: the cell's light then comes from where most of it is.
    const double power = omega * static_cast<double>(luminance(radiance));
    direction += Vec3d(towards) * power;
    middle += Vec3d(towards) * omega;
  }
  Vec3 centre() const {
    const Vec3d most = glm::dot(direction, direction) > 0 ? direction : middle;
    const double length = glm::length(most);
    return length > 0 ? Vec3(most / length) : Vec3(0, 1, 0);
  }
};

/// Independent directions by power, one in each of `count` strata: Σ L_i Ω_i g(ω_i) has the integral as its
/// mean.
std::vector<VirtualLight> random_points(const Environment& environment, const LightPointSettings& settings) {
  const ImageRgb& map = environment.map;
  const DiscreteTable table(texel_powers(environment));
  std::vector<VirtualLight> lights;
  if (table.empty()) return lights;
  const uint64_t seed = hash_combine(settings.seed, 0x656e76ull);
  for (uint32_t i = 0; i < settings.count; ++i) {
    RandomStream random(i, 0, seed);
    const double u = (i + static_cast<double>(random.next())) / settings.count;
    const auto draw = table.draw(std::min(static_cast<float>(u), 0x1.fffffep-1f));
    const int y = static_cast<int>(draw.index) / map.width;
    // Uniform in solid angle inside the texel: cos θ is linear between the row's edges.
    const Vec2 inside = random.next2();
    const float top = std::cos(pi * static_cast<float>(y) / map.height),
                low = std::cos(pi * (y + 1.0f) / map.height);
    const float v = std::acos(std::clamp(glm::mix(top, low, inside.y), -1.0f, 1.0f)) / pi;
    const Vec2 uv(texel_uv(map, draw.index, inside).x, v);
    const float solid_angle =
        texel_solid_angle(environment, y) / (static_cast<float>(settings.count) * draw.probability);
    lights.push_back(distant_light(environment_direction(environment, uv), solid_angle,
                                   map.pixels[draw.index] * environment.strength, draw.index));
  }
  return lights;
}

/// Turns the even set at random, so that redrawn sets differ.
glm::dmat3 random_turn(uint64_t seed) {
  RandomStream random(0, 0, hash_combine(seed, 0x746f7572ull));
  const Vec2 axis = random.next2();
  return glm::mat3_cast(glm::angleAxis(2 * double_pi * random.next(), Vec3d(uniform_sphere(axis))));
}

/// A map cut up so finely that each of `points` cells has several pieces.
struct Pieces {
  int cut, rows, columns;  ///< cut × cut a texel

  Pieces(const ImageRgb& map, uint32_t points) {
    constexpr double pieces_a_point = 8;
    const double texels = static_cast<double>(map.pixels.size());
    cut = std::clamp(static_cast<int>(std::ceil(std::sqrt(pieces_a_point * points / texels))), 1, 64);
    rows = map.height * cut;
    columns = map.width * cut;
  }
  double polar_angle(double row) const { return double_pi * row / rows; }
  double solid_angle(int row) const {
    return (std::cos(polar_angle(row)) - std::cos(polar_angle(row + 1))) * 2 * double_pi / columns;
  }
};

/// Gives every piece of the texels that are not `alone` to the nearest of `points` evenly spread directions.
std::vector<Cell> share_texels(const Environment& environment, const std::vector<bool>& alone,
                               uint32_t points, const glm::dmat3& turn) {
  const ImageRgb& map = environment.map;
  const Pieces pieces(map, points);
  const glm::dmat3 turn_back = glm::transpose(turn);
  std::vector<Vec3> meridians;  // directions at the horizon
  for (int column = 0; column < pieces.columns; ++column)
    meridians.push_back(environment_direction(
        environment, {(static_cast<float>(column) + 0.5f) / static_cast<float>(pieces.columns), 0.5f}));
  std::vector<Vec2> parallels;  // sine and cosine of each row's polar angle
  for (int row = 0; row < pieces.rows; ++row)
    parallels.emplace_back(std::sin(pieces.polar_angle(row + 0.5)), std::cos(pieces.polar_angle(row + 0.5)));
  const auto direction = [&](int row, int column) {
    const Vec3 horizontal = meridians[static_cast<size_t>(column)];
    const Vec2 parallel = parallels[static_cast<size_t>(row)];
    return Vec3(horizontal.x * parallel.x, parallel.y, horizontal.z * parallel.x);
  };

  // Nearest points are found in parallel and added up in order: the same sums for any number of threads.
  std::vector<Cell> cells(points);
  constexpr int band = 64;
  std::vector<uint32_t> nearest(static_cast<size_t>(band) * pieces.columns);
  for (int begin = 0; begin < pieces.rows; begin += band) {
    const int end = std::min(pieces.rows, begin + band);
    parallel_for(0, static_cast<size_t>(end - begin), 2, [&](size_t first, size_t last) {
      FibonacciSearch search(points);
      for (size_t row = first; row < last; ++row)
        for (int column = 0; column < pieces.columns; ++column)
          nearest[row * pieces.columns + column] =
              search.nearest(turn_back * Vec3d(direction(begin + static_cast<int>(row), column)));
    });
    for (int row = begin; row < end; ++row) {
      const double omega = pieces.solid_angle(row);
      for (int column = 0; column < pieces.columns; ++column) {
        const size_t texel =
            static_cast<size_t>(row / pieces.cut) * map.width + static_cast<size_t>(column / pieces.cut);
        if (alone[texel]) continue;
        cells[nearest[static_cast<size_t>(row - begin) * pieces.columns + column]].add(
            direction(row, column), map.pixels[texel], omega);
      }
    }
  }
  return cells;
}

}  // namespace

std::vector<VirtualLight> environment_points(const Environment& environment,
                                             const LightPointSettings& settings) {
  std::vector<VirtualLight> lights;
  if (!environment.present() || settings.count == 0) return lights;
  if (settings.repulsion_steps == 0) return random_points(environment, settings);

  const ImageRgb& map = environment.map;
  const std::vector<size_t> bright = bright_texels(environment, settings.count);
  std::vector<bool> alone(map.pixels.size(), false);
  for (const size_t texel : bright) {
    alone[texel] = true;
    const int y = static_cast<int>(texel / static_cast<size_t>(map.width));
    lights.push_back(distant_light(environment_direction(environment, texel_uv(map, texel, Vec2(0.5f))),
                                   texel_solid_angle(environment, y),
                                   map.pixels[texel] * environment.strength, static_cast<uint32_t>(texel)));
  }

  const uint32_t points = settings.count - static_cast<uint32_t>(bright.size());
  const std::vector<Cell> cells = share_texels(environment, alone, points, random_turn(settings.seed));
  for (uint32_t i = 0; i < points; ++i) {
    const Cell& cell = cells[i];
    if (!(cell.solid_angle > 0)) continue;
    const Vec3 radiance = Vec3(cell.flux / cell.solid_angle) * environment.strength;
    lights.push_back(distant_light(cell.centre(), static_cast<float>(cell.solid_angle), radiance, i));
  }
  return lights;
}

}  // namespace halflight
