// Parallel loops over all cores. Results never depend on how the range was cut up: callers write to their own
// slots only, and reductions run in a fixed order.
#pragma once

#include <cstddef>
#include <functional>

#if defined(__SANITIZE_THREAD__)
#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>
#else
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>
#endif

namespace halflight {

/// Number of threads used by parallel loops; 0 means all the machine has.
void set_thread_count(int threads);
int thread_count();

/// Calls `body(i)` for each i below `count`, begun in this order, each on one thread to its end with all
/// loops in it: for works of their own that are too small to keep all cores busy one by one.
void side_by_side(size_t count, const std::function<void(size_t)>& body);

#if defined(__SANITIZE_THREAD__)

// The task library is not built for the thread sanitizer, which then knows nothing of the order it keeps.
// Plain threads stand in for it, so that the sanitizer judges our own code with nothing suppressed.

/// Calls `body(begin, end)` over pieces of [begin, end) of `grain` elements.
template <class Body>
void parallel_for(size_t begin, size_t end, size_t grain, Body&& body) {
  const size_t step = std::max<size_t>(grain, 1), pieces = end > begin ? (end - begin + step - 1) / step : 0;
  std::atomic<size_t> next = 0;
  const auto work = [&] {
    for (size_t i = next++; i < pieces; i = next++)
      body(begin + i * step, std::min(end, begin + (i + 1) * step));
  };
  std::vector<std::jthread> others;
  for (size_t t = 1; t < std::min<size_t>(pieces, static_cast<size_t>(thread_count())); ++t)
    others.emplace_back(work);
  work();
}

/// Runs both, perhaps at the same time.
template <class First, class Second>
void parallel_invoke(First&& first, Second&& second) {
  const std::jthread other([&] { first(); });
  second();
}

#else

/// Calls `body(begin, end)` over pieces of [begin, end) of about `grain` elements.
template <class Body>
void parallel_for(size_t begin, size_t end, size_t grain, Body&& body) {
  tbb::parallel_for(tbb::blocked_range<size_t>(begin, end, grain),
                    [&](const tbb::blocked_range<size_t>& range) { body(range.begin(), range.end()); });
}

/// Runs both, perhaps at the same time.
template <class First, class Second>
void parallel_invoke(First&& first, Second&& second) {
  tbb::parallel_invoke(first, second);
}

#endif

}  // namespace halflight
