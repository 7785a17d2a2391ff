// Parallel loops over all cores. Results never depend on how the range was cut up: callers write to their own
// slots only, and reductions run in a fixed order.
#pragma once

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <cstddef>

#if defined(__SANITIZE_THREAD__)
extern "C" void __tsan_acquire(void*);
extern "C" void __tsan_release(void*);
#endif

namespace halflight {

/// Number of threads used by parallel loops; 0 means all the machine has.
void set_thread_count(int threads);
int thread_count();

/// Tells the thread sanitizer what the task library, which is not built for it, orders: the caller before each task, and
/// each task before what follows the loop. Empty in every other build.
class TaskOrder {
 public:
#if defined(__SANITIZE_THREAD__)
  TaskOrder() { __tsan_release(&begin_); }
  ~TaskOrder() { __tsan_acquire(&end_); }
  void task_begins() { __tsan_acquire(&begin_); }
  void task_ends() { __tsan_release(&end_); }

 private:
  char begin_ = 0, end_ = 0;
#else
  void task_begins() {}
  void task_ends() {}
#endif
};

/// Calls `body(begin, end)` over pieces of [begin, end) of about `grain` elements.
template <class Body>
void parallel_for(size_t begin, size_t end, size_t grain, Body&& body) {
  TaskOrder order;
  tbb::parallel_for(tbb::blocked_range<size_t>(begin, end, grain), [&](const tbb::blocked_range<size_t>& range) {
    order.task_begins();
    body(range.begin(), range.end());
    order.task_ends();
  });
}

/// Runs both, perhaps at the same time.
template <class First, class Second>
void parallel_invoke(First&& first, Second&& second) {
  TaskOrder order;
  const auto ordered = [&order](auto& task) {
    return [&order, &task] {
      order.task_begins();
      task();
      order.task_ends();
    };
  };
  tbb::parallel_invoke(ordered(first), ordered(second));
}

}  // namespace halflight
