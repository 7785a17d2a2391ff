// Ctrl-C and SIGTERM: during a picture the first one stops it and keeps what there is; the second one ends
// the program.
#pragma once

#include <atomic>
#include <csignal>
#include <stop_token>
#include <thread>

namespace halflight {

/// Catches the signals while it lives. Make it before any other thread, which then leaves the signals to it.
class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  /// From now on a first signal asks to stop; before, it ends the program at once (there is nothing to keep).
  void keep_what_there_is() { keep_ = true; }
  std::stop_token token() const { return stop_.get_token(); }
  bool requested() const { return stop_.stop_requested(); }

 private:
  void watch(std::stop_token finished);

  std::atomic<bool> keep_ = false;
  std::stop_source stop_;
  sigset_t caught_{}, before_{};
  std::jthread watcher_;
};

}  // namespace halflight
