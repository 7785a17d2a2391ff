// Adaptive sampling until a goal is met: pixels get samples by their estimated error
// (film/sample_allocation.h).
#pragma once

#include "commands/sampling.h"
#include "film/sample_allocation.h"

namespace halflight {

class AdaptiveSampler {
 public:
  AdaptiveSampler(Session&, const SamplingGoal&, const Stopwatch& clock, std::stop_token,
                  const std::function<void()>& after_pass);

  StopReason run();

 private:
  std::optional<StopReason> done();
  void uniform_pass(uint32_t samples);
  bool adapted_round();
  double next_scale() const;
  bool run_visits();
  bool interrupted_or_late() const;
  void after_pass() const;

  Session& session_;
  SamplingGoal goal_;
  const Stopwatch& clock_;
  std::stop_token stop_;
  const std::function<void()>& after_pass_;
  SampleAllocation allocation_;
  uint32_t uniform_ = 0;          ///< samples a pixel of uniform passes
  double error_ = -1;             ///< relMSE that the film estimates of itself, below 0 for none
  double seconds_a_sample_ = 0;   ///< of the whole picture, as last measured
  std::vector<uint16_t> visits_;  ///< samples of each pixel in the round in hand
  std::vector<uint16_t> chosen_;  ///< those of them in the pass in hand
};

}  // namespace halflight
