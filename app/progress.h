// One line on a terminal that says what long work is doing and for how long.
#pragma once

#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "core/stopwatch.h"

namespace halflight {

/// Redraws its line a few times a second from its own thread; does nothing where standard error is no
/// terminal. The line is gone when it is destroyed or hidden.
class Progress {
 public:
  explicit Progress(bool wanted);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Whether there is anyone to see it: what only it would say need not be found out.
  bool visible() const { return painter_.joinable(); }
  void show(std::string text);
  /// Removes the line, for a message or the end.
  void hide();

 private:
  void draw(std::stop_token);

  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::string text_;
  bool drawn_ = false;
  Stopwatch watch_;
  std::jthread painter_;
};

}  // namespace halflight
