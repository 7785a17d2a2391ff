#pragma once

#include <algorithm>
#include <string>

#include "core/stopwatch.h"

namespace halflight {

/// Renders a pass of a scene (or of a view, `FILE.json#NAME`), then traces the same visibility rays in bare loops;
/// prints both.
void benchmark_rays(const std::string& scene);

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
