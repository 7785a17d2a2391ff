// Rounds of passes until a goal is met.
#pragma once

#include <functional>
#include <optional>
#include <stop_token>
#include <string_view>

#include "core/stopwatch.h"
#include "session.h"

namespace halflight {

/// When a picture is done: whichever comes first. At least one is set.
struct SamplingGoal {
  std::optional<uint32_t> samples;  ///< a pixel
  std::optional<double> seconds;    ///< on the clock given to `sample_until`
  std::optional<double>
      error;  ///< estimated relMSE; stopping by it is biased (ESTIMATORS: weights that depend on data)
  bool adaptive = false;  ///< pixels get samples by their estimated error
};

/// Whether the goal asks for adaptive sampling of a technique that more samples do anything for.
bool samples_adaptively(const Session&, const SamplingGoal&);

enum class StopReason { samples, time, error, interrupted };
std::string_view stop_reason_name(StopReason);

/// Runs passes over the session's film until the goal is met or `stop` is requested. Every pixel has a sample
/// at the end unless it was stopped. Long rounds, and with a time goal those at the start and at the end, go
/// through subsets of the picture (Session::run_subset), which shows how they get on and keeps the end near
/// the goal; adaptive sampling goes by whole passes. `after_pass` may show progress.
StopReason sample_until(Session&, const SamplingGoal&, const Stopwatch& clock, std::stop_token stop,
                        const std::function<void()>& after_pass);

}  // namespace halflight
