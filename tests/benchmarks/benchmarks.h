#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "core/errors.h"
#include "core/stopwatch.h"
#include "scene/scene.h"

namespace halflight {

/// Renders a pass of a scene (or of a view, `FILE.json#NAME`), then traces the same visibility rays in bare
/// loops; prints both.
void benchmark_rays(const std::string& scene);

/// Prints for each scene what `render --until-error 0.01` takes with adaptive sampling of what it takes
/// without, at equal measured error, and the geometric mean. `options`: scenes, technique, target, size,
/// seeds; see main.cpp.
void benchmark_adaptive(const std::vector<std::string>& options);

/// Prints what the window's render thread takes from a camera's move or a light's change to its picture, how
/// many pictures a second it has while the camera moves, and the first picture's FLIP against the converged
/// one.
void benchmark_interaction(const std::vector<std::string>& scenes);

/// A scene, or with `FILE.json#NAME` a view and the scene that it names. `ev`, where given, is set to the
/// view's.
Scene open_named(const std::string& name, Messages&, float* ev = nullptr);

/// Prints what the steps before visibility cost on one core.
void benchmark_steps();

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
