#include <gtest/gtest.h>

#include "core/random.h"
#include "film/sample_allocation.h"

namespace halflight {
namespace {

constexpr int side = 32;
constexpr uint32_t pixel_count = side * side;
constexpr uint32_t a_round = 8;  ///< samples a pixel of a uniform pass

/// A draw that is 10 once in twenty times and else 0: a mean of 0.5 that few samples tell.
float rare(RandomStream& random) { return random.next() < 0.05f ? 10.0f : 0.0f; }

/// Adds `samples` draws to a pixel, half of them to each half.
template <class Draw>
void sample(Film& film, uint32_t pixel, uint32_t samples, RandomStream& random, const Draw& draw) {
  for (int half = 0; half < 2; ++half) {
    float sum = 0;
    for (uint32_t i = 0; i < samples / 2; ++i) sum += draw(random);
    film.add(pixel, half, Vec3(sum / static_cast<float>(samples / 2)), samples / 2);
  }
}

template <class Draw>
Film uniform_film(uint64_t seed, const Draw& draw) {
  Film film(side, side);
  for (uint32_t i = 0; i < pixel_count; ++i) {
    RandomStream random(i, 0, seed);
    sample(film, i, a_round, random, [&](RandomStream& r) { return draw(i, r); });
  }
  return film;
}

SampleAllocation learned(const Film& film) {
  SampleAllocation allocation(side, side);
  allocation.learn(Film(side, side), film);
  return allocation;
}

uint32_t total(const std::vector<uint16_t>& samples, int from_x, int to_x) {
  uint32_t sum = 0;
  for (int y = 0; y < side; ++y)
    for (int x = from_x; x < to_x; ++x) sum += samples[static_cast<size_t>(y) * side + x];
  return sum;
}

TEST(SampleAllocation, FollowsTheStandardDeviation) {
  const auto draw = [](uint32_t pixel, RandomStream& random) {
    return 1 + (pixel % side < side / 2 ? 0.8f : 0.2f) * (random.next() - 0.5f);
  };
  const Film film = uniform_film(1, draw);
  const SampleAllocation allocation = learned(film);
  std::vector<uint16_t> samples;
  ASSERT_TRUE(allocation.next_round(film, allocation.scale_for_samples(film, 2000), 4096, samples));
  // Away from the border between the two; smoothing leaves some spread.
  const double ratio = static_cast<double>(total(samples, 0, 10)) / total(samples, 22, side);
  EXPECT_NEAR(ratio, 4, 0.8);
}

TEST(SampleAllocation, APixelsOwnSamplesDecideNothingThere) {
  const auto draw = [](uint32_t, RandomStream& random) { return 0.5f + random.next(); };
  const Film film = uniform_film(2, draw);
  Film other = film;
  constexpr uint32_t pixel = side * 16 + 16;
  // The other film has a bright sample more, in one half of one pixel.
  other.clear();
  for (uint32_t i = 0; i < pixel_count; ++i)
    for (int half = 0; half < 2; ++half)
      other.add(i, half, Vec3(film.half_mean(i, half)) + (i == pixel && half == 0 ? 20.0f : 0.0f),
                a_round / 2);
  const SampleAllocation a = learned(film), b = learned(other);
  std::vector<uint16_t> samples_a, samples_b;
  ASSERT_TRUE(a.next_round(film, 200, 256, samples_a));
  ASSERT_TRUE(b.next_round(other, 200, 256, samples_b));
  EXPECT_EQ(samples_a[pixel], samples_b[pixel]);
  EXPECT_LT(samples_a[pixel + 1], samples_b[pixel + 1]) << "its neighbours do not hear of it";
}

TEST(SampleAllocation, ExpectsTheErrorThatComes) {
  const auto draw = [](uint32_t, RandomStream& random) { return rare(random); };
  Film film = uniform_film(3, draw);
  const SampleAllocation allocation = learned(film);
  const double wanted = 0.5, scale = allocation.scale_for_error(film, wanted);
  EXPECT_NEAR(allocation.expected_relmse(film, scale), wanted, 1e-3);
  std::vector<uint16_t> samples;
  while (allocation.next_round(film, scale, 256, samples))
    for (uint32_t i = 0; i < pixel_count; ++i) {
      RandomStream random(i, film.samples(i), 4);
      sample(film, i, samples[i], random, rare);
    }
  double error = 0;
  for (uint32_t i = 0; i < pixel_count; ++i) error += std::pow(film.radiance(i).x - 0.5, 2) / 0.25;
  // What a visit is not worth is left out, and the truth is not what the passes saw.
  EXPECT_NEAR(error / pixel_count, wanted, 0.25 * wanted);
}

TEST(SampleAllocation, LeavesTheMeanUnbiased) {
  constexpr int pictures = 300;
  double sum = 0, sum2 = 0;
  for (int picture = 0; picture < pictures; ++picture) {
    const auto seed = static_cast<uint64_t>(100 + picture);
    Film film = uniform_film(seed, [](uint32_t, RandomStream& random) { return rare(random); });
    const SampleAllocation allocation = learned(film);
    std::vector<uint16_t> samples;
    for (const double mean : {20.0, 40.0})
      if (allocation.next_round(film, allocation.scale_for_samples(film, mean), 256, samples))
        for (uint32_t i = 0; i < pixel_count; ++i) {
          RandomStream random(i, film.samples(i), seed);
          if (samples[i] > 0) sample(film, i, samples[i], random, rare);
        }
    const double mean = film.mean_radiance().x;
    sum += mean, sum2 += mean * mean;
  }
  const double mean = sum / pictures, error = std::sqrt((sum2 / pictures - mean * mean) / (pictures - 1));
  ASSERT_LT(error, 0.002) << "too few pictures to tell";
  EXPECT_NEAR(mean, 0.5, 3.3 * error);
}

}  // namespace
}  // namespace halflight
