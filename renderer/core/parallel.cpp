#include "core/parallel.h"

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <optional>

namespace halflight {

namespace {
std::unique_ptr<tbb::global_control> thread_limit;
}

void set_thread_count(int threads) {
  thread_limit.reset();
  if (threads > 0)
    thread_limit =
        std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, threads);
}

int thread_count() {
  return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

void side_by_side(size_t count, const std::function<void(size_t)>& body) {
  std::atomic<size_t> next = 0;
  const size_t workers = std::min(count, static_cast<size_t>(std::max(1, thread_count())));
  parallel_for(0, workers, 1, [&](size_t, size_t) {
    // An arena for one thread, this one: loops inside find nobody to share with, and it takes no work from
    // outside.
    tbb::task_arena alone(1);
    alone.execute([&] {
      for (size_t i = next++; i < count; i = next++) body(i);
    });
  });
}

}  // namespace halflight
