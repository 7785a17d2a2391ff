#pragma once

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "commands/render_json.h"
#include "core/errors.h"
#include "core/stopwatch.h"
#include "scene/scene.h"

namespace halflight {

/// What the command line says after a benchmark's name.
struct BenchmarkOptions {
  std::vector<std::string> names;  ///< what is neither an option nor its value
  std::filesystem::path folder;    ///< -o: where curves are written; empty: nowhere
  bool quick = false;              ///< --quick: smaller, to see that all of it runs
};

/// Renders a pass of each scene (or view, `FILE.json#NAME`), then traces the same visibility rays in bare
/// loops; prints both.
void benchmark_rays(const BenchmarkOptions&);

/// Prints for each scene what `render --until-error` takes with adaptive sampling of what it takes without,
/// at equal measured error, and the geometric mean. Names: scenes; technique, size, seeds, error as
/// KEY=VALUE.
void benchmark_adaptive(const BenchmarkOptions&);

/// Prints what the window's render thread takes from a camera's move or a light's change to its picture, how
/// many pictures a second it has while the camera moves, and the first picture's FLIP against the converged
/// one.
void benchmark_interaction(const BenchmarkOptions&);

/// A scene, or with `FILE.json#NAME` a view and the scene that it names. `ev`, where given, is set to the
/// view's.
Scene open_named(const std::string& name, Messages&, float* ev = nullptr);

/// Prints what the steps before visibility cost on one core.
void benchmark_steps(const BenchmarkOptions&);

/// Opens generated .glb files; prints the time to the first picture against tinygltf's parse and Embree's
/// build.
void benchmark_load(const BenchmarkOptions&);

/// Those of `all` that are named, all where none is. Throws Error (exit code 2) at a name that is not there.
std::vector<std::string> chosen_names(std::string_view what, const std::vector<std::string>& names,
                                      const std::vector<std::string>& all);

/// Error and time against |S|, triangles, pixels and threads; writes the curves.
void benchmark_scale(const BenchmarkOptions&);

/// CPU seconds of the shipped program to the errors that other renderers were timed to.
void benchmark_outside(const BenchmarkOptions&);

/// Wall-clock seconds, and those of all threads of this process: what other programs do stays out of the
/// latter.
struct Seconds {
  double wall = 0, cpu = 0;
  Seconds& operator+=(const Seconds& o) {
    wall += o.wall, cpu += o.cpu;
    return *this;
  }
  Seconds operator+(const Seconds& o) const { return {wall + o.wall, cpu + o.cpu}; }
};

/// The value that `share` of them do not exceed.
inline double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(share * static_cast<double>(values.size() - 1) + 0.5)];
}

/// Measures laps in both.
class BothClocks {
 public:
  Seconds lap() {
    const double now = process_cpu_seconds();
    return {watch_.lap(), now - std::exchange(cpu_start_, now)};
  }

 private:
  Stopwatch watch_;
  double cpu_start_ = process_cpu_seconds();
};

/// Least seconds of one call of `action` over some rounds of `repeats` calls.
template <class Action>
double best_seconds(int rounds, int repeats, const Action& action) {
  double best = 1e30;
  for (int round = 0; round < rounds; ++round) {
    const Stopwatch watch;
    for (int i = 0; i < repeats; ++i) action();
    best = std::min(best, watch.seconds() / repeats);
  }
  return best;
}

}  // namespace halflight
