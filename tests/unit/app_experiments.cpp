// `halflight experiments` through the shipped program: the list, mistakes, and what small runs leave.
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "support/program.h"

namespace halflight {
namespace {

using nlohmann::json;

class Experiments : public Program {
 protected:
  std::vector<std::vector<std::string>> table(const std::string& file) const {
    std::vector<std::vector<std::string>> rows;
    std::istringstream lines(text_of(folder / file));
    for (std::string line; std::getline(lines, line);) {
      rows.emplace_back();
      std::istringstream cells(line);
      for (std::string cell; std::getline(cells, cell, ',');) rows.back().push_back(cell);
    }
    return rows;
  }
};

TEST_F(Experiments, AreListedWithTheirFigures) {
  const Outcome outcome = run({"experiments"});
  EXPECT_EQ(outcome.code, 0);
  for (const char* name : {"wa-fig3", "wa-fig4", "wa-fig5", "wa-fig8", "krivanek", "gems-fig20-5",
                           "gems-fig20-8", "gems-fig20-9", "pharr-fig2"})
    EXPECT_NE(outcome.out.find(name), std::string::npos) << name;
}

TEST_F(Experiments, Mistakes) {
  const Outcome unknown = run({"experiments", "wa-fig99", "-o", at("x")});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_NE(unknown.err.find("wa-fig3"), std::string::npos) << unknown.err;
  EXPECT_EQ(run({"experiments", "wa-fig3"}).code, 2) << "no folder";
  EXPECT_FALSE(fs::exists(at("x")));
}

TEST_F(Experiments, DirectionsAreUnitAndFollowTheTechnique) {
  ASSERT_EQ(run({"experiments", "wa-fig3", "-o", at("x"), "--quiet"}).code, 0);
  const auto rows = table("x/wa-fig3/fig3.csv");
  ASSERT_EQ(rows.size(), 1u + 3 * 512);
  std::map<std::string, double> upward;
  for (size_t i = 1; i < rows.size(); ++i) {
    const double x = std::stod(rows[i].at(1)), y = std::stod(rows[i].at(2)), z = std::stod(rows[i].at(3));
    EXPECT_NEAR(x * x + y * y + z * z, 1, 1e-4);
    EXPECT_GT(std::stod(rows[i].at(4)), 0);
    upward[rows[i].at(0)] += y > 0 ? 1.0 / 512 : 0;
  }
  // Light comes from below the plane too; those who know its BRDF hardly ever look there.
  EXPECT_GT(upward["brdf"], 0.9);
  EXPECT_GT(upward["bidirectional"], upward["illumination"]);
  const json report = json::parse(text_of(folder / "x/wa-fig3/report.json"));
  EXPECT_EQ(report.at("experiment"), "wa-fig3");
  EXPECT_TRUE(report.at("machine").contains("Processor"));
  const std::string page = text_of(folder / "x/wa-fig3/index.html");
  EXPECT_NE(page.find("bidirectional.png"), std::string::npos);
  EXPECT_EQ(page.find("http://"), std::string::npos);
  EXPECT_EQ(page.find("https://"), std::string::npos);
  for (const char* file : {"illumination.png", "brdf.png", "bidirectional.png"})
    EXPECT_GT(fs::file_size(folder / "x/wa-fig3" / file), 1000u);
}

TEST_F(Experiments, TheTableOfScenesHasCutsOfThePapersSize) {
  ASSERT_EQ(run({"experiments", "wa-fig4", "-o", at("x"), "--quick", "--quiet"}).code, 0);
  const json report = json::parse(text_of(folder / "x/wa-fig4/report.json"));
  const json& rows = report.at("tables").at("fig4");
  ASSERT_EQ(rows.size(), 5u);
  for (const json& row : rows) {
    const int cut = std::stoi(row.at("cut").get<std::string>());
    EXPECT_GE(cut, 250) << row.at("scene");
    EXPECT_LE(cut, 1100) << row.at("scene");
    EXPECT_GT(std::stod(row.at("seconds").get<std::string>()), 0);
  }
}

}  // namespace
}  // namespace halflight
