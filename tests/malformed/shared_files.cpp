// Every malformed file of the shared data, each with the outcome it was decided to have
// (shared_outcomes.txt).
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>

#include "core/stopwatch.h"
#include "support/gltf_fixture.h"

namespace halflight {

namespace {

namespace fs = std::filesystem;

const fs::path data = HALFLIGHT_SHARED_DATA;
const char* const folders[] = {"gltf-invalid", "env-invalid", "gltf-conformance/asset-generator/Negative"};

bool is_gltf(const fs::path& path) { return path.extension() == ".gltf" || path.extension() == ".glb"; }
bool is_environment(const fs::path& path) { return path.extension() == ".hdr" || path.extension() == ".exr"; }

struct Committed {
  int exit = 0;
  std::string told;  ///< part of the error, or of a warning; may be empty
};

/// Lines of `exit <tab> path <tab> text`, '#' begins a comment.
std::map<std::string, Committed> read_committed() {
  std::map<std::string, Committed> committed;
  std::ifstream file(fs::path(HALFLIGHT_MALFORMED_FOLDER) / "shared_outcomes.txt");
  for (std::string line; std::getline(file, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream fields(line);
    std::string exit, path, told;
    std::getline(fields, exit, '\t');
    std::getline(fields, path, '\t');
    std::getline(fields, told);
    committed[path] = {std::stoi(exit), told};
  }
  return committed;
}

std::vector<std::string> files_there() {
  std::vector<std::string> files;
  for (const char* folder : folders) {
    for (const auto& entry : fs::recursive_directory_iterator(data / folder)) {
      const fs::path& path = entry.path();
      if (is_gltf(path) || is_environment(path)) files.push_back(path.lexically_relative(data).string());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

LoadOutcome outcome_of(const fs::path& path) {
  if (is_gltf(path)) return load_outcome(path);
  LoadOutcome outcome;
  Messages messages;
  try {
    outcome.scene.environment = load_environment(path, {}, messages);
  } catch (const Error& error) {
    outcome.exit = error.code();
    outcome.message = error.what();
  }
  outcome.warnings = messages.warnings;
  return outcome;
}

/// The error, or else the warning that tells most.
std::string telling_message(const LoadOutcome& outcome) {
  if (!outcome.message.empty() || outcome.warnings.empty()) return outcome.message;
  const auto told = std::find_if(outcome.warnings.begin(), outcome.warnings.end(), [](const std::string& w) {
    return w.find("SCENE_EMPTY") == std::string::npos;
  });
  return told == outcome.warnings.end() ? outcome.warnings.front() : *told;
}

/// Part of a message that does not hang on where the data lie or on a library's words.
std::string first_words(const LoadOutcome& outcome, const std::string& path) {
  const std::string message = telling_message(outcome);
  const size_t name = message.find(fs::path(path).filename().string() + ": ");
  if (name == std::string::npos) return "";
  const std::string rest = message.substr(name + fs::path(path).filename().string().size() + 2);
  // Up to the code, which is in capitals and ends in a colon.
  const std::string capitals = "ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_";
  for (size_t begin = 0; begin < rest.size(); begin = rest.find(": ", begin) + 2) {
    const size_t end = rest.find_first_not_of(capitals, begin);
    if (end != std::string::npos && end - begin > 4 && rest[end] == ':') return rest.substr(0, end);
    if (rest.find(": ", begin) == std::string::npos) break;
  }
  return "";
}

TEST(SharedMalformedFiles, HaveTheirCommittedOutcomes) {
  if (!fs::exists(data)) GTEST_SKIP() << "no shared data beside the checkout";
  const auto committed = read_committed();
  const auto files = files_there();
  EXPECT_EQ(files.size(), committed.size());
  // A way to write the table anew, to be read line by line before it is committed.
  const char* const rewrite = std::getenv("HALFLIGHT_WRITE_OUTCOMES");
  std::ofstream table(rewrite ? rewrite : "/dev/null");
  for (const std::string& file : files) {
    const Stopwatch watch;
    const LoadOutcome outcome = outcome_of(data / file);
    const int exit = static_cast<int>(outcome.exit);
    table << exit << '\t' << file << '\t' << first_words(outcome, file) << '\n';
    EXPECT_LT(watch.seconds(), 10) << file;
    EXPECT_TRUE(exit == 0 || exit == 3) << file << ": " << outcome.message;
    const auto expected = committed.find(file);
    if (expected == committed.end()) {
      ADD_FAILURE() << file << " has no committed outcome; it is " << exit << " " << outcome.message;
      continue;
    }
    EXPECT_EQ(exit, expected->second.exit) << file << ": " << outcome.all();
    EXPECT_TRUE(outcome.tells(expected->second.told))
        << file << " does not tell " << expected->second.told << ":\n"
        << outcome.all();
  }
}

/// What the Khronos validator finds no error in must load; only remote URIs are refused all the same.
TEST(SharedMalformedFiles, LoadWhereTheValidatorFindsNoError) {
  if (!fs::exists(data)) GTEST_SKIP() << "no shared data beside the checkout";
  size_t loaded = 0;
  for (const std::string& file : files_there()) {
    std::ifstream report_file(data / (file + ".report.json"));
    if (!report_file) continue;
    const auto report = nlohmann::json::parse(report_file);
    if (report["issues"]["numErrors"] != 0) continue;
    const LoadOutcome outcome = load_outcome(data / file);
    if (outcome.tells("http:")) {
      EXPECT_EQ(static_cast<int>(outcome.exit), 3) << file;
      continue;
    }
    EXPECT_EQ(static_cast<int>(outcome.exit), 0) << outcome.message;
    ++loaded;
  }
  EXPECT_GT(loaded, 70u);
}

}  // namespace

}  // namespace halflight
