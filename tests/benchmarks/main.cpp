// halflight_benchmark: what the renderer costs, as ratios within one run. Run by hand (docs/performance.md).
#include <fmt/format.h>

#include <iostream>
#include <optional>

#include "benchmarks/benchmarks.h"
#include "core/errors.h"

using namespace halflight;

std::vector<std::string> halflight::chosen_names(std::string_view what, const std::vector<std::string>& names,
                                                 const std::vector<std::string>& all) {
  for (const std::string& name : names)
    if (std::find(all.begin(), all.end(), name) == all.end()) throw unknown_name(what, name, all);
  return names.empty() ? all : names;
}

namespace {

struct Benchmark {
  std::string_view name, arguments, what;
  bool needs_names, takes_names;
  void (*run)(const BenchmarkOptions&);
};

constexpr Benchmark benchmarks[] = {
    {"rays", "SCENE...",
     "rays a second in the renderer and in a bare loop (SCENE may be a view: FILE.json#NAME)", true, true,
     benchmark_rays},
    {"adaptive", "[SCENE...] [KEY=VALUE...]",
     "--until-error with adaptive sampling against without (technique, size, seeds, error)", false, true,
     benchmark_adaptive},
    {"interaction", "[SCENE...]", "from a change to its picture, in the window's render thread", false, true,
     benchmark_interaction},
    {"steps", "", "cost of tree, cut, importance, draws and counting", false, false, benchmark_steps},
    {"load", "[--quick]", "from a .glb to the first picture, against tinygltf's parse and Embree's build",
     false, false, benchmark_load},
    {"scale", "[CURVE...] [--quick] [-o DIR]", "error and time against lights, triangles, image, threads",
     false, true, benchmark_scale},
    {"outside", "[SCENE...] [--quick] [-o DIR]",
     "CPU seconds of the program to errors that others were timed to", false, true, benchmark_outside},
};

int usage() {
  std::cerr << "usage: halflight_benchmark NAME [arguments]\n";
  for (const Benchmark& benchmark : benchmarks)
    std::cerr << fmt::format("  {:<11} {:<29} {}\n", benchmark.name, benchmark.arguments, benchmark.what);
  return static_cast<int>(ExitCode::usage);
}

/// Nothing where the words make no sense.
std::optional<BenchmarkOptions> read_options(const std::vector<std::string>& words) {
  BenchmarkOptions options;
  for (size_t i = 0; i < words.size(); ++i) {
    if (words[i] == "--quick") {
      options.quick = true;
    } else if (words[i] == "-o") {
      if (++i == words.size()) return {};
      options.folder = words[i];
    } else if (words[i].starts_with("-")) {
      return {};
    } else {
      options.names.push_back(words[i]);
    }
  }
  return options;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.empty()) return usage();
  const auto options = read_options({arguments.begin() + 1, arguments.end()});
  if (!options) return usage();
  try {
    for (const Benchmark& benchmark : benchmarks) {
      if (benchmark.name != arguments[0]) continue;
      if (options->names.empty() ? benchmark.needs_names : !benchmark.takes_names) return usage();
      if (!options->folder.empty()) std::filesystem::create_directories(options->folder);
      benchmark.run(*options);
      return 0;
    }
  } catch (const Error& error) {
    std::cerr << "halflight_benchmark: " << error.what() << "\n";
    return static_cast<int>(error.code());
  }
  return usage();
}
