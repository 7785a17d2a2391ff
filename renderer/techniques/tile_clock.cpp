#include "techniques/tile_clock.h"

#include <algorithm>
#include <chrono>

#if defined(__x86_64__)
#include <x86intrin.h>
#endif

#include "core/timeline.h"

namespace halflight {

uint64_t ticks_now() {
#if defined(__x86_64__)
  return __rdtsc();
#else
  return static_cast<uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
#endif
}

void TileClock::begin() {
  *this = TileClock();
  start_ = ticks_now();
}

void TileClock::end(PassStats& stats) const {
  const auto ticks = static_cast<double>(std::max<uint64_t>(ticks_now() - start_, 1));
  const double seconds = watch_.seconds(), unit = seconds / ticks;
  if (Timeline* timeline = Timeline::current()) timeline->add_tile(seconds);
  const double of_gbuffer = static_cast<double>(gbuffer) * unit,
               of_distribution = static_cast<double>(distribution) * unit,
               of_visibility = static_cast<double>(visibility) * unit,
               of_resolve = static_cast<double>(resolve) * unit;
  stats.gbuffer_seconds += of_gbuffer;
  stats.distribution_seconds += of_distribution;
  stats.visibility_seconds += of_visibility;
  stats.resolve_seconds += of_resolve;
  stats.sampling_seconds +=
      std::max(seconds - of_gbuffer - of_distribution - of_visibility - of_resolve, 0.0);
}

}  // namespace halflight
