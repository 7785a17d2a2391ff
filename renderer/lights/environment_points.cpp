#include <algorithm>

#include "core/parallel.h"
#include "core/random.h"
#include "core/tables.h"
#include "core/warp.h"
#include "lights/light_points.h"
#include "lights/spherical_fibonacci.h"

namespace halflight {

namespace {

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

float texel_power(const Environment& environment, size_t texel) {
  const int y = static_cast<int>(texel / static_cast<size_t>(environment.map.width));
  return luminance(environment.map.pixels[texel]) * texel_solid_angle(environment, y);
}

Vec2 texel_uv(const ImageRgb& map, size_t texel, Vec2 inside) {
  const auto x = static_cast<float>(texel % static_cast<size_t>(map.width));
  const auto y = static_cast<float>(texel / static_cast<size_t>(map.width));
  return (Vec2(x, y) + inside) / Vec2(map.width, map.height);
}

/// Texels that hold more power than a few cells should, brightest first: suns and lamps get a point of their
/// own.
std::vector<size_t> bright_texels(const Environment& environment, uint32_t count) {
  const size_t texels = environment.map.pixels.size();
  double total = 0;
  for (size_t i = 0; i < texels; ++i) total += texel_power(environment, i);
  constexpr double cells_worth = 2;
  const double threshold = cells_worth * total / count;
  std::vector<size_t> bright;
  for (size_t i = 0; i < texels; ++i)
    if (texel_power(environment, i) > threshold) bright.push_back(i);
  std::stable_sort(bright.begin(), bright.end(), [&](size_t a, size_t b) {
    return texel_power(environment, a) > texel_power(environment, b);
  });
  bright.resize(std::min<size_t>(bright.size(), count / 2));
  return bright;
}

/// What the texels nearest to one point add up to.
struct Cell {
  double solid_angle = 0;
  Vec3d flux{0}, direction{0};

  void add(Vec3 towards, Vec3 radiance, double omega) {
    solid_angle += omega;
    flux += Vec3d(radiance) * omega;
    // Centred by power: the cell's light then comes from where most of it is.
    direction += Vec3d(towards) * (omega * (static_cast<double>(luminance(radiance)) + 1e-30));
  }
};

/// Independent directions by power, one in each of `count` strata: Σ L_i Ω_i g(ω_i) has the integral as its
/// mean.
std::vector<VirtualLight> random_points(const Environment& environment, const LightPointSettings& settings) {
  const ImageRgb& map = environment.map;
  std::vector<float> powers(map.pixels.size());
  for (size_t i = 0; i < powers.size(); ++i) powers[i] = texel_power(environment, i);
  const DiscreteTable table(powers);
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

  // The rest is shared among evenly spread points, turned at random by the seed. Texels are cut up until each
  // point has several pieces.
  const uint32_t points = settings.count - static_cast<uint32_t>(bright.size());
  constexpr double pieces_a_point = 8;
  const int cut =
      std::clamp(static_cast<int>(std::ceil(std::sqrt(pieces_a_point * points / map.pixels.size()))), 1, 64);
  RandomStream random(0, 0, hash_combine(settings.seed, 0x746f7572ull));
  const Vec2 u = random.next2();
  const glm::dmat3 turn =
      glm::mat3_cast(glm::angleAxis(2 * 3.141592653589793 * random.next(), Vec3d(uniform_sphere(u))));
  const glm::dmat3 turn_back = glm::transpose(turn);

  // Rows are found in parallel and added in order: the same sums for any number of threads.
  std::vector<Cell> cells(points);
  struct Piece {
    uint32_t cell;
    Vec3 towards;
  };
  const int rows = map.height * cut, columns = map.width * cut;
  constexpr int band = 64;
  std::vector<Piece> pieces;
  for (int band_begin = 0; band_begin < rows; band_begin += band) {
    const int band_end = std::min(rows, band_begin + band);
    pieces.resize(static_cast<size_t>(band_end - band_begin) * columns);
    parallel_for(static_cast<size_t>(band_begin), static_cast<size_t>(band_end), 2,
                 [&](size_t begin, size_t end) {
                   for (size_t row = begin; row < end; ++row) {
                     for (int column = 0; column < columns; ++column) {
                       const Vec2 uv((column + 0.5f) / static_cast<float>(columns),
                                     (static_cast<float>(row) + 0.5f) / static_cast<float>(rows));
                       const Vec3 towards = environment_direction(environment, uv);
                       pieces[(row - static_cast<size_t>(band_begin)) * columns + column] = {
                           nearest_fibonacci(turn_back * Vec3d(towards), points), towards};
                     }
                   }
                 });
    for (int row = band_begin; row < band_end; ++row) {
      const double top = std::cos(3.141592653589793 * row / rows),
                   low = std::cos(3.141592653589793 * (row + 1) / rows);
      const double omega = (top - low) * 2 * 3.141592653589793 / columns;
      for (int column = 0; column < columns; ++column) {
        const size_t texel = static_cast<size_t>(row / cut) * map.width + static_cast<size_t>(column / cut);
        const Piece& piece = pieces[static_cast<size_t>(row - band_begin) * columns + column];
        if (!alone[texel]) cells[piece.cell].add(piece.towards, map.pixels[texel], omega);
      }
    }
  }
  for (uint32_t i = 0; i < points; ++i) {
    const Cell& cell = cells[i];
    if (!(cell.solid_angle > 0)) continue;
    const Vec3 radiance = Vec3(cell.flux / cell.solid_angle) * environment.strength;
    lights.push_back(distant_light(glm::normalize(Vec3(glm::normalize(cell.direction))),
                                   static_cast<float>(cell.solid_angle), radiance, i));
  }
  return lights;
}

}  // namespace halflight
