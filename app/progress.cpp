#include "progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>

#include "console.h"

namespace halflight {

namespace {

size_t terminal_columns() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

constexpr std::string_view clear_line = "\r\x1b[K";

void put(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

}  // namespace

Progress::Progress(bool wanted) {
  if (wanted && terminal_shows_progress())
    painter_ = std::jthread([this](std::stop_token stop) { draw(stop); });
}

Progress::~Progress() {
  if (painter_.joinable()) {
    painter_.request_stop();
    wake_.notify_all();
    painter_.join();
  }
  hide();
}

void Progress::show(std::string text) {
  const std::scoped_lock lock(mutex_);
  text_ = std::move(text);
  wake_.notify_all();
}

void Progress::hide() {
  const std::scoped_lock lock(mutex_);
  text_.clear();
  if (drawn_) put(std::string(clear_line));
  drawn_ = false;
}

void Progress::draw(std::stop_token stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    if (!text_.empty()) {
      std::string line = fmt::format("{:6.1f} s  {}", watch_.seconds(), text_);
      line.resize(std::min(line.size(), terminal_columns() - 1));
      put(std::string(clear_line) + line);
      drawn_ = true;
    }
    wake_.wait_for(lock, stop, std::chrono::milliseconds(250), [] { return false; });
  }
}

}  // namespace halflight
