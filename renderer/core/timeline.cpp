#include "core/timeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <iterator>
#include <mutex>
#include <vector>

#include "core/errors.h"

namespace halflight {

namespace {

struct Event {
  const char* name;
  uint64_t begin, end;
};

using Events = std::vector<Event>;

/// Which timeline's events this thread adds to, and where.
struct ThreadEvents {
  uint64_t timeline = 0;
  Events* events = nullptr;
};

uint64_t next_number() {
  static std::atomic<uint64_t> count{0};
  return ++count;
}

}  // namespace

struct Timeline::Threads {
  uint64_t number = next_number();
  std::mutex mutex;
  std::deque<Events> events;  ///< one a thread, in the order of their first events
};

std::atomic<Timeline*> Timeline::current_{nullptr};

Timeline::Timeline() : threads_(std::make_unique<Threads>()), start_(now()) {
  Timeline* none = nullptr;
  HALFLIGHT_CHECK(current_.compare_exchange_strong(none, this));
}

Timeline::~Timeline() { current_.store(nullptr); }

uint64_t Timeline::now() {
  return static_cast<uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(
                                   std::chrono::steady_clock::now().time_since_epoch())
                                   .count());
}

void Timeline::add(const char* name, uint64_t begin, uint64_t end) {
  thread_local ThreadEvents own;
  if (own.timeline != threads_->number) {
    const std::lock_guard lock(threads_->mutex);
    own = {threads_->number, &threads_->events.emplace_back()};
  }
  own.events->push_back({name, begin, end});
}

void Timeline::add_tile(double seconds) {
  const uint64_t end = now();
  add("tile", std::max(start_, end - static_cast<uint64_t>(1e9 * std::max(seconds, 0.0))), end);
}

std::string Timeline::json() const {
  fmt::memory_buffer text;
  const auto out = std::back_inserter(text);
  fmt::format_to(out, "{{\"displayTimeUnit\":\"ms\",\"traceEvents\":[");
  const auto microseconds = [&](uint64_t nanoseconds) { return static_cast<double>(nanoseconds) * 1e-3; };
  const char* separator = "\n";
  for (size_t thread = 0; thread < threads_->events.size(); ++thread) {
    for (const Event& event : threads_->events[thread]) {
      fmt::format_to(out,
                     "{}{{\"ph\":\"X\",\"pid\":1,\"tid\":{},\"name\":\"{}\",\"ts\":{:.3f},\"dur\":{:.3f}}}",
                     separator, thread + 1, event.name, microseconds(event.begin - start_),
                     microseconds(event.end - event.begin));
      separator = ",\n";
    }
  }
  fmt::format_to(out, "\n]}}\n");
  return fmt::to_string(text);
}

}  // namespace halflight
