#include <gtest/gtest.h>

#include <array>
#include <functional>

#include "core/errors.h"
#include "core/random.h"
#include "core/tables.h"
#include "core/warp.h"

namespace halflight {
namespace {

/// χ² of counts against expectations; degrees of freedom are bins − 1. Returns the number of standard
/// deviations above its mean (Wilson–Hilferty).
double chi_square_deviation(const std::vector<double>& counts, const std::vector<double>& expected) {
  double chi2 = 0;
  int degrees = -1;
  for (size_t i = 0; i < counts.size(); ++i) {
    if (expected[i] < 5) continue;
    chi2 += (counts[i] - expected[i]) * (counts[i] - expected[i]) / expected[i];
    ++degrees;
  }
  const double k = degrees;
  return (std::cbrt(chi2 / k) - (1 - 2 / (9 * k))) / std::sqrt(2 / (9 * k));
}

TEST(RandomStream, IsUniformWithinAndAcrossStreams) {
  constexpr int bins = 64, draws = 200000;
  for (const int mode : {0, 1, 2, 3}) {
    std::vector<double> counts(bins), expected(bins, static_cast<double>(draws) / bins);
    RandomStream one(7, 8, 9);
    for (int i = 0; i < draws; ++i) {
      // One long stream; the first number of neighbouring pixels, passes and seeds.
      const auto n = static_cast<uint64_t>(i);
      const float u = mode == 0   ? one.next()
                      : mode == 1 ? RandomStream(n, 0, 1).next()
                      : mode == 2 ? RandomStream(1, n, 1).next()
                                  : RandomStream(1, 0, n).next();
      ASSERT_GE(u, 0);
      ASSERT_LT(u, 1);
      ++counts[static_cast<size_t>(u * bins)];
    }
    EXPECT_LT(std::abs(chi_square_deviation(counts, expected)), 4) << mode;
  }
}

TEST(RandomStream, NeighbouringPixelsAreIndependent) {
  constexpr int bins = 16, draws = 200000;
  std::vector<double> counts(bins * bins), expected(bins * bins, static_cast<double>(draws) / (bins * bins));
  for (uint64_t i = 0; i < draws; ++i) {
    const float a = RandomStream(2 * i, 0, 1).next(), b = RandomStream(2 * i + 1, 0, 1).next();
    ++counts[static_cast<size_t>(a * bins) * bins + static_cast<size_t>(b * bins)];
  }
  EXPECT_LT(std::abs(chi_square_deviation(counts, expected)), 4);
}

TEST(RandomStream, MixesAsPublished) {
  // First outputs of splitmix64 for seed 0 (Vigna's reference implementation): the finaliser over multiples
  // of the golden gamma.
  EXPECT_EQ(mix_bits(0x9e3779b97f4a7c15ull), 0xe220a8397b1dcdafull);
  EXPECT_EQ(mix_bits(2 * 0x9e3779b97f4a7c15ull), 0x6e789e6aa1b965f4ull);
  EXPECT_EQ(to_unit_float(0xffffffffu), 0x1.fffffep-1f);
  EXPECT_EQ(to_unit_float(0), 0);
}

TEST(RandomStream, PairsAreUniformOnTheSquare) {
  constexpr int bins = 32, draws = 400000;
  std::vector<double> counts(bins * bins), expected(bins * bins, static_cast<double>(draws) / (bins * bins));
  RandomStream random(11, 12, 13);
  for (int i = 0; i < draws; ++i) {
    const Vec2 u = random.next2();
    ++counts[static_cast<size_t>(u.x * bins) * bins + static_cast<size_t>(u.y * bins)];
  }
  EXPECT_LT(std::abs(chi_square_deviation(counts, expected)), 4);
}

TEST(RandomStream, IsAFunctionOfItsKey) {
  RandomStream a(1, 2, 3), b(1, 2, 3), c(1, 3, 2);
  const uint64_t first = a.next_bits();
  EXPECT_EQ(first, b.next_bits());
  EXPECT_NE(first, c.next_bits());
}

/// Draws directions about +z and compares the share of each ring with its density's integral.
void expect_ring_density(const std::function<Vec3(Vec2)>& draw,
                         const std::function<double(double)>& cumulative, double most_sine) {
  constexpr int rings = 40, draws = 200000;
  std::vector<double> counts(rings), expected(rings);
  RandomStream random(1, 1, 1);
  for (int i = 0; i < draws; ++i) {
    const Vec3 d = draw(random.next2());
    ASSERT_NEAR(glm::length(d), 1, 1e-5f);
    const double sine = std::hypot(d.x, d.y);  // keeps its digits where the cosine is 1
    ++counts[std::min(rings - 1, static_cast<int>(sine / most_sine * rings))];
  }
  for (int r = 0; r < rings; ++r) {
    const double outer = r + 1 == rings ? 1 : cumulative(most_sine * (r + 1) / rings);
    expected[r] = draws * (outer - cumulative(most_sine * r / rings));
  }
  EXPECT_LT(std::abs(chi_square_deviation(counts, expected)), 4);
}

TEST(Warps, CosineHemisphere) {
  expect_ring_density([](Vec2 u) { return cosine_hemisphere(u); }, [](double s) { return s * s; }, 1);
}

TEST(Warps, CosinePowerLobeOfAnySharpness) {
  for (const double n : {1.0, 100.0, 1e4, 1e6}) {
    // P(sin θ < s) = 1 − (1 − s²)^((n+1)/2).
    const auto cumulative = [n](double s) { return -std::expm1((n + 1) / 2 * std::log1p(-s * s)); };
    expect_ring_density([n](Vec2 u) { return cosine_power_lobe(u, static_cast<float>(n)); }, cumulative,
                        std::min(1.0, 4 / std::sqrt(n)));
  }
}

TEST(Warps, UniformSphereAndTriangleHaveTheirCentroid) {
  RandomStream random(3, 3, 3);
  Vec3d sphere(0);
  glm::dvec2 triangle(0);
  constexpr int draws = 100000;
  for (int i = 0; i < draws; ++i) {
    sphere += Vec3d(uniform_sphere(random.next2())) / static_cast<double>(draws);
    const Vec2 b = uniform_triangle(random.next2());
    ASSERT_LE(b.x + b.y, 1.000001f);
    triangle += glm::dvec2(b) / static_cast<double>(draws);
  }
  EXPECT_LT(glm::length(sphere), 4 / std::sqrt(static_cast<double>(draws)));
  EXPECT_NEAR(triangle.x, 1.0 / 3, 0.004);
  EXPECT_NEAR(triangle.y, 1.0 / 3, 0.004);
}

TEST(DiscreteTable, DrawsItsWeightsAndNeverAZero) {
  const std::vector<float> weights = {0, 3, 0, 1, 1e-3f, 0, 6, 0};
  const DiscreteTable table(weights);
  double sum = 0;
  for (size_t i = 0; i < weights.size(); ++i) sum += table.probability(i);
  EXPECT_DOUBLE_EQ(sum, 1);
  std::vector<double> counts(weights.size()), expected;
  constexpr int draws = 400000;
  for (const float w : weights) expected.push_back(draws * static_cast<double>(w) / table.total());
  double residuals = 0;
  for (int i = 0; i < draws; ++i) {
    const auto draw = table.draw(RandomStream(static_cast<uint64_t>(i), 0, 0).next());
    ASSERT_GT(weights[draw.index], 0);
    ASSERT_FLOAT_EQ(draw.probability, static_cast<float>(table.probability(draw.index)));
    ASSERT_GE(draw.residual, 0);
    ASSERT_LT(draw.residual, 1);
    residuals += draw.residual / draws;
    ++counts[draw.index];
  }
  EXPECT_LT(std::abs(chi_square_deviation(counts, expected)), 4);
  EXPECT_NEAR(residuals, 0.5, 0.005);
  EXPECT_GT(weights[table.draw(0x1.fffffep-1f).index], 0);
  EXPECT_GT(weights[table.draw(0).index], 0);
  EXPECT_TRUE(DiscreteTable(std::vector<float>(3, 0.0f)).empty());
}

TEST(DiscreteTable, LongTablesFindTheSameEntryAsASearch) {
  // Weights over many magnitudes, with gaps, some at the ends: entries wider and narrower than a guide's
  // share.
  for (const size_t size : {15u, 16u, 17u, 1000u}) {
    std::vector<float> weights(size);
    for (size_t i = 0; i < size; ++i)
      weights[i] = i % 7 < 2 ? 0.0f : std::exp2(20 * RandomStream(i, 1, size).next() - 10);
    const DiscreteTable table(weights);
    double total = 0;
    for (const float weight : weights) total += weight;
    for (int i = 0; i < 20000; ++i) {
      const float u =
          i < 4096 ? static_cast<float>(i) / 4096 : RandomStream(static_cast<uint64_t>(i), 2, 0).next();
      double below = 0;
      size_t entry = 0;
      while (below + weights[entry] <= static_cast<double>(u) * total) below += weights[entry++];
      ASSERT_EQ(table.draw(u).index, entry) << size << " " << u;
    }
  }
}

TEST(PlaneTable, DensityIsTheOneItDrawsFrom) {
  const std::vector<float> weights = {1, 0, 4, 2, 0, 0, 0, 0, 0, 3, 1, 5};
  const PlaneTable table(weights, 4, 3);
  constexpr int draws = 200000;
  std::vector<double> counts(12), expected;
  for (const float w : weights) expected.push_back(draws * static_cast<double>(w) / 16);
  for (int i = 0; i < draws; ++i) {
    const auto draw = table.draw(RandomStream(static_cast<uint64_t>(i), 0, 5).next2());
    ++counts[draw.cell];
    ASSERT_NEAR(draw.pdf, weights[draw.cell] / 16 * 12, 1e-4f);
    ASSERT_NEAR(table.pdf(draw.position), draw.pdf, 1e-4f);
  }
  EXPECT_LT(std::abs(chi_square_deviation(counts, expected)), 4);
}

TEST(PlaneTable, PointsLieInTheCellThatWasDrawn) {
  // Wide enough for (column + residual) to round up to the next column: 8191 + 0.9999 is 8192 in float.
  constexpr int columns = 8191, rows = 5;
  std::vector<float> weights(columns * rows);
  for (size_t i = 0; i < weights.size(); ++i) weights[i] = i % 3 == 0 ? 0.0f : static_cast<float>(i % 7 + 1);
  const PlaneTable table(weights, columns, rows);
  for (uint64_t i = 0; i < 300000; ++i) {
    const auto draw = table.draw(RandomStream(i, 0, 5).next2());
    const int x = static_cast<int>(draw.position.x * columns), y = static_cast<int>(draw.position.y * rows);
    ASSERT_EQ(static_cast<uint32_t>(y * columns + x), draw.cell);
    ASSERT_FLOAT_EQ(table.pdf(draw.position), draw.pdf);
  }
  EXPECT_LT(table.draw(Vec2(0x1.fffffep-1f)).position.x, 1);
}

TEST(DiscreteTable, ProbabilitiesOfDrawnEntriesAreNeverZero) {
  const DiscreteTable table(std::vector<float>{1e-30f, 1e30f, 1e-30f});
  for (const float u : {0.0f, 0x1p-24f, 0.5f, 0x1.fffffep-1f}) EXPECT_GT(table.draw(u).probability, 0) << u;
  const DiscreteTable tiny(std::vector<float>{1e-38f, 3e-38f});
  EXPECT_FLOAT_EQ(tiny.draw(0.9f).probability, 0.75f);
}

TEST(Basis, IsOrthonormalAndRightHanded) {
  RandomStream random(1, 2, 3);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 n = i == 0 ? Vec3(0, 0, -1) : i == 1 ? Vec3(0, 0, 1) : uniform_sphere(random.next2());
    for (const Basis& b :
         {basis_around(n), basis_along(n, uniform_sphere(random.next2())), basis_along(n, n)}) {
      EXPECT_NEAR(glm::dot(b.tangent, b.bitangent), 0, 1e-5f);
      EXPECT_NEAR(glm::dot(b.tangent, b.normal), 0, 1e-5f);
      EXPECT_NEAR(glm::length(b.tangent), 1, 1e-5f);
      EXPECT_NEAR(glm::length(glm::cross(b.tangent, b.bitangent) - b.normal), 0, 1e-5f);
      const Vec3 v = uniform_sphere(random.next2());
      EXPECT_NEAR(glm::length(b.to_world(b.to_local(v)) - v), 0, 1e-5f);
    }
  }
}

TEST(Errors, UnknownNamesSuggestTheNearest) {
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3u);
  EXPECT_EQ(edit_distance("", "abc"), 3u);
  const Error error = unknown_name("technique", "bidirectonal", {"illumination", "bidirectional"});
  EXPECT_EQ(error.code(), ExitCode::usage);
  const std::string text = error.what();
  EXPECT_NE(text.find("did you mean 'bidirectional'"), std::string::npos);
  EXPECT_NE(text.find("illumination"), std::string::npos);
  EXPECT_EQ(std::string(unknown_name("x", "zzzzzz", {"abc"}).what()).find("did you mean"), std::string::npos);
}

TEST(Errors, StrictTurnsPlaceholdersIntoErrors) {
  Messages messages;
  messages.placeholder("a.gltf", "images[0]", "missing");
  ASSERT_EQ(messages.warnings.size(), 1u);
  EXPECT_EQ(messages.warnings[0], "a.gltf: images[0]: missing");
  messages.strict = true;
  EXPECT_THROW(messages.placeholder("a.gltf", "images[0]", "missing"), Error);
}

}  // namespace
}  // namespace halflight
