// `halflight compare` through the shipped program: what it writes, that it repeats itself, what mistakes get.
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <thread>

#include "scene/image_files.h"
#include "support/program.h"

namespace halflight {
namespace {

using nlohmann::json;
using Row = std::vector<std::string>;

enum Column { technique, seed, budget, wall, cpu, spp, rays, relmse, trimmed, rmse, smape, target };

std::vector<Row> rows_of(const fs::path& csv) {
  std::vector<Row> rows;
  std::istringstream lines(text_of(csv));
  for (std::string line; std::getline(lines, line);) {
    rows.emplace_back();
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
  }
  return rows;
}

std::vector<Row> without_times(std::vector<Row> rows) {
  for (Row& row : rows) row.at(wall) = row.at(cpu) = "";
  return rows;
}

class Compare : public Program {
 protected:
  /// A race of small pictures, with more arguments.
  Arguments race(const std::string& output, const Arguments& more = {}) const {
    Arguments all{"compare", "cornell", "--size", "32x24", "--virtual-lights", "256", "--backend", "none",
                  "--seeds", "3",       "-o",     output};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  Arguments of_samples(const std::string& output, const Arguments& more = {}) const {
    Arguments all = race(
        output, {"--techniques", "illumination,bidirectional", "--equal", "samples", "--budgets", "1,2,8"});
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
};

TEST_F(Compare, EqualSamplesRepeatThemselves) {
  ASSERT_EQ(run(of_samples("a")).code, 0);
  ASSERT_EQ(run(of_samples("b", {"--threads", "3"})).code, 0);
  ASSERT_EQ(run(of_samples("c", {"--seed", "100"})).code, 0);
  const std::vector<Row> a = rows_of(folder / "a/errors.csv"), b = rows_of(folder / "b/errors.csv"),
                         c = rows_of(folder / "c/errors.csv");
  EXPECT_EQ(a.size(), 1u + 2 * 3 * 3);
  EXPECT_EQ(without_times(a), without_times(b));
  EXPECT_NE(without_times(a), without_times(c));
  // The second race found its reference where the first had put it.
  EXPECT_EQ(
      json::parse(text_of(folder / "a/report.json"))["reference"]["how"].get<std::string>().find("cache"),
      std::string::npos);
  EXPECT_NE(
      json::parse(text_of(folder / "b/report.json"))["reference"]["how"].get<std::string>().find("cache"),
      std::string::npos);
}

TEST_F(Compare, TheCacheSeesWhatTheReferenceHangsOn) {
  const auto cached = [&] {
    size_t files = 0;
    for ([[maybe_unused]] const auto& file : fs::directory_iterator(folder / "cache/halflight/references"))
      ++files;
    return files;
  };
  const Arguments quick{"--techniques", "illumination", "--equal", "samples", "--budgets", "1"};
  const auto with = [&](const Arguments& more) {
    Arguments all = race("a", quick);
    all.insert(all.end(), more.begin(), more.end());
    EXPECT_EQ(run(all).code, 0);
    return cached();
  };
  EXPECT_EQ(with({}), 1u);
  EXPECT_EQ(with({"--seed", "9", "--ev", "1", "--cut-error", "0.5", "--seeds", "1"}), 1u);
  EXPECT_EQ(with({"--size", "24x32"}), 2u);
  EXPECT_EQ(with({"--light", "direct"}), 3u);
  EXPECT_EQ(with({"--set", "lights.seed=3"}), 4u);
}

TEST_F(Compare, ErrorsAreThoseOfThePictures) {
  ASSERT_EQ(run(of_samples("a")).code, 0);
  const std::vector<Row> rows = rows_of(folder / "a/errors.csv");
  EXPECT_EQ(rows.front(), (Row{"technique", "seed", "budget_seconds", "wall_seconds", "cpu_seconds", "spp",
                               "rays", "relmse", "relmse_trimmed", "rmse", "smape", "target"}));
  size_t checked = 0;
  for (const Row& row : rows) {
    if (row[seed] != "0" || row[budget] != "8") continue;
    ASSERT_EQ(
        run({"error", "a/images/" + row[technique] + ".exr", "a/images/reference.exr", "--json", "e.json"})
            .code,
        0);
    const json error = json::parse(text_of(at("e.json")));
    for (const auto& [column, name] :
         {std::pair(relmse, "relmse"), {trimmed, "relmse-trimmed"}, {rmse, "rmse"}, {smape, "smape"}})
      EXPECT_NEAR(std::stod(row[column]), error[name].get<double>(), 1e-6 * error[name].get<double>())
          << name;
    EXPECT_EQ(row[spp], "8");
    // The same picture as from a session that has rendered nothing else.
    ASSERT_EQ(run({"render", "cornell", "--size", "32x24", "--virtual-lights", "256", "--backend", "none",
                   "--samples", "8", "--technique", row[technique], "-o", "alone.exr"})
                  .code,
              0);
    EXPECT_EQ(
        run({"error", "a/images/" + row[technique] + ".exr", "alone.exr", "--fail-above", "rmse=0"}).code, 0);
    EXPECT_EQ(row[target], "discrete");
    ++checked;
  }
  EXPECT_EQ(checked, 2u);
}

/// Loads that would leave the disk: an address with a host in an attribute or a style.
size_t network_loads(const std::string& html) {
  const std::regex load(
      R"((src|href|data|action|poster)\s*=\s*["']?\s*(https?:)?//|url\(\s*["']?(https?:)?//|@import|fetch\()");
  return static_cast<size_t>(
      std::distance(std::sregex_iterator(html.begin(), html.end(), load), std::sregex_iterator()));
}

TEST_F(Compare, TheReportStandsAlone) {
  ASSERT_EQ(run(of_samples("made/here", {"--seeds", "5"})).code, 0);
  const std::string html = text_of(folder / "made/here/report.html");
  EXPECT_EQ(network_loads(html), 0u);
  EXPECT_EQ(network_loads("<img src=\"https://x/y.png\">"), 1u);
  for (const char* words :
       {"Standings", "Verdicts", "illumination", "bidirectional", "Reference: brute force"})
    EXPECT_NE(html.find(words), std::string::npos) << words;
  if (std::system("gnuplot --version > /dev/null 2>&1") == 0) {
    EXPECT_NE(html.find("<svg"), std::string::npos);
    EXPECT_NE(html.find("currentColor"), std::string::npos);
  }
  // Each picture that is named is there, of the right size.
  const std::regex picture("data-(picture|error)=\"([^\"]+)\"");
  std::set<std::string> pictures;
  for (std::sregex_iterator at(html.begin(), html.end(), picture), end; at != end; ++at)
    pictures.insert((*at)[2]);
  EXPECT_EQ(pictures.size(), 7u);  // the integral, and the map of how far the sum is from it, too
  for (const std::string& name : pictures)
    EXPECT_EQ(read_image(folder / "made/here" / name, LoadLimits{}).width, 32) << name;

  const json report = json::parse(text_of(folder / "made/here/report.json"));
  EXPECT_EQ(report["equal"], "samples");
  EXPECT_EQ(report["target"], "discrete");
  EXPECT_EQ(report["interrupted"], false);
  EXPECT_EQ(report["reference"]["exact"], true);
  ASSERT_EQ(report["techniques"].size(), 2u);
  for (const json& result : report["techniques"]) {
    EXPECT_EQ(result["points"].size(), 3u);
    EXPECT_LT(result["slope"]["value"], 0);
    EXPECT_LE(result["slope"]["low"], result["slope"]["value"]);
    EXPECT_GE(result["slope"]["high"], result["slope"]["value"]);
    EXPECT_TRUE(result.contains("samples_to_1e-2") && result.contains("samples_to_1e-3"));
  }
  EXPECT_FALSE(report["verdicts"].empty());
  EXPECT_GT(report["harness"]["preparation_seconds"], 0);
  for (const char* key : {"Processor", "Cores", "Memory", "OpenGL", "Program"})
    EXPECT_TRUE(report["machine"].contains(key)) << key;
}

TEST_F(Compare, WithoutGnuplotTheReportSaysSo) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nonexistent", 1);
  const Outcome outcome = run(of_samples("a"));
  setenv("PATH", path.c_str(), 1);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(text_of(folder / "a/report.html").find("gnuplot is not installed"), std::string::npos);
  EXPECT_EQ(text_of(folder / "a/report.html").find("<svg"), std::string::npos);
}

TEST_F(Compare, TimeAndRaysAreShared) {
  for (const char* equal : {"time", "rays"}) {
    ASSERT_EQ(run(race("a", {"--techniques", "bidirectional,illumination", "--equal", equal, "--budgets",
                             equal == std::string("time") ? "0.02,0.05,0.1" : "20,40,80"}))
                  .code,
              0);
    const std::vector<Row> rows = rows_of(folder / "a/errors.csv");
    ASSERT_GT(rows.size(), 6u);
    for (size_t i = 1; i < rows.size(); ++i) {
      EXPECT_GT(std::stod(rows[i][spp]), 0);
      EXPECT_GT(std::stod(rows[i][relmse]), 0);
      if (rows[i - 1][technique] == rows[i][technique] && rows[i - 1][seed] == rows[i][seed]) {
        EXPECT_GT(std::stod(rows[i][wall]), std::stod(rows[i - 1][wall]));
      }
      if (equal == std::string("rays")) {
        EXPECT_NEAR(std::stod(rows[i][rays]) / (32 * 24) / std::stod(rows[i][budget]), 1, 0.5);
      }
    }
  }
}

TEST_F(Compare, TheContinuousReferenceKnowsItsOwnError) {
  ASSERT_EQ(run(race("a", {"--techniques", "bidirectional,illumination", "--target", "continuous", "--equal",
                           "samples", "--budgets", "8,16"}))
                .code,
            0);
  const json report = json::parse(text_of(folder / "a/report.json"));
  EXPECT_EQ(report["reference"]["exact"], false);
  EXPECT_TRUE(report["discretisation"].is_null());
  EXPECT_GT(report["reference"]["own_relmse"], 0);
  EXPECT_LT(report["reference"]["own_relmse"], report["techniques"][0]["points"][0]["relmse"]["value"]);
  // It is subtracted: what a picture differs by from the reference's own picture is more by as much.
  const std::vector<Row> rows = rows_of(folder / "a/errors.csv");
  const Row& last = rows.at(2);
  EXPECT_EQ(last[target], "continuous");
  ASSERT_EQ(last[seed] + last[budget], "016");
  ASSERT_EQ(
      run({"error", "a/images/" + last[technique] + ".exr", "a/images/reference.exr", "--json", "e.json"})
          .code,
      0);
  const double raw = json::parse(text_of(at("e.json")))["relmse"], own = report["reference"]["own_relmse"];
  EXPECT_NEAR(std::stod(last[relmse]), raw - own, 1e-6 * raw);
}

TEST_F(Compare, TheSumsDistanceFromTheIntegralStandsApart) {
  const auto report_of = [&](const std::string& name, const Arguments& more) {
    Arguments all = race(name, {"--techniques", "illumination", "--equal", "samples", "--budgets", "64"});
    all.insert(all.end(), more.begin(), more.end());
    EXPECT_EQ(run(all).code, 0);
    return json::parse(text_of(folder / name / "report.json"));
  };
  // The fewer members S has, the farther is its sum; and not how S is sampled.
  const json few = report_of("few", {"--virtual-lights", "16"}),
             many = report_of("many", {"--virtual-lights", "4096"});
  const double far = few["discretisation"]["relmse"], near = many["discretisation"]["relmse"];
  EXPECT_TRUE(few["discretisation"]["told_from_noise"]);
  EXPECT_GT(far, 5 * std::max(near, 0.0));
  EXPECT_GT(far, 10 * few["discretisation"]["own_relmse"].get<double>());
  // Sampling error is independent of it: in a picture they add, up to how the two happen to lie.
  const double sampling = few["techniques"][0]["points"][0]["relmse"]["value"],
               together = few["techniques"][0]["relmse_of_integral"];
  EXPECT_NEAR(together, sampling + far, 0.3 * (sampling + far));
  // It is what the pictures say.
  ASSERT_EQ(run({"error", "few/images/reference.exr", "few/images/integral.exr", "--json", "e.json"}).code,
            0);
  const double raw = json::parse(text_of(at("e.json")))["relmse"], own = few["discretisation"]["own_relmse"];
  EXPECT_NEAR(far, raw - own, 1e-6 * raw);
  EXPECT_NE(text_of(folder / "few/report.html").find("Two errors"), std::string::npos);

  const json without = report_of("without", {"--no-discretisation"});
  EXPECT_TRUE(without["discretisation"].is_null());
  EXPECT_FALSE(without["techniques"][0].contains("relmse_of_integral"));
  EXPECT_EQ(text_of(folder / "without/report.html").find("Two errors"), std::string::npos);
}

TEST_F(Compare, AllRunsWhatCanAndSaysWhyTheRestDoesNot) {
  ASSERT_EQ(run(race("a", {"--equal", "samples", "--budgets", "1,2", "--seeds", "2"})).code, 0);
  const json report = json::parse(text_of(folder / "a/report.json"));
  const json all = json::parse(run({"techniques", "--json", "-"}).out)["techniques"];
  EXPECT_EQ(report["techniques"].size() + report["left_out"].size(), all.size());
  bool reference_is_out = false;
  for (const json& out : report["left_out"]) {
    EXPECT_FALSE(out["why"].get<std::string>().empty());
    reference_is_out |= out["id"] == "reference";
  }
  EXPECT_TRUE(reference_is_out);
  for (const json& result : report["techniques"]) {
    const bool explained = result.contains("why_preview") && result["why_preview"] != "";
    EXPECT_EQ(result["preview"] == true, explained);
  }
}

TEST_F(Compare, Mistakes) {
  std::ofstream(at("file")) << "a file";
  ASSERT_EQ(
      run({"render", "cornell", "--size", "16x16", "--samples", "1", "--backend", "none", "-o", "small.exr"})
          .code,
      0);
  expect_fault(run({"compare"}), 2, "needs -o DIR");
  expect_fault(run(race("file")), 2, "is a file");
  expect_fault(run(race("file/below")), 1, "cannot write");
  expect_fault(run(race("a", {"--techniques", "illumination,bidirektional"})), 2,
               "did you mean 'bidirectional'?");
  expect_fault(run(race("a", {"--techniques", "illumination,,mis"})), 2, "--techniques");
  expect_fault(run(race("a", {"--techniques", "reference"})), 2, "does not race");
  expect_fault(run(race("a", {"--techniques", "null"})), 2, "unknown");
  expect_fault(run(race("a", {"--budgets", "1,2,2"})), 2, "must increase");
  expect_fault(run(race("a", {"--budgets", "1,x"})), 2, "--budgets");
  expect_fault(run(race("a", {"--equal", "samples", "--budgets", "1.5"})), 2, "whole number");
  expect_fault(run(race("a", {"--equal", "tiem"})), 2, "did you mean 'time'?");
  expect_fault(run(race("a", {"--seeds", "0"})), 2, "--seeds");
  expect_fault(run(race("a", {"--reference", "small.exr"})), 3, "is 16x16");
  expect_fault(run(race("a", {"--reference", "missing.exr"})), 3, "missing.exr");
  EXPECT_FALSE(fs::exists(folder / "a"));
}

TEST_F(Compare, AnInterruptedRaceKeepsWhatIsComplete) {
  Outcome outcome;
  for (int seconds = 2; seconds <= 64; seconds *= 4) {
    const pid_t child = start(race(
        "a", {"--techniques", "illumination,bidirectional", "--budgets", "0.05,0.1", "--seeds", "9999"}));
    std::this_thread::sleep_for(std::chrono::seconds(seconds));
    kill(child, SIGINT);
    outcome = finish(child);
    if (fs::exists(folder / "a/report.html")) break;
  }
  EXPECT_EQ(outcome.code, 130);
  EXPECT_NE(outcome.err.find("interrupted"), std::string::npos) << outcome.err;
  const json report = json::parse(text_of(folder / "a/report.json"));
  EXPECT_EQ(report["interrupted"], true);
  EXPECT_GE(report["techniques"][0]["runs"], 1);
  EXPECT_NE(text_of(folder / "a/report.html").find("was interrupted"), std::string::npos);
}

}  // namespace
}  // namespace halflight
