// halflight_benchmark: how near the CPU stage comes to a bare loop of Embree, and what its steps cost.
#include <fmt/format.h>

#include <iostream>

#include "benchmarks/benchmarks.h"
#include "core/errors.h"

using namespace halflight;

namespace {

int usage() {
  std::cerr
      << "usage: halflight_benchmark rays SCENE...   rays a second in the renderer and in a bare loop\n"
         "                                        (SCENE may be a view: FILE.json#NAME)\n"
         "       halflight_benchmark adaptive [SCENE...] [technique=ID] [target=KIND] [size=WxH] [seeds=N] "
         "[error=X]\n"
         "                                           --until-error with adaptive sampling against without\n"
         "       halflight_benchmark interaction [SCENE...]\n"
         "                                           from a change to its picture, in the window's render "
         "thread\n"
         "       halflight_benchmark steps           cost of tree, cut, importance, draws and counting\n";
  return static_cast<int>(ExitCode::usage);
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  if (arguments.empty()) return usage();
  try {
    if (arguments[0] == "rays" && arguments.size() > 1) {
      for (size_t i = 1; i < arguments.size(); ++i) benchmark_rays(arguments[i]);
      return 0;
    }
    if (arguments[0] == "adaptive") {
      benchmark_adaptive({arguments.begin() + 1, arguments.end()});
      return 0;
    }
    if (arguments[0] == "interaction") {
      benchmark_interaction({arguments.begin() + 1, arguments.end()});
      return 0;
    }
    if (arguments[0] == "steps") {
      benchmark_steps();
      return 0;
    }
  } catch (const Error& error) {
    std::cerr << "halflight_benchmark: " << error.what() << "\n";
    return static_cast<int>(error.code());
  }
  return usage();
}
