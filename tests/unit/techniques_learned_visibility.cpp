// What light samples of earlier rounds tell later ones: counts, tiles around, and when it is known.
#include <gtest/gtest.h>

#include <cmath>

#include "techniques/learned_visibility.h"

namespace halflight {
namespace {

void count(LearnedVisibility& visibility, uint32_t tile, uint32_t cluster, uint16_t drawn, uint16_t arrived) {
  VisibilityCount& c = visibility.pending(tile)[cluster];
  c.drawn = static_cast<uint16_t>(c.drawn + drawn), c.arrived = static_cast<uint16_t>(c.arrived + arrived);
}

std::vector<float> factors(const LearnedVisibility& visibility, uint32_t tile) {
  std::vector<float> out(16, -1.0f);
  visibility.factors(tile, out);
  return out;
}

/// √((a₀ v₀ + arrived)/(a₀ + drawn)), a₀ = 4.
double factor(double drawn, double arrived, double all) {
  return std::max(0.05, std::sqrt((4 * all + arrived) / (4 + drawn)));
}

TEST(LearnedVisibility, KnowsNothingUntilARoundHasEnded) {
  LearnedVisibility visibility(64, 48, 16);
  count(visibility, 0, 3, 100, 0);
  EXPECT_EQ(factors(visibility, 0), std::vector<float>(16, 1.0f));
  visibility.publish();
  EXPECT_LT(factors(visibility, 0)[3], 0.1f);
  for (const VisibilityCount& c : visibility.pending(0)) EXPECT_EQ(c.drawn + c.arrived, 0);
  visibility.forget();
  EXPECT_EQ(factors(visibility, 0), std::vector<float>(16, 1.0f));
}

TEST(LearnedVisibility, ForgetsWhatIsPendingToo) {
  LearnedVisibility visibility(64, 48, 16);
  count(visibility, 0, 3, 100, 0);
  visibility.forget();
  count(visibility, 0, 5, 10, 10);
  visibility.publish();
  for (const float f : factors(visibility, 0)) EXPECT_FLOAT_EQ(f, 1);
}

TEST(LearnedVisibility, FactorsAreThoseOfTheCounts) {
  LearnedVisibility visibility(16, 16, 16);
  count(visibility, 0, 1, 40, 10);
  count(visibility, 0, 2, 1000, 0);
  count(visibility, 0, 3, 7, 7);
  visibility.publish();
  count(visibility, 0, 1, 20, 20);
  visibility.publish();  // rounds add up
  const double all = (30.0 + 7) / (60 + 1000 + 7);
  const std::vector<float> found = factors(visibility, 0);
  EXPECT_NEAR(found[0], factor(0, 0, all), 1e-6);
  EXPECT_NEAR(found[1], factor(60, 30, all), 1e-6);
  EXPECT_FLOAT_EQ(found[2], 0.05f) << "hidden as far as is known, and drawn all the same";
  EXPECT_NEAR(found[3], factor(7, 7, all), 1e-6);
}

TEST(LearnedVisibility, LooksAtTheTilesAround) {
  // 5 × 4 tiles, the last ones not whole.
  LearnedVisibility visibility(16 * 4 + 1, 16 * 3 + 9, 16);
  EXPECT_EQ(visibility.tile_of(0), 0u);
  EXPECT_EQ(visibility.tile_of(16), 1u);
  EXPECT_EQ(visibility.tile_of(65 * 16), 5u);
  EXPECT_EQ(visibility.tile_of(65 * 57 - 1), 19u);
  const uint32_t centre = 7;  // column 2, row 1
  count(visibility, centre, 4, 50, 0);
  count(visibility, centre, 6, 50, 50);
  visibility.publish();
  for (uint32_t tile = 0; tile < 20; ++tile) {
    const uint32_t column = tile % 5, row = tile / 5;
    const bool near = column >= 1 && column <= 3 && row <= 2;
    const std::vector<float> found = factors(visibility, tile);
    EXPECT_NEAR(found[4], near ? factor(50, 0, 0.5) : 1, 1e-6) << tile;
    EXPECT_NEAR(found[6], near ? factor(50, 50, 0.5) : 1, 1e-6) << tile;
  }
}

TEST(LearnedVisibility, LongCountsKeepTheirShare) {
  LearnedVisibility visibility(16, 16, 16);
  for (int round = 0; round < 50; ++round) {
    count(visibility, 0, 1, 60000, 15000);
    count(visibility, 0, 2, 0xffff, 0xffff);
    visibility.publish();
    EXPECT_NEAR(factors(visibility, 0)[1], 0.5, 1e-3);
    EXPECT_NEAR(factors(visibility, 0)[2], 1, 1e-3);
  }
}

}  // namespace
}  // namespace halflight
