// The shipped program as a child process: its exit code, what it prints and the files it leaves.
#pragma once

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace halflight {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;

inline std::string text_of(const fs::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

struct Outcome {
  int code = -1;
  std::string out, err;
};

/// A folder of its own for each test, empty at the start and gone at the end.
class Program : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    folder = fs::temp_directory_path() / fmt::format("halflight-{}-{}", info->name(), getpid());
    std::string name = folder.string();
    std::replace(name.begin() + 1, name.end(), ' ', '-');
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  void TearDown() override {
    std::error_code ignored;
    fs::permissions(folder, fs::perms::owner_all, ignored);
    fs::remove_all(folder, ignored);
  }

  std::string at(const std::string& name) const { return (folder / name).string(); }

  /// Starts the program in `folder`; its outputs go to files there, and what it keeps to `cache`.
  pid_t start(const Arguments& arguments, rlim_t largest_file = RLIM_INFINITY,
              const std::string& standard_output = "") {
    std::vector<char*> words{const_cast<char*>(HALFLIGHT_PROGRAM)};
    for (const std::string& word : arguments) words.push_back(const_cast<char*>(word.c_str()));
    words.push_back(nullptr);
    const std::string out = standard_output.empty() ? at("stdout.txt") : standard_output,
                      err = at("stderr.txt");
    const pid_t child = fork();
    if (child != 0) return child;
    const rlimit limit{largest_file, largest_file};
    const int out_file = open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    const int err_file = open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
    const bool ready = chdir(folder.c_str()) == 0 && setrlimit(RLIMIT_FSIZE, &limit) == 0 &&
                       setenv("XDG_CACHE_HOME", at("cache").c_str(), 1) == 0 && unsetenv("DISPLAY") == 0 &&
                       unsetenv("WAYLAND_DISPLAY") == 0 && dup2(out_file, 1) >= 0 && dup2(err_file, 2) >= 0;
    if (ready) execv(HALFLIGHT_PROGRAM, words.data());
    _exit(127);
  }

  Outcome finish(pid_t child) {
    int status = 0;
    EXPECT_EQ(waitpid(child, &status, 0), child);
    EXPECT_TRUE(WIFEXITED(status)) << "ended by signal " << WTERMSIG(status);
    return {WEXITSTATUS(status), text_of(folder / "stdout.txt"), text_of(folder / "stderr.txt")};
  }

  Outcome run(const Arguments& arguments, rlim_t largest_file = RLIM_INFINITY,
              const std::string& standard_output = "") {
    return finish(start(arguments, largest_file, standard_output));
  }

  /// A small picture that takes no time, with more arguments.
  Arguments small(const std::string& output, const Arguments& more = {}) const {
    Arguments all{"render",           "cornell", "--size",    "32x24", "--samples", "2",
                  "--virtual-lights", "512",     "--backend", "none",  "-o",        output};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder))
      if (const std::string name = entry.path().filename(); name != "stdout.txt" && name != "stderr.txt")
        names.push_back(name);
    std::sort(names.begin(), names.end());
    return names;
  }

  fs::path folder;
};

/// What a mistake gets: the exit code, and one line on standard error with these words in it.
inline void expect_fault(const Outcome& outcome, int code, const std::string& words) {
  EXPECT_EQ(outcome.code, code) << outcome.err;
  EXPECT_EQ(outcome.out, "");
  EXPECT_EQ(outcome.err.rfind("halflight: ", 0), 0u) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_NE(outcome.err.find(words), std::string::npos) << "'" << outcome.err << "' lacks '" << words << "'";
}

}  // namespace halflight
