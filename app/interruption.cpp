#include "interruption.h"

#include <unistd.h>

#include "console.h"
#include "core/errors.h"

namespace halflight {

Interruption::Interruption() {
  sigemptyset(&caught_);
  sigaddset(&caught_, SIGINT);
  sigaddset(&caught_, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &caught_, &before_);
  watcher_ = std::jthread([this](std::stop_token finished) { watch(finished); });
}

Interruption::~Interruption() {
  watcher_.request_stop();
  watcher_.join();
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

void Interruption::watch(std::stop_token finished) {
  constexpr timespec patience{0, 20'000'000};
  while (!finished.stop_requested()) {
    if (sigtimedwait(&caught_, nullptr, &patience) < 0) continue;
    if (!keep_ || stop_.stop_requested()) _exit(static_cast<int>(ExitCode::interrupted));
    stop_.request_stop();
  }
}

}  // namespace halflight
