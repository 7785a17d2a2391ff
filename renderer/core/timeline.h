// A timeline of what runs when and on which thread, in the Chrome trace event format (opens in Perfetto or
// chrome://tracing). Off unless asked for; off, it costs a branch a scope and allocates nothing.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>

namespace halflight {

/// Records from construction to destruction; one at a time in a process. Scopes run on any thread; `json` and
/// the destructor only while none does.
class Timeline {
 public:
  Timeline();
  ~Timeline();
  Timeline(const Timeline&) = delete;
  Timeline& operator=(const Timeline&) = delete;

  static Timeline* current() { return current_.load(std::memory_order_acquire); }
  /// Nanoseconds on the clock of the events.
  static uint64_t now();

  /// `name` must outlive the timeline; stages nest on the thread that runs them.
  void add(const char* name, uint64_t begin, uint64_t end);

  /// A tile of pixels that took so many seconds until now.
  void add_tile(double seconds);

  /// The whole as a JSON object: {"traceEvents": [...]}, times in microseconds since construction.
  std::string json() const;

 private:
  static std::atomic<Timeline*> current_;
  struct Threads;
  std::unique_ptr<Threads> threads_;
  uint64_t start_ = 0;
};

/// An event of the timeline from here to the end of the block.
class TimelineScope {
 public:
  explicit TimelineScope(const char* name) : timeline_(Timeline::current()), name_(name) {
    if (timeline_) begin_ = Timeline::now();
  }
  ~TimelineScope() {
    if (timeline_) timeline_->add(name_, begin_, Timeline::now());
  }
  TimelineScope(const TimelineScope&) = delete;
  TimelineScope& operator=(const TimelineScope&) = delete;

 private:
  Timeline* timeline_;
  const char* name_;
  uint64_t begin_ = 0;
};

}  // namespace halflight
