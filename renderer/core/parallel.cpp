#include "core/parallel.h"

#include <tbb/global_control.h>
#include <tbb/info.h>

#include <memory>
#include <optional>

namespace halflight {

namespace {
std::unique_ptr<tbb::global_control> thread_limit;
}

void set_thread_count(int threads) {
  thread_limit.reset();
  if (threads > 0)
    thread_limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism, threads);
}

int thread_count() {
  return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

}  // namespace halflight
