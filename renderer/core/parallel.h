// Parallel loops over all cores. Results never depend on how the range was cut up: callers write to their own
// slots only, and reductions run in a fixed order.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cstddef>

namespace halflight {

/// Number of threads used by parallel loops; 0 means all the machine has.
void set_thread_count(int threads);
int thread_count();

/// Calls `body(begin, end)` over pieces of [begin, end) of about `grain` elements.
template <class Body>
void parallel_for(size_t begin, size_t end, size_t grain, Body&& body) {
  tbb::parallel_for(tbb::blocked_range<size_t>(begin, end, grain),
                    [&](const tbb::blocked_range<size_t>& range) { body(range.begin(), range.end()); });
}

}  // namespace halflight
