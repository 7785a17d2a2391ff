#include <gtest/gtest.h>

#include "core/errors.h"
#include "core/random.h"
#include "film/film.h"
#include "film/metrics.h"
#include "film/tonemap.h"

namespace halflight {
namespace {

TEST(Film, IsTheWeightedMeanOfItsHalves) {
  Film film(2, 1);
  film.add(0, 0, {1, 2, 3}, 3);
  film.add(0, 1, {5, 6, 7}, 1);
  EXPECT_EQ(film.samples(0), 4u);
  EXPECT_EQ(film.samples(1), 0u);
  EXPECT_EQ(film.mean_samples(), 2);
  EXPECT_EQ(film.radiance(0), Vec3(2, 3, 4));
  EXPECT_EQ(film.radiance(1), Vec3(0));
  EXPECT_EQ(film.variance(0), Vec3(3));  // (1 − 5)² · 3 · 1 / 4²
  EXPECT_EQ(film.variance(1), Vec3(0));
}

TEST(Film, EstimatesTheErrorItHas) {
  // Pixels with known noise: expected relMSE is variance of the mean over (r² + (0.01 r)²).
  constexpr int side = 100;
  constexpr double noise = 0.3, value = 2;
  Film film(side, side);
  EXPECT_LT(film.estimated_relmse(), 0);
  for (uint32_t i = 0; i < side * side; ++i) {
    for (int half = 0; half < 2; ++half) {
      RandomStream random(i, static_cast<uint64_t>(half), 1);
      const float u = random.next();  // uniform noise of standard deviation `noise`
      film.add(i, half, Vec3(static_cast<float>(value + noise * std::sqrt(12.0) * (u - 0.5))), 8);
    }
  }
  const double expected = noise * noise / 2 / (value * value * 1.0001);
  EXPECT_NEAR(film.estimated_relmse(), expected, 0.06 * expected);
}

TEST(Film, EstimatesTheErrorOfUnequalHalves) {
  // The picture weighs all samples alike: its variance is that of one sample over all of them, however they
  // are split.
  constexpr uint32_t pixels = 20000, samples[] = {3, 1};
  Film film(static_cast<int>(pixels), 1);
  double variance = 0;
  for (uint32_t i = 0; i < pixels; ++i) {
    for (int half = 0; half < 2; ++half) {
      RandomStream random(i, static_cast<uint64_t>(half), 2);
      float mean = 0;
      for (uint32_t s = 0; s < samples[half]; ++s)
        mean += (0.5f + random.next()) / static_cast<float>(samples[half]);
      film.add(i, half, Vec3(mean), samples[half]);
    }
    variance += film.variance(i).x / pixels;
  }
  const double expected = 1.0 / 12 / 4;
  EXPECT_NEAR(variance, expected, 0.04 * expected);
  // r² is the noisy picture's own: its expected inverse square is a little above 1.
  EXPECT_NEAR(film.estimated_relmse(), expected, 0.12 * expected);
}

TEST(Film, StaysFiniteAtTheEndsOfTheRange) {
  Film film(2, 1);
  film.add(0, 0, Vec3(1e30f), 1), film.add(0, 1, Vec3(3e30f), 1);
  film.add(1, 0, Vec3(1e-30f), 1), film.add(1, 1, Vec3(3e-30f), 1);
  EXPECT_TRUE(is_finite(film.variance(0)));
  EXPECT_FLOAT_EQ(film.radiance(1).x, 2e-30f);
  // (A − B)²/4 over the lesser half squared is 1 in the first pixel; the second is nothing beside its neighbour.
  EXPECT_NEAR(film.estimated_relmse(), 0.5, 1e-3);
  Film black(2, 1);
  black.add(0, 0, Vec3(0), 1), black.add(0, 1, Vec3(0), 1);
  EXPECT_EQ(black.estimated_relmse(), 0);
}

TEST(Film, CountsWhatIsNotFiniteAndShowsItBlack) {
  Film film(1, 1);
  film.add(0, 0, Vec3(std::numeric_limits<float>::quiet_NaN()), 2);
  film.add(0, 1, {1, infinity, 1}, 1);
  EXPECT_EQ(film.nan_samples(), 3u);
  EXPECT_EQ(film.first_nan(), (NanPlace{0, 0}));
  EXPECT_EQ(film.radiance(0), Vec3(0));
  film.add(0, 0, Vec3(3), 3);
  EXPECT_EQ(film.radiance(0), Vec3(1.5f));
  film.clear();
  EXPECT_FALSE(film.first_nan());
  film.add(0, 0, Vec3(1), 5), film.add(0, 1, Vec3(1), 4);
  film.add(0, 0, Vec3(infinity), 1);
  EXPECT_EQ(film.first_nan(), (NanPlace{0, 9}));
  film.clear();
  EXPECT_EQ(film.nan_samples(), 0u);
  EXPECT_EQ(film.samples(0), 0u);
}

TEST(Film, MergingIsAddingTogether) {
  Film both(3, 2), one(3, 2), two(3, 2);
  for (uint32_t i = 0; i < 6; ++i) {
    const Vec3 a(static_cast<float>(i) * 0.37f), b(1.0f / (1 + static_cast<float>(i)));
    both.add(i, 0, a, 4), both.add(i, 1, b, 2);
    one.add(i, 0, a, 4), two.add(i, 1, b, 2);
  }
  one.merge(two);
  for (uint32_t i = 0; i < 6; ++i) {
    EXPECT_EQ(one.radiance(i), both.radiance(i));
    EXPECT_EQ(one.variance(i), both.variance(i));
  }
  EXPECT_EQ(one.image().pixels, both.image().pixels);
}

TEST(Film, PreviewIsThePictureWhereAllIsSampled) {
  Film film(37, 29);
  for (uint32_t i = 0; i < 37 * 29; ++i) film.add(i, 0, Vec3(static_cast<float>(i)), 1);
  EXPECT_EQ(film.preview().pixels, film.image().pixels);
}

TEST(Film, PreviewFillsFromTheCoarsePixels) {
  Film film(6, 5);
  film.add(0, 0, Vec3(1), 1);  // corner of the first block
  film.add(4, 0, Vec3(2), 1);  // and of the one beside it
  film.add(2 * 6 + 2, 0, Vec3(3), 1);
  const ImageRgb preview = film.preview();
  EXPECT_EQ(preview.at(1, 1), Vec3(1));
  EXPECT_EQ(preview.at(5, 3), Vec3(2));
  EXPECT_EQ(preview.at(3, 3), Vec3(3));
  EXPECT_EQ(preview.at(2, 2), Vec3(3));
  EXPECT_EQ(preview.at(0, 4), Vec3(0));  // nothing near yet
}

ImageRgb filled(int w, int h, Vec3 color) { return {w, h, color}; }

TEST(Metrics, AgreeWithHandComputation) {
  ImageRgb reference = filled(2, 1, Vec3(1)), image = reference;
  image.at(0, 0) = {1.5f, 1, 1};
  const ErrorMetrics metrics = measure_error(image, reference);
  const double relative = 0.25 / (1 + 1e-4);
  EXPECT_NEAR(metrics.relmse, relative / 6, 1e-9);
  EXPECT_NEAR(metrics.rmse, std::sqrt(0.25 / 6), 1e-9);
  EXPECT_NEAR(metrics.smape, 0.5 / 2.5 / 6, 1e-9);
  EXPECT_EQ(measure_error(reference, reference).relmse, 0);
  EXPECT_EQ(measure_error(filled(3, 3, Vec3(0)), filled(3, 3, Vec3(0))).smape, 0);
  EXPECT_EQ(measure_error(filled(3, 3, Vec3(1)), filled(3, 3, Vec3(0))).relmse, 1);
}

TEST(Metrics, PixelsThatAreNotFiniteAreEndlesslyWrong) {
  ImageRgb reference = filled(60, 50, Vec3(1)), image = filled(60, 50, Vec3(1.1f));
  image.at(7, 7).y = std::numeric_limits<float>::quiet_NaN();
  const ErrorMetrics metrics = measure_error(image, reference);
  EXPECT_EQ(metrics.relmse, infinity);
  EXPECT_EQ(metrics.rmse, infinity);
  EXPECT_NEAR(metrics.relmse_trimmed, 0.01 / 1.0001, 1e-4);  // one pixel of 3000 is among the three dropped
  EXPECT_NEAR(metrics.smape, (2999 * (0.1 / 2.1) + 1) / 3000, 1e-6);
  EXPECT_TRUE(metrics.flip >= 0 && metrics.flip <= 1);
  EXPECT_EQ(measure_error(reference, image).relmse, infinity);
}

TEST(Metrics, StayFiniteAtTheEndsOfTheRange) {
  for (const float scale : {1e-30f, 1e30f}) {
    const ErrorMetrics metrics = measure_error(filled(4, 4, Vec3(scale)), filled(4, 4, Vec3(2 * scale)));
    EXPECT_NEAR(metrics.relmse, 0.25 / 1.0001, 1e-4);
    EXPECT_NEAR(metrics.rmse / scale, 1, 1e-6);
    EXPECT_NEAR(metrics.smape, 1.0 / 3, 1e-6);
  }
}

TEST(Metrics, TrimmingDropsTheWorstThousandth) {
  ImageRgb reference = filled(100, 20, Vec3(1)), image = filled(100, 20, Vec3(1.1f));
  image.at(3, 3) = image.at(50, 10) = Vec3(1000);
  image.at(7, 19) = Vec3(11);  // the third of 2000: stays
  const ErrorMetrics metrics = measure_error(image, reference);
  EXPECT_GT(metrics.relmse, 100);
  EXPECT_NEAR(metrics.relmse_trimmed, (1997 * 0.01 + 100) / 1998 / 1.0001, 1e-4);
}

TEST(Flip, IsZeroForEqualsAndSymmetric) {
  ImageRgb a(40, 30), b(40, 30);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x) {
      a.at(x, y) = Vec3(0.5f + 0.5f * std::sin(0.3f * x), 0.2f, 0.02f * y);
      b.at(x, y) = Vec3(0.5f + 0.5f * std::sin(0.31f * x), 0.25f, 0.02f * y);
    }
  for (const float v : flip_map(a, a)) EXPECT_EQ(v, 0);
  const std::vector<float> ab = flip_map(a, b), ba = flip_map(b, a);
  for (size_t i = 0; i < ab.size(); ++i) {
    EXPECT_NEAR(ab[i], ba[i], 1e-6f);
    EXPECT_GE(ab[i], 0);
    EXPECT_LE(ab[i], 1);
  }
}

TEST(Flip, ConstantPicturesFollowTheFormulas) {
  // No features, and filters leave constants alone: redistribute(HyAB(Hunt Lab)^0.7). Grey has no chroma, so
  // HyAB is the difference of lightness; black to white is 100. The largest difference, green to blue, by the
  // same formulas.
  const auto lightness = [](double y) {
    return y > 216.0 / 24389 ? 116 * std::cbrt(y) - 16 : y * 24389.0 / 27;
  };
  // Hunt-adjusted Lab of the sRGB primaries, computed from their published L*a*b* (D65).
  const double green[] = {87.7347, 0.877347 * -86.1827, 0.877347 * 83.1793};
  const double blue[] = {32.297, 0.32297 * 79.1875, 0.32297 * -107.8602};
  const double most = std::pow(green[0] - blue[0] + std::hypot(green[1] - blue[1], green[2] - blue[2]), 0.7);
  const auto expected = [&](double y1, double y2) {
    const double d = std::pow(std::abs(lightness(y1) - lightness(y2)), 0.7);
    return d < 0.4 * most ? 0.95 / (0.4 * most) * d : 0.95 + (d - 0.4 * most) / (0.6 * most) * 0.05;
  };
  for (const auto& [a, b] : {std::pair{0.0f, 1.0f}, {0.2f, 0.21f}, {0.5f, 0.1f}, {0.02f, 0.0f}}) {
    const std::vector<float> map = flip_map(filled(24, 24, Vec3(a)), filled(24, 24, Vec3(b)));
    EXPECT_NEAR(map[12 * 24 + 12], expected(a, b), 2e-3) << a << " " << b;
  }
}

TEST(Flip, SeesAnEdgeMoreThanAnEvenDifference) {
  ImageRgb flat = filled(40, 40, Vec3(0.4f)), line = flat, haze = filled(40, 40, Vec3(0.4f));
  for (int y = 0; y < 40; ++y) line.at(20, y) = Vec3(0.9f);
  for (int y = 0; y < 40; ++y)
    for (int x = 15; x < 26; ++x) haze.at(x, y) = Vec3(0.4f + 0.5f / 11);
  EXPECT_GT(flip_map(line, flat)[20 * 40 + 20], flip_map(haze, flat)[20 * 40 + 20]);
}

TEST(ToneMaps, CurvesAreMonotoneAndBounded) {
  for (const ToneMap& map : tone_maps()) {
    float before = -1;
    for (float l = 1e-4f; l < 1e4f; l *= 1.3f) {
      const Vec3 c = map.map(Vec3(l));
      EXPECT_GE(c.x, 0);
      EXPECT_LE(max_component(c), 1);
      if (map.id == "falsecolor") continue;
      EXPECT_GE(luminance(c), before);
      before = luminance(c);
    }
    EXPECT_EQ(map.map(Vec3(0)).x > 0.1f, false);
  }
  EXPECT_EQ(find_tone_map("linear").map(Vec3(0.25f)), Vec3(0.25f));
  EXPECT_THROW(find_tone_map("linea"), Error);
}

TEST(ToneMaps, AnyRadianceHasAColour) {
  for (const ToneMap& map : tone_maps()) {
    const Vec3 blinding = map.map(Vec3(1e30f));
    EXPECT_GT(luminance(blinding), 0.9f) << map.id;
    EXPECT_LE(max_component(blinding), 1) << map.id;
    EXPECT_GT(luminance(map.map(Vec3(infinity))), 0.9f) << map.id;
    EXPECT_LT(luminance(map.map(Vec3(1e-30f))), 0.05f) << map.id;
    EXPECT_TRUE(is_finite(map.map(Vec3(-1, 2, 0)))) << map.id;
  }
}

TEST(ToneMaps, CurvesFollowTheirFormulas) {
  const Vec3 color(0.5f, 1, 2);
  const float l = 0.2126f * 0.5f + 0.7152f + 0.0722f * 2;
  const Vec3 reinhard = find_tone_map("reinhard").map(color);
  EXPECT_NEAR(reinhard.x, 0.5f / (1 + l), 1e-6f);
  EXPECT_NEAR(reinhard.y / reinhard.x, 2, 1e-5f);  // hue kept
  // Narkowicz: (x (2.51 x + 0.03)) / (x (2.43 x + 0.59) + 0.14) at 0.6 times the exposed value.
  const double x = 0.6;
  EXPECT_NEAR(find_tone_map("filmic").map(Vec3(1)).x, x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14),
              1e-6);
}

TEST(ToneMaps, FalseColourTellsStopsApart) {
  const ToneMap& map = find_tone_map("falsecolor");
  // A stop is the same step anywhere on the scale, for any hue of the same luminance.
  for (int stop = -8; stop < 8; ++stop) {
    const Vec3 here = map.map(Vec3(0.18f * std::exp2(static_cast<float>(stop)))),
               next = map.map(Vec3(0.18f * std::exp2(stop + 1.0f)));
    EXPECT_GT(glm::distance(here, next), 0.08f) << stop;
  }
  const Vec3 red(0.18f / 0.2126f, 0, 0);
  EXPECT_LT(glm::distance(map.map(red), map.map(Vec3(0.18f))), 1e-4f);
  EXPECT_EQ(map.map(Vec3(1e6f)), map.map(Vec3(0.18f * 256)));
}

TEST(ToneMaps, SrgbIsItsOwnInverse) {
  EXPECT_NEAR(srgb_encode(0.5f), 0.7353570f, 1e-5f);
  EXPECT_NEAR(srgb_encode(0.002f), 0.02584f, 1e-6f);
  for (float v = 0; v <= 1; v += 0.01f) EXPECT_NEAR(srgb_decode(srgb_encode(v)), v, 1e-5f);
}

TEST(ToneMaps, DisplayImageAppliesExposureAndSurvivesNaN) {
  ImageRgb image = filled(3, 1, Vec3(0.25f));
  image.at(1, 0) = Vec3(std::numeric_limits<float>::quiet_NaN());
  image.at(2, 0) = Vec3(infinity, -1, 0);
  const ImageRgba8 shown = display_image(image, 1, find_tone_map("linear"));
  EXPECT_EQ(shown.bytes[0], static_cast<int>(0.7353570f * 255 + 0.5f));
  EXPECT_EQ(shown.bytes[4], 0);
  EXPECT_EQ(shown.bytes[8], 255);
  EXPECT_EQ(shown.bytes[9], 0);
  EXPECT_EQ(shown.bytes[11], 255);
}

}  // namespace
}  // namespace halflight
