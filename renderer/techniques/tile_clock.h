// Where the time of a tile goes, on the thread that renders it.
#pragma once

#include <cstdint>

#include "core/stopwatch.h"
#include "techniques/technique.h"

namespace halflight {

/// Time stamps cheap enough to take several times a pixel; a tile's wall-clock time gives their unit.
uint64_t ticks_now();

/// Stages add their ticks to it; what none of them took of a tile is sampling.
class TileClock {
 public:
  void begin();
  /// Adds the tile's seconds to the pass's, and the tile to the timeline.
  void end(PassStats&) const;

  // Ticks since `begin`.
  uint64_t gbuffer = 0, distribution = 0, visibility = 0, resolve = 0;

 private:
  Stopwatch watch_;
  uint64_t start_ = 0;
};

/// Adds the ticks of its scope.
class TickScope {
 public:
  explicit TickScope(uint64_t& ticks) : ticks_(ticks), start_(ticks_now()) {}
  ~TickScope() { ticks_ += ticks_now() - start_; }
  TickScope(const TickScope&) = delete;
  TickScope& operator=(const TickScope&) = delete;

 private:
  uint64_t& ticks_;
  uint64_t start_;
};

}  // namespace halflight
