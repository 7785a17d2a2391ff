// Adaptive sampling until a goal is met: pixels get samples by their estimated error
// (film/sample_allocation.h).
#pragma once

#include "commands/sampling.h"
#include "film/sample_allocation.h"

namespace halflight {

/// For a session that redraws nothing between rounds (discrete target).
class AdaptiveSampler {
 public:
  AdaptiveSampler(Session&, const SamplingGoal&, const Stopwatch& clock, std::stop_token,
                  const std::function<void()>& after_pass);

  StopReason run();

 private:
  std::optional<StopReason> done();
  std::optional<StopReason> uniform_pass();
  std::optional<StopReason> adapted_round();
  std::optional<StopReason> cut_short() const;
  double next_scale() const;
  /// How many samples a pixel there may still be, on average, and whose end it is when they are spent.
  struct Room {
    double samples = infinity;
    StopReason end = StopReason::samples;
  };
  Room room() const;
  void end_pass(double start, double samples);

  Session& session_;
  SamplingGoal goal_;
  const Stopwatch& clock_;
  std::stop_token stop_;
  const std::function<void()>& after_pass_;
  SampleAllocation allocation_;
  uint32_t uniform_ = 0;          ///< samples a pixel of uniform passes
  double error_ = -1;             ///< relMSE that the film estimates of itself, below 0 for none
  double seconds_a_sample_ = 0;   ///< of the whole picture, as last measured
  std::vector<uint16_t> visits_;  ///< samples of each pixel in the pass in hand
};

}  // namespace halflight
