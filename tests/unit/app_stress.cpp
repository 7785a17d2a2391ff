// `halflight stress` as a library: what is listed, who is tried, and that a technique which is wrong falls
// short.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <set>

#include "command_line.h"
#include "commands/commands.h"
#include "core/random.h"
#include "stress/stress_report.h"
#include "stress/stress_stage.h"

namespace halflight {
namespace {

const StressCase& case_of(std::string_view id) {
  for (const StressCase& c : stress_cases())
    if (c.id == id) return c;
  throw std::runtime_error(fmt::format("no case {}", id));
}

StressEffort few_runs() {
  StressEffort effort;
  effort.quick = true;
  return effort;
}

StressResult only_result(const StressCase& c, const std::string& technique) {
  const auto results = run_stress_case(c, few_runs(), {technique}, {}, {});
  EXPECT_EQ(results.size(), 1u);
  return results.at(0);
}

/// One small case in the discrete target, where the truth is exact.
StressCase small_case() {
  StressCase c = case_of("9");
  c.targets = {Target::discrete};
  c.width = 16, c.height = 12;
  return c;
}

TEST(Stress, AllNumbersOfTheListAreThereAndTellWhatTheyExpect) {
  std::set<std::string> names, ids;
  std::set<int> numbers;
  for (const StressCase& c : stress_cases()) {
    EXPECT_TRUE(names.insert(c.name).second) << c.name;
    EXPECT_TRUE(ids.insert(c.id).second) << c.id;
    EXPECT_FALSE(c.inputs.empty() || c.bound.empty()) << c.name;
    EXPECT_TRUE(c.scene != nullptr) << c.name;
    EXPECT_FALSE(contestants(c, {}).empty()) << c.name;
    for (const Exemption& e : c.exemptions)
      EXPECT_TRUE(e.expected == Expected::truth || !e.why.empty()) << c.name << ": " << e.technique;
    if (c.id.front() != 'A') numbers.insert(std::stoi(c.id));
  }
  for (int number = 1; number <= 42; ++number) EXPECT_TRUE(numbers.contains(number)) << number;
  for (const std::string& name : names) EXPECT_NE(stress_list().find(name), std::string::npos);
}

TEST(Stress, EveryUnbiasedTechniqueOfTheRegistryIsTried) {
  for (const Target target : case_of("9").targets) {
    std::set<std::string_view> tried;
    for (const Contestant& c : contestants(case_of("9"), {}))
      if (c.target == target) tried.insert(c.technique->id);
    for (const TechniqueInfo& info : techniques()) {
      const bool supports =
          info.target == TargetSupport::both ||
          info.target == (target == Target::discrete ? TargetSupport::discrete : TargetSupport::continuous);
      const bool truth = info.id == "reference" || info.id == "path";
      EXPECT_EQ(tried.contains(info.id), supports && info.bias == Bias::unbiased && !truth) << info.id;
    }
  }
}

TEST(Stress, ACaseRunsAndMeasures) {
  const StressResult result = only_result(small_case(), "bidirectional");
  EXPECT_EQ(result.verdict, StressVerdict::as_expected) << result.reason;
  const Measured& m = result.measured;
  EXPECT_NEAR(m.mean / m.truth, 1, m.interval);
  EXPECT_GT(m.interval, 0);
  EXPECT_LT(m.interval, 0.1);
  EXPECT_GT(m.relmse, 0);
  EXPECT_GE(m.largest_weight, 1);
  EXPECT_GT(m.seconds, 0);
  EXPECT_GT(m.first_picture, 0);
  EXPECT_GT(m.light_count, 100u);
  EXPECT_EQ(m.nan_samples, 0u);
}

TEST(Stress, AWrongTruthFallsShortWithExitCode5) {
  StressReport report;
  report.results.push_back(only_result(small_case(), "illumination"));
  EXPECT_EQ(stress_exit_code(report), ExitCode::ok);

  StressCase wrong = small_case();
  wrong.constant_truth = Vec3(1e-3f);
  report.results.push_back(only_result(wrong, "illumination"));
  EXPECT_EQ(report.results.back().verdict, StressVerdict::falls_short);
  EXPECT_FALSE(report.results.back().reason.empty());
  EXPECT_EQ(static_cast<int>(stress_exit_code(report)), 5);

  // Tails excuse a mean below the truth, never one above it.
  wrong.exemptions = {{"illumination", Expected::tails, "to see"}};
  EXPECT_EQ(only_result(wrong, "illumination").verdict, StressVerdict::falls_short);
  wrong.constant_truth = Vec3(1e3f);
  EXPECT_EQ(only_result(wrong, "illumination").verdict, StressVerdict::untestable_tails);
}

TEST(Stress, AFailureThatWasExpectedAndDoesNotComeFallsShort) {
  StressCase c = small_case();
  c.exemptions = {{"illumination", Expected::bias, "to see", {}, 0.1, 0.8}};
  EXPECT_EQ(only_result(c, "illumination").verdict, StressVerdict::falls_short);
  c.exemptions = {{"illumination", Expected::bias, "to see", {}, 0.8, 1.2}};
  EXPECT_EQ(only_result(c, "illumination").verdict, StressVerdict::fails_as_expected);
  c.exemptions = {{"illumination", Expected::left_out, "to see"}};
  EXPECT_EQ(only_result(c, "illumination").verdict, StressVerdict::left_out);
}

TEST(Stress, SamplesThatAreNoNumbersFallShort) {
  StressCase c = small_case();
  c.scene = case_of("A10").scene;
  c.constant_truth = Vec3(1);
  const StressResult result = only_result(c, "illumination");
  EXPECT_EQ(result.verdict, StressVerdict::falls_short);
  EXPECT_GT(result.measured.nan_samples, 0u);
  EXPECT_NE(result.reason.find("not finite"), std::string::npos) << result.reason;
}

TEST(Stress, PrintedEquation9LosesASun) {
  for (const StressResult& result : run_stress_case(case_of("8"), few_runs(), {"bidirectional"}, {}, {}))
    if (result.technique.find("printed") != std::string::npos) {
      EXPECT_EQ(result.verdict, StressVerdict::fails_as_expected) << result.reason;
      return;
    }
  FAIL() << "it was not tried";
}

// ---- Means ----

double normal_number(RandomStream& random) {
  double sum = -6;
  for (int i = 0; i < 12; ++i) sum += random.next();
  return sum;
}

/// Share of experiments whose means are called different, `shift` intervals away from the truth.
double called_different(double shift) {
  constexpr int experiments = 300, runs = 16, marks = 15;
  RandomStream random(1, 2, 3);
  MarkStatistics truth;
  truth.add(std::vector<double>(marks, 100.0));
  int different = 0;
  // Half of an interval of the mean of 16: Student's t of 15 degrees at 1e-4 over 15 tests is 6.9.
  const double interval = 6.9 / std::sqrt(static_cast<double>(runs));
  for (int e = 0; e < experiments; ++e) {
    MarkStatistics found;
    for (int r = 0; r < runs; ++r) {
      std::vector<double> values;
      for (int i = 0; i < marks; ++i) values.push_back(100 + shift * interval + normal_number(random));
      found.add(values);
    }
    different += test_means(found, truth, 0).worst > 1;
  }
  return static_cast<double>(different) / experiments;
}

TEST(StressMeans, TheTruthPassesAndWhatIsTwoIntervalsAwayDoesNot) {
  EXPECT_LE(called_different(0), 0.005);
  EXPECT_GE(called_different(2), 0.99);
  EXPECT_GE(called_different(-2), 0.99);
}

// ---- Report and command ----

TEST(StressReports, JsonHasARowForEachAndThePageNeedsNoNetwork) {
  StressCase c = small_case();
  c.exemptions = {{"brdf", Expected::left_out, "to see"}};
  StressReport report;
  for (const char* id : {"illumination", "brdf"}) report.results.push_back(only_result(c, id));
  report.machine = {{"Processor", "one"}};
  const Json json = stress_json(report);
  ASSERT_EQ(json.at("cases").size(), 2u);
  for (const Json& row : json.at("cases"))
    for (const char* key : {"id", "name", "technique", "expected", "measured", "verdict"})
      EXPECT_TRUE(row.contains(key)) << key;
  EXPECT_EQ(json.at("cases")[0].at("verdict"), "as expected");
  EXPECT_EQ(json.at("cases")[0].at("measured").at("nan_samples"), 0);
  EXPECT_TRUE(json.at("cases")[1].at("measured").is_null());
  EXPECT_EQ(json.at("verdicts").at("left out"), 1);
  const std::string page = stress_page(report);
  EXPECT_NE(page.find("no-specular"), std::string::npos);
  EXPECT_EQ(page.find("http://"), std::string::npos);
  EXPECT_EQ(page.find("https://"), std::string::npos);
  EXPECT_NE(stress_table(report).find("illumination"), std::string::npos);
}

TEST(StressCommand, UnknownNamesAreUsageErrorsAndACaseLeavesItsFiles) {
  const auto code_of = [](const std::vector<std::string>& arguments) {
    try {
      return run_stress(parse_arguments(arguments));
    } catch (const Error& error) {
      return static_cast<int>(error.code());
    }
  };
  const std::filesystem::path folder =
      std::filesystem::temp_directory_path() / fmt::format("halflight-stress-{}", ::getpid());
  EXPECT_EQ(code_of({"stress", "no-such-case", "-o", folder.string()}), 2);
  EXPECT_EQ(code_of({"stress", "black-brdf"}), 2) << "no folder";
  EXPECT_EQ(code_of({"stress", "black-brdf", "--techniques", "none-such", "-o", folder.string()}), 2);
  EXPECT_FALSE(std::filesystem::exists(folder));
  EXPECT_EQ(code_of({"stress", "10", "--quick", "--quiet", "-o", folder.string()}), 0);
  const Json json = Json::parse(std::ifstream(folder / "stress.json"));
  EXPECT_GT(json.at("cases").size(), 10u);
  for (const Json& row : json.at("cases")) EXPECT_EQ(row.at("name"), "black-brdf");
  EXPECT_GT(std::filesystem::file_size(folder / "stress.html"), 1000u);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace halflight
