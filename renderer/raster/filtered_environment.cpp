#include "raster/filtered_environment.h"

#include <cmath>

#include "core/parallel.h"

namespace halflight {

namespace {

constexpr double pi_d = 3.141592653589793;

/// Half the size, each texel the mean of what it covers by solid angle; an odd last row or column joins its
/// neighbours.
Environment halved(const Environment& environment) {
  Environment half;
  half.map = ImageRgb(std::max(1, environment.map.width / 2), std::max(1, environment.map.height / 2));
  const auto first = [](int i, int size, int whole) { return static_cast<int>(int64_t{i} * whole / size); };
  for (int y = 0; y < half.map.height; ++y) {
    const int top = first(y, half.map.height, environment.map.height),
              low = first(y + 1, half.map.height, environment.map.height);
    for (int x = 0; x < half.map.width; ++x) {
      const int left = first(x, half.map.width, environment.map.width),
                right = first(x + 1, half.map.width, environment.map.width);
      Vec3d sum(0);
      double weights = 0;
      for (int j = top; j < low; ++j) {
        const double weight = texel_solid_angle(environment, j);
        for (int i = left; i < right; ++i) sum += weight * Vec3d(environment.map.at(i, j)), weights += weight;
      }
      half.map.at(x, y) = Vec3(sum / weights);
    }
  }
  return half;
}

/// Mean radiance over a texel of a paraboloid map, by solid angle.
Vec3 texel_mean(const Environment& environment, int size, int x, int y, int map) {
  constexpr int pieces = 8;
  Vec3 sum(0);
  float weights = 0;
  for (int piece = 0; piece < pieces * pieces; ++piece) {
    const Vec2 inside((static_cast<float>(piece % pieces) + 0.5f) / pieces,
                      (static_cast<float>(piece / pieces) + 0.5f) / pieces);
    const Vec3 direction = paraboloid_direction({(Vec2(x, y) + inside) / static_cast<float>(size), map});
    // Beyond the hemisphere the distortion goes on with the sign of z.
    const float weight = square(1 + (map == 0 ? direction.z : -direction.z));
    sum += weight * environment_radiance(environment, direction);
    weights += weight;
  }
  return sum / weights;
}

Vec3 map_texel_direction(const Environment& environment, int x, int y) {
  return environment_direction(environment,
                               (Vec2(x, y) + 0.5f) / Vec2(environment.map.width, environment.map.height));
}

/// In the map's own frame and units.
Environment plain(const Environment& environment) {
  Environment result = environment;
  result.rotation = 0, result.strength = 1;
  return result;
}

}  // namespace

ParaboloidPoint paraboloid_point(Vec3 direction) {
  const Vec2 xy(direction.x, direction.y);
  return {0.5f + xy / (2 * paraboloid_scale * (1 + std::abs(direction.z))), direction.z < 0 ? 1 : 0};
}

Vec3 paraboloid_direction(ParaboloidPoint point) {
  const Vec2 p = paraboloid_scale * (2.0f * point.st - 1.0f);
  const float r2 = glm::dot(p, p), z = (1 - r2) / (1 + r2);
  return {p * (2 / (1 + r2)), point.map == 0 ? z : -z};
}

float paraboloid_distortion(Vec3 direction) {
  return 4 * square(paraboloid_scale) * square(1 + std::abs(direction.z));
}

float filtered_level(int size, uint32_t samples, float pdf, float distortion, float bias) {
  const float texels = static_cast<float>(size) * static_cast<float>(size);
  const float level =
      0.5f * std::log2(texels / static_cast<float>(samples)) - 0.5f * std::log2(pdf * distortion);
  return std::max(0.0f, level) + bias;
}

Vec2 hammersley(uint32_t i, uint32_t n) {
  uint32_t reversed = i;
  reversed = (reversed << 16) | (reversed >> 16);
  reversed = ((reversed & 0x00ff00ffu) << 8) | ((reversed & 0xff00ff00u) >> 8);
  reversed = ((reversed & 0x0f0f0f0fu) << 4) | ((reversed & 0xf0f0f0f0u) >> 4);
  reversed = ((reversed & 0x33333333u) << 2) | ((reversed & 0xccccccccu) >> 2);
  reversed = ((reversed & 0x55555555u) << 1) | ((reversed & 0xaaaaaaaau) >> 1);
  return {static_cast<float>(static_cast<double>(i) / n),
          std::min(static_cast<float>(reversed) * 0x1p-32f, 0x1.fffffep-1f)};
}

ParaboloidMaps make_paraboloid_maps(const Environment& environment, int size) {
  ParaboloidMaps maps;
  maps.size = size;
  const size_t texels = static_cast<size_t>(size) * size;
  maps.texels.fill(std::vector<Vec4>(texels, Vec4(0)));
  if (!environment.present()) return maps;
  // Texels of the source stay several times as large as the pieces that a texel of the maps is averaged from,
  // and no larger than what the maps resolve at their middles.
  Environment source = plain(environment);
  while (source.map.height > size) source = halved(source);
  for (int map = 0; map < 2; ++map) {
    parallel_for(0, static_cast<size_t>(size), 4, [&](size_t begin, size_t end) {
      for (size_t y = begin; y < end; ++y)
        for (int x = 0; x < size; ++x)
          maps.texels[map][y * size + x] = Vec4(texel_mean(source, size, x, static_cast<int>(y), map), 1);
    });
  }
  return maps;
}

std::array<float, 9> harmonics_at(Vec3 d) {
  return {0.28209479f,
          0.48860251f * d.y,
          0.48860251f * d.z,
          0.48860251f * d.x,
          1.09254843f * d.x * d.y,
          1.09254843f * d.y * d.z,
          0.31539157f * (3 * d.z * d.z - 1),
          1.09254843f * d.x * d.z,
          0.54627422f * (d.x * d.x - d.y * d.y)};
}

SphericalHarmonics project_radiance(const Environment& given) {
  SphericalHarmonics sum{};
  if (!given.present()) return sum;
  const Environment environment = plain(given);
  std::vector<SphericalHarmonics> rows(static_cast<size_t>(environment.map.height));
  parallel_for(0, rows.size(), 4, [&](size_t begin, size_t end) {
    for (size_t row = begin; row < end; ++row) {
      const int y = static_cast<int>(row);
      const double solid_angle = texel_solid_angle(environment, y);
      for (int x = 0; x < environment.map.width; ++x) {
        const auto basis = harmonics_at(map_texel_direction(environment, x, y));
        const Vec3d light = solid_angle * Vec3d(environment.map.at(x, y));
        for (size_t i = 0; i < basis.size(); ++i) rows[row][i] += light * static_cast<double>(basis[i]);
      }
    }
  });
  for (const SphericalHarmonics& row : rows)
    for (size_t i = 0; i < sum.size(); ++i) sum[i] += row[i];
  return sum;
}

std::array<double, 3> zonal_convolution(double (*kernel)(double)) {
  constexpr int steps = 4096;
  std::array<double, 3> result{};
  for (int i = 0; i < steps; ++i) {
    const double z = (i + 0.5) / steps, value = 2 * pi_d * kernel(z) / steps;
    result[0] += value, result[1] += value * z, result[2] += value * 0.5 * (3 * z * z - 1);
  }
  return result;
}

SphericalHarmonics convolve(const SphericalHarmonics& radiance, const std::array<double, 3>& kernel) {
  SphericalHarmonics result;
  for (size_t i = 0; i < result.size(); ++i) result[i] = radiance[i] * kernel[i == 0 ? 0 : i < 4 ? 1 : 2];
  return result;
}

double lambert_kernel(double cosine) { return cosine; }

double ashikhmin_kernel(double cosine) {
  return 28 / (23 * pi_d) * cosine * (1 - std::pow(1 - 0.5 * cosine, 5));
}

std::array<float, 32> schlick_means() {
  constexpr int steps = 64;
  std::array<float, 32> means{};
  for (size_t i = 0; i < means.size(); ++i) {
    const float mu = static_cast<float>(i) / static_cast<float>(means.size() - 1);
    const Vec3 wo(std::sqrt(1 - mu * mu), 0, mu);
    double sum = 0;
    for (int j = 0; j < steps * steps; ++j) {
      const float sin2 = (static_cast<float>(j % steps) + 0.5f) / steps, r = std::sqrt(sin2);
      const float phi = pi * (static_cast<float>(j / steps) + 0.5f) / steps;
      const Vec3 wi(r * std::cos(phi), r * std::sin(phi), std::sqrt(1 - sin2));
      const float cos_half = 0.5f * glm::length(wo + wi);
      sum += std::pow(std::max(0.0, 1.0 - static_cast<double>(cos_half)), 5);
    }
    means[i] = static_cast<float>(sum / (steps * steps));
  }
  return means;
}

}  // namespace halflight
