// Adaptive sampling through whole pictures: their mean over many seeds is what it would be without it.
#include <gtest/gtest.h>

#include "commands/sampling.h"

namespace halflight {
namespace {

constexpr int width = 32, height = 24, tile_side = 8;
constexpr size_t tiles = (width / tile_side) * (height / tile_side);
constexpr double most_z = 3.9;  ///< two-sided 1e-4, for 13 numbers at a time

using Means = std::array<double, tiles + 1>;

/// Of each tile, then of the whole picture.
Means tile_means(const Film& film) {
  Means means{};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double value = luminance(film.radiance(static_cast<uint32_t>(y * width + x)));
      means[static_cast<size_t>(y / tile_side * (width / tile_side) + x / tile_side)] +=
          value / (tile_side * tile_side);
      means.back() += value / (width * height);
    }
  return means;
}

struct Statistics {
  Means mean{}, variance_of_mean{};
};

Statistics over_seeds(Session& session, const SamplingGoal& goal, uint64_t first_seed, int seeds) {
  Statistics result;
  Means squares{};
  for (int k = 0; k < seeds; ++k) {
    RenderSettings settings = session.settings();
    settings.seed = first_seed + static_cast<uint64_t>(k);
    session.set_settings(settings);
    sample_until(session, goal, Stopwatch(), {}, {});
    const Means means = tile_means(session.film());
    for (size_t t = 0; t < means.size(); ++t)
      result.mean[t] += means[t] / seeds, squares[t] += means[t] * means[t] / seeds;
  }
  for (size_t t = 0; t < squares.size(); ++t)
    result.variance_of_mean[t] = (squares[t] - result.mean[t] * result.mean[t]) / (seeds - 1);
  return result;
}

RenderSettings settings_of(const std::string& technique, Target target) {
  RenderSettings settings;
  settings.technique = technique, settings.target = target;
  settings.width = width, settings.height = height, settings.backend = Backend::none;
  settings.values.set("lights.count", "512");
  return settings;
}

SamplingGoal samples(uint32_t count, bool adaptive) {
  SamplingGoal goal;
  goal.samples = count, goal.adaptive = adaptive;
  return goal;
}

TEST(Adaptive, TheMeanIsTheSum) {
  Messages messages;
  Session session(load_scene("plate", {}, messages), settings_of("bidirectional", Target::discrete),
                  messages);
  const Statistics found = over_seeds(session, samples(24, true), 1, 120);
  session.set_settings(settings_of("reference", Target::discrete));
  session.run_pass(1, 1, 0);
  const Means truth = tile_means(session.film());
  for (size_t t = 0; t < truth.size(); ++t)
    EXPECT_NEAR(found.mean[t], truth[t], most_z * std::sqrt(found.variance_of_mean[t])) << t;
  EXPECT_LT(std::sqrt(found.variance_of_mean.back()), 0.003 * truth.back()) << "too few seeds to tell";
}

// The last pass is as large as there is room for, and no pass begins that there is none for.
TEST(Adaptive, KeepsToTheSamplesAskedFor) {
  Messages messages;
  Session session(load_scene("plate", {}, messages), settings_of("bidirectional", Target::discrete),
                  messages);
  for (const uint32_t wanted : {8u, 11u, 32u, 100u, 317u}) {
    session.start_over();
    EXPECT_EQ(sample_until(session, samples(wanted, true), Stopwatch(), {}, {}), StopReason::samples);
    EXPECT_LE(session.film().mean_samples(), wanted + 0.1) << wanted;  // visits are of whole samples
    EXPECT_GE(session.film().mean_samples(), 0.8 * wanted) << wanted;
  }
}

}  // namespace
}  // namespace halflight
