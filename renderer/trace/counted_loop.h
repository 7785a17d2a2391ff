// Parallel loops that count rays; private to this folder.
#pragma once

#include <mutex>

#include "core/parallel.h"
#include "trace/ray_scene.h"

namespace halflight {

/// Calls `body(begin, end, counters)` over pieces of [0, count) and returns the counters' sum.
template <class Body>
RayCounters counted_parallel_for(size_t count, size_t grain, Body&& body) {
  RayCounters total;
  std::mutex mutex;
  parallel_for(0, count, grain, [&](size_t begin, size_t end) {
    RayCounters local;
    body(begin, end, local);
    std::lock_guard lock(mutex);
    total += local;  // whole numbers: the order does not matter
  });
  return total;
}

}  // namespace halflight
