// What every technique in the registry must keep; a new one inherits these tests.
#include <gtest/gtest.h>

#include "core/parallel.h"
#include "support/box_room.h"
#include "support/statistics.h"

namespace halflight {
namespace {

/// A technique by name with its settings applied.
struct Case {
  std::string_view id;
  std::vector<std::pair<std::string, std::string>> settings;
};

/// How close to the exact sum a technique's mean can be brought in the time a test has: those that do not
/// know the BRDF at the leaves are noisier here.
double affordable_interval(const Case& c) {
  return c.id == "light-bvh" || c.id == "stochastic-lightcuts" ? 0.01 : 0.005;
}

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.id;
  for (const auto& [key, value] : c.settings) *out << " " << key << "=" << value;
}

/// All techniques that are unbiased for the sum over S, in the variants worth telling apart.
std::vector<Case> unbiased_cases() {
  std::vector<Case> cases;
  for (const TechniqueInfo& info : techniques())
    if (info.bias == Bias::unbiased && info.target != TargetSupport::continuous &&
        info.target != TargetSupport::own)
      cases.push_back({info.id, {}});
  cases.push_back({"bidirectional", {{"bidirectional.brdf-samples", "0"}}});
  cases.push_back({"bidirectional", {{"bidirectional.tau", "1"}, {"bidirectional.alpha", "0.2"}}});
  cases.push_back({"brdf", {{"brdf.brdf-samples", "0"}}});
  cases.push_back({"sir", {{"sir.initial", "40"}}});
  cases.push_back({"mis", {{"mis.brdf-share", "1"}}});
  cases.push_back({"mis", {{"mis.brdf-share", "0.2"}, {"brdf.brdf-samples", "8"}}});
  cases.push_back({"stochastic-lightcuts", {{"stochastic-lightcuts.cut", "5"}}});
  cases.push_back({"stochastic-lightcuts", {{"stochastic-lightcuts.cut", "1024"}}});
  return cases;
}

std::unique_ptr<Technique> make(const Case& c, Room& room) {
  for (const auto& [key, value] : c.settings) room.settings.set(key, value);
  auto technique = find_technique(c.id).make();
  technique->prepare(room.frame);
  return technique;
}

PassRequest request_of(uint32_t pass, uint32_t samples) {
  PassRequest request;
  request.pass = pass, request.samples = samples;
  return request;
}

std::vector<Vec3> picture(const Case& c, const RoomOptions& options, const std::vector<Brdf>& brdfs,
                          uint32_t samples, uint32_t passes = 1) {
  Room room(options, brdfs, 40);
  const auto technique = make(c, room);
  Film film(room.gbuffer.width, room.gbuffer.height);
  for (uint32_t pass = 0; pass < passes; ++pass)
    technique->run_pass(room.frame, request_of(pass, samples), film);
  EXPECT_EQ(film.nan_samples(), 0u);
  std::vector<Vec3> result;
  for (uint32_t i = 0; i < room.gbuffer.texels.size(); ++i) result.push_back(film.radiance(i));
  return result;
}

class TechniqueContract : public testing::TestWithParam<Case> {};

TEST_P(TechniqueContract, EveryLightsProbabilityTimesItsWeightIsOne) {
  for (const float light : {1e-30f, 1.0f, 1e30f}) {
    for (const uint32_t most : {1u, 40u, 100000u}) {
      RoomOptions options;
      options.light = light;
      options.cut.least = options.cut.most = most;
      std::vector<Brdf> brdfs = hard_brdfs();
      for (const Brdf& mild : mild_brdfs()) brdfs.push_back(mild);
      Room room(options, brdfs);
      const auto technique = make(GetParam(), room);
      for (uint32_t pixel = 0; pixel < room.gbuffer.texels.size(); ++pixel) {
        const auto inspection = technique->inspect(room.frame, request_of(0, 37), pixel);
        if (!inspection) GTEST_SKIP() << "tells no probabilities";
        double sum = 0;
        for (size_t i = 0; i < room.tree.lights.size(); ++i) {
          const double p = inspection->probability[i];
          sum += p;
          if (leaf_power(room.tree.lights[i]) > 0) {
            ASSERT_GT(p, 0);
          }
          if (p > 0) {
            ASSERT_NEAR(p * inspection->weight[i], 1, 1e-6);
          }
        }
        ASSERT_NEAR(sum, 1, 1e-9);
        for (size_t j = 0; j < inspection->draws.size(); ++j) {
          const LightSample& draw = inspection->draws[j];
          ASSERT_EQ(draw.weight, inspection->weight[draw.light]);
          ASSERT_GE(draw.light, inspection->draws[j > 0 ? j - 1 : 0].light) << "in tree order";
        }
      }
    }
  }
}

TEST_P(TechniqueContract, DrawsFollowTheProbabilities) {
  Room room({}, mild_brdfs());
  const auto technique = make(GetParam(), room);
  // The distribution of a pixel may depend on its random numbers; each pass is compared with its own.
  for (const uint32_t pixel : {1u, 2u}) {
    if (!technique->inspect(room.frame, request_of(0, 1), pixel)) GTEST_SKIP() << "tells no probabilities";
    constexpr uint32_t passes = 3000, samples = 32;
    std::vector<double> observed(room.tree.lights.size()), expected(room.tree.lights.size());
    for (uint32_t pass = 0; pass < passes; ++pass) {
      const auto inspection = technique->inspect(room.frame, request_of(pass, samples), pixel);
      for (size_t i = 0; i < expected.size(); ++i) expected[i] += samples * inspection->probability[i];
      for (const LightSample& draw : inspection->draws) observed[draw.light] += 1;
    }
    EXPECT_GT(chi_square_p(observed, expected), 1e-3) << "leaves";
    // Nodes: the cut's clusters, whose counts are large enough to show what single leaves hide.
    std::vector<double> observed_nodes(room.cut.size), expected_nodes(room.cut.size);
    for (uint32_t k = 0; k < room.cut.size; ++k)
      for (uint32_t i = room.cut.begin[k]; i < room.cut.end[k]; ++i)
        observed_nodes[k] += observed[i], expected_nodes[k] += expected[i];
    ASSERT_GE(room.cut.size, 64u);
    EXPECT_GT(chi_square_p(observed_nodes, expected_nodes), 1e-3) << "nodes";
  }
}

/// Mean of each pixel over some passes, and that mean's variance.
struct Estimates {
  std::vector<double> mean, variance;
};

Estimates estimate(Technique& technique, const Room& room, uint32_t first_pass, uint32_t passes) {
  const size_t pixels = room.gbuffer.texels.size();
  Estimates e{std::vector<double>(pixels), std::vector<double>(pixels)};
  std::vector<double> squares(pixels);
  const double n = passes;
  for (uint32_t pass = 0; pass < passes; ++pass) {
    Film film(room.gbuffer.width, room.gbuffer.height);
    technique.run_pass(room.frame, request_of(first_pass + pass, 32), film);
    for (uint32_t i = 0; i < pixels; ++i) {
      const double value = luminance(film.radiance(i));
      e.mean[i] += value / n, squares[i] += value * value / n;
    }
  }
  for (uint32_t i = 0; i < pixels; ++i)
    e.variance[i] = std::max(0.0, squares[i] - e.mean[i] * e.mean[i]) / std::max(n - 1, 1.0);
  return e;
}

/// One distinct pixel over all its copies.
struct Pooled {
  double mean = 0, variance = 0;

  Pooled(const Estimates& e, uint32_t pixel, uint32_t distinct) {
    const double copies = static_cast<double>(e.mean.size()) / distinct;
    for (size_t i = pixel; i < e.mean.size(); i += distinct)
      mean += e.mean[i] / copies, variance += e.variance[i] / (copies * copies);
  }
};

TEST_P(TechniqueContract, MeanIsTheExactSum) {
  std::vector<Brdf> brdfs = mild_brdfs();
  brdfs.pop_back();  // noise of the sharpest would take too long to average
  const auto distinct = static_cast<uint32_t>(brdfs.size());
  for (const Target target : {Target::discrete, Target::continuous}) {
    const TechniqueInfo& info = find_technique(GetParam().id);
    if (target == Target::continuous && (info.target != TargetSupport::both || info.leaves_s_when_continuous))
      continue;
    RoomOptions options;
    options.target = target, options.sun = 20;
    Room room(options, brdfs, 50);
    const auto technique = make(GetParam(), room);

    // A pilot's variance sets the number of passes: the interval at the level below is half a per cent of the
    // value, or what can be afforded.
    const double bound = two_sided_bound(sidak_level(0.01, distinct));
    const Estimates pilot = estimate(*technique, room, 1000000, 16);
    double passes = 16;
    for (uint32_t i = 0; i < distinct; ++i) {
      const Pooled pooled(pilot, i, distinct);
      passes = std::max(passes, 16 * pooled.variance *
                                    std::pow(bound / (affordable_interval(GetParam()) * pooled.mean), 2));
    }
    ASSERT_LT(passes, 3000) << "too noisy a case for this test";
    const Estimates result = estimate(*technique, room, 0, static_cast<uint32_t>(passes));
    double squares = 0;
    for (uint32_t i = 0; i < distinct; ++i) {
      const Vec3d exact = room.exact(i);
      const double truth = 0.2126 * exact.x + 0.7152 * exact.y + 0.0722 * exact.z;
      const Pooled pooled(result, i, distinct);
      const double interval = bound * std::sqrt(pooled.variance) + 1e-5 * truth;  // floats on the way
      ASSERT_GT(truth, 0);
      EXPECT_NEAR(pooled.mean, truth, interval) << "pixel " << i;
      EXPECT_LT(interval, 1.4 * affordable_interval(GetParam()) * truth);
      for (size_t j = i; j < result.mean.size(); j += distinct)
        squares += std::pow(result.mean[j] - truth, 2) / (result.variance[j] + 1e-10 * truth * truth);
    }
    const double rms = std::sqrt(squares / static_cast<double>(result.mean.size()));
    EXPECT_LT(rms, 1.12);
    if (GetParam().id != "reference") {
      EXPECT_GT(rms, 0.88);
    }
  }
}

TEST_P(TechniqueContract, SameBitsForAnyNumberOfThreads) {
  set_thread_count(1);
  const auto one = picture(GetParam(), {}, mild_brdfs(), 9, 2);
  for (const int threads : {2, 5}) {
    set_thread_count(threads);
    EXPECT_EQ(picture(GetParam(), {}, mild_brdfs(), 9, 2), one);
  }
  set_thread_count(0);
}

TEST_P(TechniqueContract, ScalesWithLengthAndLight) {
  const auto reference = picture(GetParam(), {}, mild_brdfs(), 16);
  for (const int exponent : {-20, 20}) {
    RoomOptions options;
    options.size = std::ldexp(options.size, exponent);
    options.light = std::ldexp(1.0f, -exponent);
    const auto scaled = picture(GetParam(), options, mild_brdfs(), 16);
    for (size_t i = 0; i < scaled.size(); ++i)
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(std::ldexp(scaled[i][c], exponent), reference[i][c], 1e-5 * reference[i][c]) << i;
  }
}

TEST_P(TechniqueContract, ScalesWithTheFaintestAndTheStrongestLight) {
  const auto reference = picture(GetParam(), {}, mild_brdfs(), 16);
  constexpr double denormal = 1e-7;         // 2⁻¹²⁶ of the faintest
  for (const int exponent : {-100, 100}) {  // about 1e-30 and 1e30
    RoomOptions options;
    options.light = std::ldexp(1.0f, exponent);
    const auto scaled = picture(GetParam(), options, mild_brdfs(), 16);
    for (size_t i = 0; i < scaled.size(); ++i)
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(std::ldexp(scaled[i][c], -exponent), reference[i][c], 1e-5 * reference[i][c] + denormal)
            << i;
  }
}

TEST_P(TechniqueContract, BackgroundAndBlackKeepTheirBase) {
  std::vector<Brdf> brdfs = mild_brdfs();
  brdfs[1] = {};
  Room room({}, brdfs, 2);
  room.gbuffer.texels[0].triangle = no_triangle;
  for (size_t i = 0; i < room.base.size(); ++i) room.base[i] = Vec3(1, 2, 3) * static_cast<float>(i + 1);
  const auto technique = make(GetParam(), room);
  Film film(room.gbuffer.width, room.gbuffer.height);
  const PassStats stats = technique->run_pass(room.frame, request_of(0, 8), film);
  EXPECT_EQ(film.radiance(0), room.base[0]);
  EXPECT_EQ(film.radiance(1), room.base[1]);
  float added = 0;
  for (uint32_t i = 2; i < brdfs.size(); ++i) added += film.radiance(i).x - room.base[i].x;
  EXPECT_GT(added, 0);
  EXPECT_EQ(stats.pixels, room.gbuffer.texels.size());
  EXPECT_EQ(stats.useful_rays, stats.rays.visibility);
  EXPECT_GT(stats.useful_rays, 0u);
  EXPECT_TRUE(stats.finished);
}

TEST_P(TechniqueContract, AnyNumberOfSamplesAndEitherHalf) {
  for (const uint32_t samples : {1u, 2u, 3u, 7u, 3000u}) {
    Room room({}, mild_brdfs());
    const auto technique = make(GetParam(), room);
    Film film(room.gbuffer.width, room.gbuffer.height);
    for (uint32_t pass = 0; pass < 2; ++pass)
      technique->run_pass(room.frame, request_of(pass, samples), film);
    EXPECT_EQ(film.samples(0), 2 * samples);
    EXPECT_GE(film.estimated_relmse(), 0) << "both halves have samples";

    Film one(room.gbuffer.width, room.gbuffer.height);
    PassRequest request = request_of(0, samples);
    request.half = 1;
    technique->run_pass(room.frame, request, one);
    EXPECT_EQ(one.samples(0), samples);
    EXPECT_LT(one.estimated_relmse(), 0) << "one half has none";
  }
}

TEST_P(TechniqueContract, SubsetsOfPixelsMakeAWholePass) {
  Room room({}, mild_brdfs(), 11);
  const auto technique = make(GetParam(), room);
  Film whole(room.gbuffer.width, room.gbuffer.height), parts(room.gbuffer.width, room.gbuffer.height);
  technique->run_pass(room.frame, request_of(0, 4), whole);
  for (uint32_t offset = 0; offset < 16; ++offset) {
    PassRequest request = request_of(0, 4);
    request.stride = 4, request.offset = offset;
    technique->run_pass(room.frame, request, parts);
  }
  for (uint32_t i = 0; i < room.gbuffer.texels.size(); ++i) {
    EXPECT_EQ(parts.samples(i), 4u);
    EXPECT_EQ(parts.radiance(i), whole.radiance(i));
  }
}

TEST_P(TechniqueContract, StopsWhenAsked) {
  Room room({}, mild_brdfs(), 11);
  const auto technique = make(GetParam(), room);
  Film film(room.gbuffer.width, room.gbuffer.height);
  std::stop_source source;
  source.request_stop();
  PassRequest request = request_of(0, 4);
  request.stop = source.get_token();
  EXPECT_FALSE(technique->run_pass(room.frame, request, film).finished);
  EXPECT_EQ(film.samples(0), 0u);
}

TEST_P(TechniqueContract, NoLightIsBlackAndOneLightWorks) {
  RoomOptions dark;
  dark.light = 0;
  for (const Vec3 value : picture(GetParam(), dark, mild_brdfs(), 4)) EXPECT_EQ(value, Vec3(0));
  RoomOptions one;
  one.wall_lights = one.sky_lights = 0, one.lamps = 1;
  const auto lit = picture(GetParam(), one, mild_brdfs(), 4);
  Room room(one, mild_brdfs());
  for (uint32_t i = 0; i < mild_brdfs().size(); ++i)  // a single light leaves nothing to chance
    EXPECT_NEAR(lit[i].y, room.exact(i).y, 1e-4 * room.exact(i).y);
}

TEST(Registry, EveryTechniqueTellsWhatItIs) {
  for (const TechniqueInfo& info : techniques()) {
    EXPECT_FALSE(info.title.empty()) << info.id;
    EXPECT_FALSE(info.source.empty()) << info.id;
    EXPECT_NE(info.note.find(info.bias == Bias::biased ? "bias" : "unbiased"), std::string_view::npos)
        << info.id;
    for (const SettingInfo& setting : info.settings)
      EXPECT_TRUE(setting.key.starts_with(std::string(info.id) + ".")) << setting.key;
  }
}

INSTANTIATE_TEST_SUITE_P(Registry, TechniqueContract, testing::ValuesIn(unbiased_cases()));

}  // namespace
}  // namespace halflight
