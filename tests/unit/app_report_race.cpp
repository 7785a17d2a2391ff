// From made-up races to curves, verdicts and pages.
#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"
#include "report/error_map.h"
#include "report/html_parts.h"
#include "report/report_html.h"
#include "report/report_json.h"

namespace halflight {
namespace {

/// A racer whose error is `scale`/x, moved by up to `noise` of it from run to run.
Racer racer(const std::string& id, double scale, double noise, size_t runs = 5) {
  Racer racer;
  racer.id = id;
  racer.target = "discrete";
  for (size_t r = 0; r < runs; ++r) {
    RaceRun run{r, true, {}};
    for (uint32_t c = 0; c < 5; ++c) {
      RaceSnapshot s;
      s.checkpoint = c, s.budget = s.wall_seconds = std::exp2(c), s.spp = 10 * s.budget;
      const double wave = 2 * RandomStream(r, c, static_cast<uint64_t>(id.front())).next() - 1;
      s.relmse = scale / s.wall_seconds * (1 + noise * wave);
      run.snapshots.push_back(s);
    }
    racer.runs.push_back(run);
  }
  return racer;
}

Race race_of(std::vector<Racer> racers) {
  Race race;
  race.title = "made up";
  race.target = "discrete";
  race.width = race.height = 10;
  race.budgets = {1, 2, 4, 8, 16};
  race.seeds = {0, 1, 2, 3, 4};
  race.racers = std::move(racers);
  race.reference.exact = true;
  return race;
}

const Verdict& verdict(const Analysis& analysis, const std::string& measure) {
  for (const Verdict& v : analysis.verdicts)
    if (v.measure == measure) return v;
  ADD_FAILURE() << "no verdict on " << measure;
  return analysis.verdicts.front();
}

TEST(Analysis, RanksAndMeasures) {
  const Race race = race_of({racer("slow", 0.08, 0.02), racer("fast", 0.02, 0.02)});
  const Analysis analysis = analyse(race);
  ASSERT_EQ(analysis.results.size(), 2u);
  const RacerResult &fast = analysis.results[0], &slow = analysis.results[1];
  EXPECT_EQ(race.racers[fast.racer].id, "fast");
  EXPECT_NEAR(fast.slope.value, -1, 0.05);
  EXPECT_LE(fast.slope.low, fast.slope.value);
  EXPECT_NEAR(fast.reach[0].value, 2, 0.1);
  EXPECT_NEAR(slow.reach[0].value, 8, 0.4);
  EXPECT_TRUE(std::isinf(slow.reach[1].value));
  EXPECT_NEAR(verdict(analysis, "error").ratio.value, 0.25, 0.02);
  EXPECT_NEAR(verdict(analysis, "1e-2").ratio.value, 0.25, 0.02);
  EXPECT_TRUE(verdict(analysis, "1e-2").seen);
  EXPECT_EQ(verdict(analysis, "1e-2").text.find("fast reaches relMSE 1e-2 in 0.2"), 0u)
      << verdict(analysis, "1e-2").text;
}

TEST(Analysis, WhatDiffersLessThanItsNoiseIsNotSeen) {
  const Analysis analysis = analyse(race_of({racer("a", 0.0300, 0.3), racer("b", 0.0303, 0.3)}));
  EXPECT_FALSE(verdict(analysis, "error").seen);
  EXPECT_EQ(verdict(analysis, "error").text.find("No difference seen"), 0u)
      << verdict(analysis, "error").text;
}

TEST(Analysis, WhoNeverArrivesIsSaidToHaveNot) {
  const Analysis analysis = analyse(race_of({racer("far", 3, 0.01), racer("near", 0.05, 0.01)}));
  EXPECT_NE(verdict(analysis, "1e-2").text.find("far has not by 16 s"), std::string::npos)
      << verdict(analysis, "1e-2").text;
  EXPECT_FALSE(verdict(analysis, "1e-2").ratio.known());
}

TEST(Analysis, FewRunsHaveRatiosWithoutIntervals) {
  const Analysis analysis = analyse(race_of({racer("a", 0.02, 0.01, 4), racer("b", 0.08, 0.01, 4)}));
  EXPECT_FALSE(verdict(analysis, "error").seen);
  EXPECT_NE(verdict(analysis, "error").text.find("the error of a is 0.2"), std::string::npos);
  EXPECT_NE(verdict(analysis, "error").text.find("too few runs"), std::string::npos);
}

TEST(Analysis, PreviewsShareNoVerdict) {
  Race race = race_of({racer("honest", 0.05, 0.01), racer("biased", 0.001, 0.01)});
  race.racers[1].preview = true;
  race.racers[1].why_preview = "no visibility";
  const Analysis analysis = analyse(race);
  EXPECT_TRUE(analysis.verdicts.empty());
  EXPECT_TRUE(analysis.results.back().preview);
  EXPECT_NE(race_html(race, analysis).find("Previews, not ranked"), std::string::npos);
  EXPECT_FALSE(race_json(race, analysis)["techniques"][1].contains("slope"));
}

TEST(Analysis, ErrorsBelowTheReferencesOwnAreInNoFit) {
  Race race = race_of({racer("a", 0.02, 0.01)});
  for (RaceRun& run : race.racers[0].runs) run.snapshots.back().relmse = 1e-4;  // as if better than it is
  race.reference.exact = false;
  race.reference.relmse = 1e-3;
  const Analysis analysis = analyse(race);
  EXPECT_TRUE(analysis.results[0].points.back().doubtful);
  EXPECT_NEAR(analysis.results[0].slope.value, -1, 0.05);
  EXPECT_TRUE(std::isinf(analysis.results[0].reach[1].value));
}

TEST(Analysis, OnlyCompleteRunsAndCommonCheckpointsCount) {
  Race race = race_of({racer("a", 0.02, 0.01)});
  race.racers[0].runs[1].complete = false;
  race.racers[0].runs[2].snapshots.erase(race.racers[0].runs[2].snapshots.begin());
  const Analysis analysis = analyse(race);
  EXPECT_EQ(analysis.results[0].runs, 4u);
  EXPECT_EQ(analysis.results[0].points.size(), 4u);
  EXPECT_EQ(analysis.results[0].missed, std::vector<uint32_t>{0});
}

TEST(Analysis, NothingToSayIsNoFailure) {
  for (const Race& race :
       {race_of({}), race_of({racer("alone", 0.02, 0.01)}), race_of({racer("once", 0.02, 0.01, 1)}),
        race_of({racer("x", 0.02, 0, 1), racer("y", 0.02, 0, 1)}), race_of({racer("none", 1, 0, 0)})}) {
    const Analysis analysis = analyse(race);
    EXPECT_NE(race_html(race, analysis).find("</html>"), std::string::npos);
    EXPECT_FALSE(race_json(race, analysis).dump().empty());
    EXPECT_NE(errors_csv(race).find("technique,seed"), std::string::npos);
  }
}

TEST(Html, HoldsNamesThatMeanSomethingElseThere) {
  EXPECT_EQ(html_text("<a href=\"x\">&\x01\xff é"), "&lt;a href=&quot;x&quot;&gt;&amp;?? é");
  EXPECT_EQ(html_path("images/a b\"c.png"), "images/a%20b%22c.png");
  Race race = race_of({racer("a", 0.02, 0.01)});
  race.title = "{{body}}<script>";
  const std::string html = race_html(race, analyse(race));
  EXPECT_EQ(html.find("<script>alert"), std::string::npos);
  EXPECT_NE(html.find("<h1>{{body}}&lt;script&gt;</h1>"), std::string::npos);
}

TEST(Numbers, AreShort) {
  EXPECT_EQ(number_text(0.31234), "0.312");
  EXPECT_EQ(number_text(1234.5), "1234");
  EXPECT_EQ(number_text(0.00001234), "1.23e-05");
  EXPECT_EQ(number_text(-2.5), "−2.5");
  EXPECT_EQ(number_text(INFINITY), "∞");
  EXPECT_EQ(number_text(NAN), "–");
  EXPECT_EQ(estimate_text({0.31, 0.28, 0.35}), "0.31 [0.28, 0.35]");
}

TEST(ErrorMap, IsSignedAndRelative) {
  ImageRgb reference(2, 2, Vec3(1)), image(2, 2, Vec3(1));
  image.pixels[1] = Vec3(1.5f);
  image.pixels[2] = Vec3(0.5f);
  const std::vector<float> map = signed_error(image, reference);
  EXPECT_EQ(map[0], 0);
  EXPECT_NEAR(map[1], 0.5, 1e-3);
  EXPECT_NEAR(map[2], -0.5, 1e-3);
  EXPECT_EQ(error_scale({map}), 0.5);
  EXPECT_EQ(error_scale({{0, 0}}), 1);
  EXPECT_EQ(error_scale({std::vector<float>(100, 0.03f)}), 0.05);
  const ImageRgba8 picture = error_picture(map, 2, 2, 0.5);
  EXPECT_GT(picture.bytes[4], picture.bytes[6]);  // too bright: red above blue
  EXPECT_LT(picture.bytes[8], picture.bytes[10]);
  EXPECT_EQ(picture.bytes[0], picture.bytes[2]);
}

}  // namespace
}  // namespace halflight
