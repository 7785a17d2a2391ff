// Techniques that follow rays in the continuous target: `mis` and `brdf` against numerical integration and
// each other.
#include <gtest/gtest.h>

#include "support/traced_rooms.h"
#include "techniques/traced_loop.h"

namespace halflight {
namespace {

// ---- Allocation and weights, exactly ----

TEST(DrawAllocation, WholeSharesAreTheSameForEveryPixel) {
  const DrawAllocation allocation({0.5, 0.25, 0, 0.25, 0}, 16);
  for (const float u : {0.0f, 0.3f, 0.999f})
    EXPECT_EQ(allocation.counts(u), (std::array<uint32_t, draw_kind_count>{8, 4, 0, 4, 0}));
  EXPECT_EQ(allocation.expected(DrawKind::brdf), 8);
  EXPECT_EQ(allocation.expected(DrawKind::emitters), 0);
}

TEST(DrawAllocation, CountsAddUpAndMeanTheExpectedNumbers) {
  constexpr int steps = 10000;
  for (const DrawAllocation::Shares& shares : {DrawAllocation::Shares{0.5, 0.2, 0.1, 0.1, 0.1},
                                               {1, 0, 0, 0, 1},
                                               {0, 0.7, 0.3, 0, 0},
                                               {1, 0, 0, 0, 0}}) {
    for (const uint32_t samples : {1u, 2u, 3u, 5u, 8u, 31u}) {
      const DrawAllocation allocation(shares, samples);
      std::array<double, draw_kind_count> mean{};
      for (int i = 0; i < steps; ++i) {
        const auto counts = allocation.counts((static_cast<float>(i) + 0.5f) / steps);
        uint32_t sum = 0;
        for (size_t k = 0; k < draw_kind_count; ++k) sum += counts[k], mean[k] += counts[k] / double(steps);
        ASSERT_EQ(sum, samples);
      }
      for (size_t k = 0; k < draw_kind_count; ++k) {
        ASSERT_NEAR(mean[k], allocation.expected(static_cast<DrawKind>(k)), 2.0 / steps);
        if (shares[k] > 0) {
          ASSERT_GT(allocation.expected(static_cast<DrawKind>(k)), 0);
        }
      }
    }
  }
}

// Sums of shares round, and u = 0 lands on every edge.
TEST(DrawAllocation, RoundingNeverAsksForMoreThanAll) {
  RandomStream random(1, 2, 3);
  for (int i = 0; i < 20000; ++i) {
    DrawAllocation::Shares shares{};
    for (size_t k = 0; k < draw_kind_count; ++k)
      if (random.next() < 0.7f) shares[k] = random.next();
    const uint32_t samples = 1 + static_cast<uint32_t>(random.next_bits() % 5);
    const DrawAllocation allocation(shares, samples);
    for (const float u : {0.0f, 0x1p-24f, 0.5f, 1 - 0x1p-24f})
      for (const uint32_t count : allocation.counts(u)) ASSERT_LE(count, samples) << u;
  }
}

TEST(DrawAllocation, NothingWantedDrawsNothing) {
  EXPECT_EQ(DrawAllocation({}, 8).counts(0.5f), (std::array<uint32_t, draw_kind_count>{}));
}

TEST(BalanceHeuristic, WeightsOfBothStrategiesAddToOne) {
  for (const float p : {1e-30f, 0.3f, 1e8f})
    for (const float q : {0.0f, 1e-30f, 2.0f, 1e8f, infinity})
      for (const auto& [n, m] : {std::pair{8.0f, 8.0f}, {1.0f, 3.0f}, {16.0f, 0.5f}}) {
        const float first = n * balance_over_n(n, p, m, q);
        const float second = q > 0 ? m * balance_over_n(m, q, n, p) : 0;
        ASSERT_NEAR(first + second, 1, 1e-6) << p << " " << q;
      }
  EXPECT_EQ(balance_over_n(4, 0.5f, 0, 3), 0.25f) << "a parent alone";
}

// ---- Truth by quadrature ----

/// ∫ g(ω, uv) dω over the sphere of directions, by midpoints of a latitude-longitude grid.
template <class Integrand>
double integrate_sphere(const Environment& environment, Integrand&& g, int columns = 768) {
  const int rows = columns / 2;
  double sum = 0;
  for (int y = 0; y < rows; ++y) {
    const double theta = pi * (y + 0.5) / rows;
    double row = 0;
    for (int x = 0; x < columns; ++x)
      row +=
          g(environment_direction(environment, {(static_cast<float>(x) + 0.5f) / static_cast<float>(columns),
                                                (static_cast<float>(y) + 0.5f) / static_cast<float>(rows)}));
    sum += row * std::sin(theta);
  }
  return sum * (pi / rows) * (2 * pi / columns);
}

/// What an unoccluded pixel reflects of an environment, one channel.
double reflected_environment(const GBufferTexel& texel, const Environment& environment) {
  return integrate_sphere(environment, [&](Vec3 wi) -> double {
    const float cosine = glm::dot(texel.shading_normal, wi);
    if (cosine <= 0) return 0;
    return static_cast<double>(environment_radiance(environment, wi).y) * cosine *
           evaluate(texel.brdf, texel.basis(), texel.wo, wi).y;
  });
}

const std::vector<std::pair<const char*, std::vector<std::string>>>& strategies() {
  static const std::vector<std::pair<const char*, std::vector<std::string>>> all{
      {"mis", {"mis.strategy=both"}},     {"mis", {"mis.strategy=both", "mis.brdf-share=0.2"}},
      {"mis", {"mis.strategy=light"}},    {"mis", {"mis.strategy=brdf"}},
      {"brdf", {"brdf.estimator=whole"}}, {"brdf", {"brdf.estimator=chosen-lobe"}}};
  return all;
}

std::vector<GBufferTexel> floor_pixels() {
  std::vector<GBufferTexel> pixels;
  for (const Brdf& brdf : test_brdfs())
    pixels.push_back(seen_point({0.1f, 0, 0.2f}, {0, 1, 0}, brdf, {0.5f, 0.8f, 0.1f}));
  return pixels;
}

/// Means of all pixels against the truth, each within the bound of `tests` comparisons at 1 % together. A
/// pilot's variance sets the number of passes so that the interval is 1.5 % of the value.
void expect_means(TracedScene& s, Technique& technique, uint32_t samples, const std::vector<double>& truth,
                  size_t tests, double tolerance) {
  constexpr double wanted_interval = 0.015;
  const double bound = two_sided_bound(sidak_level(0.01, tests));
  double passes = 200;
  const PassMoments pilot = pass_moments(s, technique, samples, 200, 1, 1000000);
  for (size_t i = 0; i < truth.size(); ++i)
    passes = std::max(passes, 1.3 * pilot.variance[i] * std::pow(bound / (wanted_interval * truth[i]), 2));
  ASSERT_LT(passes * samples, 4e6) << "too noisy a case for this test";
  const PassMoments moments = pass_moments(s, technique, samples, static_cast<uint32_t>(passes));
  for (size_t i = 0; i < truth.size(); ++i) {
    EXPECT_GT(truth[i], 0);
    EXPECT_NEAR(moments.mean[i], truth[i], bound * moments.error(i) + tolerance * truth[i]) << "pixel " << i;
    EXPECT_LT(bound * moments.error(i), 2 * wanted_interval * truth[i]) << "too noisy to tell, pixel " << i;
  }
}

TEST(TracedTechniques, ConstantSkyGivesTheIntegratedAlbedo) {
  Scene scene = floor_scene(1);
  scene.environment = constant_environment(Vec3(2), 32);
  std::vector<double> truth;
  for (const GBufferTexel& pixel : floor_pixels())
    truth.push_back(reflected_environment(pixel, scene.environment));
  EXPECT_NEAR(truth[0], 2 * 0.7, 1e-3);
  for (const auto& [id, set] : strategies()) {
    SCOPED_TRACE(set.back());
    TracedScene s(scene, floor_pixels(), {.environment = true});
    const auto technique = make_technique(s, id, set);
    expect_means(s, *technique, 32, truth, 24, 1e-3);
  }
}

TEST(TracedTechniques, EachStratumOfTheEnvironmentIsCountedOnce) {
  // The environment is the indicator of a block of texels: what both strategies give of it must add to its
  // share, whichever of them is likely to find it.
  constexpr int columns = 4, rows = 2;
  for (int block = 0; block < columns * rows; ++block) {
    ImageRgb map(32, 16, Vec3(0));
    for (int y = 0; y < 16; ++y)
      for (int x = 0; x < 32; ++x)
        if (x * columns / 32 == block % columns && y * rows / 16 == block / columns) map.at(x, y) = Vec3(1);
    Scene scene = floor_scene(1);
    scene.environment = make_environment(map, "block", EnvironmentLayout::latlong);
    scene.environment.rotation = 0.4f;
    TracedScene s(scene, floor_pixels(), {.environment = true});
    const auto technique = make_technique(s, "mis");
    if (block >= columns) {  // below the floor
      for (const Vec3 value : one_pass(s, *technique, 0, 1000)) EXPECT_EQ(value, Vec3(0));
      continue;
    }
    std::vector<double> truth;
    for (const GBufferTexel& pixel : s.gbuffer.texels)
      truth.push_back(reflected_environment(pixel, scene.environment));
    expect_means(s, *technique, 16, truth, 16, 1e-3);
  }
}

TEST(TracedTechniques, EmitterAndOneBounceAgreeWithQuadrature) {
  const Corner corner;
  std::vector<double> direct, bounce, all;
  for (const GBufferTexel& x : corner_pixels()) {
    direct.push_back(corner.direct(x)), bounce.push_back(corner.one_bounce(x));
    all.push_back(direct.back() + bounce.back());
  }
  for (const auto& [id, set] : strategies()) {
    SCOPED_TRACE(set.back());
    for (const auto& [kinds, truth] : {std::pair{LightKinds{.emitters = true}, &direct},
                                       {LightKinds{.surfaces = true}, &bounce},
                                       {LightKinds{.emitters = true, .surfaces = true}, &all}}) {
      TracedScene s(corner.scene, corner_pixels(), kinds);
      const auto technique = make_technique(s, id, set);
      expect_means(s, *technique, 64, *truth, 72, 2e-3);
    }
  }
}

TEST(TracedTechniques, FewSamplesHaveTheSameMean) {
  // One to five draws cannot serve all strategies: which go without is left to chance.
  const Corner corner;
  std::vector<double> truth;
  for (const GBufferTexel& x : corner_pixels()) truth.push_back(corner.direct(x) + corner.one_bounce(x));
  for (const uint32_t samples : {1u, 2u, 5u}) {
    TracedScene s(corner.scene, corner_pixels(), {.emitters = true, .surfaces = true});
    const auto technique = make_technique(s, "mis");
    expect_means(s, *technique, samples, truth, 12, 2e-3);
  }
}

TEST(TracedTechniques, StrategiesAgreeWhereAllKindsOfLightMeet) {
  const Scene scene = full_room();
  std::vector<PassMoments> results;
  for (const auto& [id, set] : strategies()) {
    TracedScene s(scene, corner_pixels(), all_kinds);
    const auto technique = make_technique(s, id, set);
    results.push_back(pass_moments(s, *technique, 64, 1000));
  }
  const double bound = two_sided_bound(sidak_level(0.01, (results.size() - 1) * results[0].mean.size()));
  for (size_t i = 0; i < results[0].mean.size(); ++i)
    for (size_t r = 1; r < results.size(); ++r) {
      const double error = std::hypot(results[0].error(i), results[r].error(i));
      EXPECT_NEAR(results[r].mean[i], results[0].mean[i], bound * error)
          << strategies()[r].second.back() << " " << i;
      EXPECT_LT(bound * error, 0.06 * results[0].mean[i]) << strategies()[r].second.back();
    }
}

TEST(TracedTechniques, TermsAddUpToThePicture) {
  const Scene scene = full_room();
  const auto moments = [&](const LightKinds& kinds) {
    TracedScene s(scene, corner_pixels(), kinds);
    const auto technique = make_technique(s, "mis");
    return pass_moments(s, *technique, 64, 300);
  };
  const PassMoments all = moments(all_kinds);
  const PassMoments terms[]{moments({.environment = true}), moments({.emitters = true}),
                            moments({.surfaces = true}), moments({.punctual = true})};
  const double bound = two_sided_bound(sidak_level(0.01, all.mean.size()));
  for (size_t i = 0; i < all.mean.size(); ++i) {
    double sum = 0, variance = all.error(i) * all.error(i);
    for (const PassMoments& term : terms) sum += term.mean[i], variance += term.error(i) * term.error(i);
    EXPECT_NEAR(sum, all.mean[i], bound * std::sqrt(variance));
  }
}

TEST(TracedTechniques, ScaleWithLengthAndLight) {
  const auto picture = [](const char* id, int lengths, int light) {
    Scene scene = full_room();
    for (Vertex& vertex : scene.vertices) vertex.position *= std::ldexp(1.0f, lengths);
    update_bounds(scene);
    scene.environment.strength = std::ldexp(1.0f, light);
    for (Material& material : scene.materials) material.emission *= std::ldexp(1.0f, light);
    for (PunctualLight& l : scene.lights) {
      l.position *= std::ldexp(1.0f, lengths);
      l.intensity *= std::ldexp(1.0f, light + 2 * lengths);
    }
    std::vector<GBufferTexel> pixels = corner_pixels();
    for (GBufferTexel& pixel : pixels) pixel.position *= std::ldexp(1.0f, lengths);
    TracedScene s(scene, pixels, all_kinds);
    return one_pass(s, *make_technique(s, id), 0, 64);
  };
  for (const char* id : {"mis", "brdf", "instant"}) {
    const std::vector<Vec3> reference = picture(id, 0, 0);
    for (const auto& [lengths, light] : {std::pair{-20, 0}, {20, 0}, {0, -20}, {0, 20}, {-20, 20}}) {
      const std::vector<Vec3> scaled = picture(id, lengths, light);
      for (size_t i = 0; i < scaled.size(); ++i)
        ASSERT_NEAR(std::ldexp(scaled[i].y, -light), reference[i].y, 1e-4 * reference[i].y)
            << id << lengths << light;
    }
  }
}

TEST(TracedTechniques, ExtremesLeaveNoNan) {
  std::vector<GBufferTexel> pixels;
  for (const Brdf& brdf : {Brdf{BrdfModel::phong, Vec3(0.2f), Vec3(0.5f), 1, Vec2(1e6f)},
                           Brdf{BrdfModel::ggx, Vec3(0), Vec3(1), 1, Vec2(1e-4f)},
                           Brdf{BrdfModel::ggx, Vec3(0.5f), Vec3(0), 0, Vec2(1)},
                           Brdf{BrdfModel::ashikhmin_shirley, Vec3(0.1f), Vec3(0.9f), 1, Vec2(10, 1e5f)}})
    for (const Vec3 place : {Vec3(1e-6f, 0, 0.5f), Vec3(0.5f, 0, 0.5f), Vec3(0, 0, 0)})
      pixels.push_back(seen_point(place, {0, 1, 0}, brdf, {0.7f, 0.02f, 0.1f}));
  for (const float light : {1e-30f, 1.0f, 1e30f}) {
    Scene scene = full_room();
    scene.environment.strength = light;
    for (Material& material : scene.materials) material.emission *= light;
    for (PunctualLight& l : scene.lights) l.intensity *= light;
    for (const char* id : {"mis", "brdf", "instant"}) {
      TracedScene s(scene, pixels, all_kinds);
      const auto technique = make_technique(s, id);
      for (uint32_t pass = 0; pass < 20; ++pass) one_pass(s, *technique, pass, 64);
    }
  }
}

TEST(TracedTechniques, NoLightIsBlackAndBackgroundKeepsItsBase) {
  for (const char* id : {"mis", "brdf", "instant"}) {
    TracedScene s(floor_scene(1), floor_pixels(), {});
    s.base.assign(s.base.size(), Vec3(3));
    for (const Vec3 value : one_pass(s, *make_technique(s, id), 0, 4)) EXPECT_EQ(value, Vec3(3));
    TracedScene lit(full_room(), corner_pixels(), all_kinds);
    lit.gbuffer.texels[0].triangle = no_triangle;
    lit.base[0] = Vec3(1, 2, 3);
    const std::vector<Vec3> picture = one_pass(lit, *make_technique(lit, id), 0, 4);
    EXPECT_EQ(picture[0], Vec3(1, 2, 3));
    EXPECT_GT(picture[1].y, 0);
  }
}

// ---- Křivánek's grid and the bound of Veach & Guibas ----

struct GridSky {
  const char* name;
  Environment map;
};

/// From uniform to a single bright texel.
std::vector<GridSky> grid_skies() {
  std::vector<GridSky> skies{{"uniform", constant_environment(Vec3(1), 32)}};
  ImageRgb smooth(64, 32, Vec3(0)), sun(64, 32, Vec3(0.02f));
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x)
      smooth.at(x, y) = Vec3(0.1f + std::pow(0.5f + 0.5f * std::cos(0.1f * static_cast<float>(x)), 4.0f) *
                                        std::exp(-0.1f * static_cast<float>(y)));
  sun.at(40, 9) = Vec3(3000);
  skies.push_back({"smooth", make_environment(smooth, "smooth", EnvironmentLayout::latlong)});
  skies.push_back({"sun", make_environment(sun, "sun", EnvironmentLayout::latlong)});
  return skies;
}

TEST(TracedTechniques, VeachGuibasBoundOverExponentsAndEnvironments) {
  // Of N draws of each, MSE_mis ≤ MSE_parent + μ²/2N; the parents have N draws, the combination 2N.
  constexpr uint32_t n = 16, passes = 1500;
  double worst_mis = 0, worst_brdf = 0, worst_light = 0;
  for (const GridSky& sky : grid_skies()) {
    Scene scene = floor_scene(1);
    scene.environment = sky.map;
    std::vector<GBufferTexel> pixels;
    for (const float exponent : {1.0f, 100.0f, 10000.0f})
      pixels.push_back(seen_point({0, 0, 0}, {0, 1, 0},
                                  {BrdfModel::phong, Vec3(0.2f), Vec3(0.6f), 1, Vec2(exponent)},
                                  {0.5f, 0.8f, 0.3f}));
    const auto run = [&](const char* strategy, uint32_t samples) {
      TracedScene s(scene, pixels, {.environment = true});
      const auto technique = make_technique(s, "mis", {std::string("mis.strategy=") + strategy});
      return pass_moments(s, *technique, samples, passes);
    };
    const PassMoments mis = run("both", 2 * n), brdf = run("brdf", n), light = run("light", n);
    for (size_t i = 0; i < pixels.size(); ++i) {
      const double mean = mis.mean[i], slack = mean * mean / (2 * n);
      for (const PassMoments* parent : {&brdf, &light})
        EXPECT_LE(mis.variance[i] - 3 * mis.variance_error[i],
                  parent->variance[i] + 3 * parent->variance_error[i] + slack)
            << sky.name << " exponent " << pixels[i].brdf.roughness.x;
      worst_mis = std::max(worst_mis, mis.variance[i] / (mean * mean));
      worst_brdf = std::max(worst_brdf, brdf.variance[i] / (mean * mean));
      worst_light = std::max(worst_light, light.variance[i] / (mean * mean));
    }
  }
  EXPECT_LT(4 * worst_mis, worst_brdf) << worst_mis;
  EXPECT_LT(4 * worst_mis, worst_light) << worst_mis;
}

TEST(TracedTechniques, ChosenLobeDiffersFromTheWholeMixtureOnlyWhereThereAreTwo) {
  Scene scene = floor_scene(1);
  scene.environment = constant_environment(Vec3(1), 32);
  const auto variance = [&](const char* estimator) {
    TracedScene s(scene, floor_pixels(), {.environment = true});
    const auto technique = make_technique(s, "brdf", {std::string("brdf.estimator=") + estimator});
    return pass_moments(s, *technique, 16, 400).variance;
  };
  const std::vector<double> whole = variance("whole"), chosen = variance("chosen-lobe");
  EXPECT_NEAR(whole[0], chosen[0], 1e-9) << "a single lobe";
  EXPECT_NE(whole[1], chosen[1]);
}

}  // namespace
}  // namespace halflight
