// Two techniques that must have one mean, compared tile by tile over independent seeds.
#pragma once

#include <gtest/gtest.h>

#include "core/random.h"
#include "session.h"
#include "support/statistics.h"

namespace halflight {

/// How a comparison is run. Each seed is a new picture of `rounds` rounds.
struct TileRun {
  int width = 64, height = 48;
  uint32_t seeds = 16;
  uint32_t rounds = 8, samples = 8;  ///< a round and pixel
};

constexpr int tile_side = 16;

inline size_t tile_count(const TileRun& run) {
  return static_cast<size_t>(run.width / tile_side) * static_cast<size_t>(run.height / tile_side);
}

/// Mean luminance of each tile, then of the whole picture.
inline std::vector<double> tile_means(const Film& film, const TileRun& run) {
  const int columns = run.width / tile_side;
  std::vector<double> means(tile_count(run) + 1);
  for (int y = 0; y < run.height; ++y)
    for (int x = 0; x < run.width; ++x) {
      const double value = luminance(film.radiance(static_cast<uint32_t>(y * run.width + x)));
      means[static_cast<size_t>(y / tile_side * columns + x / tile_side)] += value / (tile_side * tile_side);
      means.back() += value / (run.width * run.height);
    }
  return means;
}

/// Turned at random by up to half a pixel. All pixels of a round look through the same place of their pixel,
/// and those places are the same for every seed: what they miss of an edge they would miss always, did the
/// camera not move.
inline Camera nudged(Camera camera, const TileRun& run, uint32_t seed) {
  RandomStream random(seed, 5, 77);
  const Vec2 shift =
      (random.next2() - 0.5f) * (2 * std::tan(camera.vertical_fov / 2) / static_cast<float>(run.height));
  camera.back = glm::normalize(camera.back + shift.x * camera.right + shift.y * camera.up);
  camera.right = glm::normalize(camera.right - glm::dot(camera.right, camera.back) * camera.back);
  camera.up = glm::cross(camera.back, camera.right);
  return camera;
}

/// Tile means of each seed, the whole picture's last.
using SeedMeans = std::vector<std::vector<double>>;

inline SeedMeans run_seeds(Session& session, const Camera& camera, const std::string& technique,
                           const TileRun& run, uint32_t first_seed) {
  SeedMeans means;
  for (uint32_t k = 0; k < run.seeds; ++k) {
    RenderSettings settings = session.settings();
    settings.technique = technique, settings.target = Target::continuous, settings.seed = first_seed + k;
    settings.width = run.width, settings.height = run.height, settings.backend = Backend::none;
    session.set_settings(settings);
    session.set_camera(nudged(camera, run, k));
    for (uint32_t round = 0; round < run.rounds; ++round) session.run_pass(run.samples, 1, 0);
    EXPECT_EQ(session.film().nan_samples(), 0u) << technique;
    means.push_back(tile_means(session.film(), run));
  }
  return means;
}

/// What two techniques' tiles say of each other: seeds are paired, for they share a camera.
struct TileVerdict {
  size_t tiles = 0;  ///< with noise
  double largest_z = 0, squares = 0;
  double mean_difference = 0;                  ///< of the picture, relative
  double mean_error = 0;                       ///< its standard error, relative
  double median_error = 0, largest_error = 0;  ///< standard errors of tiles, relative to the tile

  double rms() const { return std::sqrt(squares / static_cast<double>(tiles)); }
};

inline TileVerdict compare_tiles(const SeedMeans& found, const SeedMeans& truth) {
  const double seeds = static_cast<double>(found.size());
  TileVerdict verdict;
  std::vector<double> errors;
  for (size_t t = 0; t < found[0].size(); ++t) {
    double sum = 0, squares = 0, level = 0;
    for (size_t k = 0; k < found.size(); ++k) {
      const double d = found[k][t] - truth[k][t];
      sum += d, squares += d * d, level += truth[k][t] / seeds;
    }
    const double mean = sum / seeds, variance = std::max(0.0, squares / seeds - mean * mean) / (seeds - 1);
    const double rounding = 1e-6 * level;  // sums in floats on the way
    const double error = std::sqrt(variance + rounding * rounding);
    if (t + 1 == found[0].size()) {
      verdict.mean_difference = mean / level, verdict.mean_error = error / level;
    } else if (variance <= 25 * rounding * rounding) {
      EXPECT_NEAR(mean, 0, 1e-4 * level) << "tile " << t << " has no noise";
    } else {
      const double z = normal_of_student(mean / error, seeds - 1);
      verdict.largest_z = std::max(verdict.largest_z, std::abs(z));
      verdict.squares += z * z;
      errors.push_back(error / level);
      ++verdict.tiles;
    }
  }
  if (errors.empty()) return verdict;
  std::sort(errors.begin(), errors.end());
  verdict.median_error = errors[errors.size() / 2], verdict.largest_error = errors.back();
  return verdict;
}

}  // namespace halflight
