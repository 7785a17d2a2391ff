#include "commands/sampling.h"

#include <algorithm>
#include <cmath>

#include "commands/adaptive_sampling.h"

namespace halflight {

namespace {

constexpr double subset_share = 1.0 / 16;  ///< of the pixels in a subset, about
constexpr uint32_t first_round = 8;        ///< samples a pixel, where no total says how to share them out
constexpr double longest_whole_round = 1;  ///< seconds; longer rounds go by subsets, to show how they get on
constexpr uint32_t most_unmeasured = 64;   ///< samples of a whole round before its cost is known
constexpr uint32_t exact_samples = 40;     ///< of a single pass that is all there is, unless told
constexpr double error_margin = 1.1;       ///< on the samples that an error asked for is expected to take
/// A round takes at most such a share of the time left: what a sample costs falls as rounds grow, and the
/// next is measured again.
constexpr double most_of_time_left = 0.5;
constexpr double most_for_balance = 32;  ///< samples a round takes on to be worth its frame and distributions

/// Measured seconds of a round: its frame (S and pixel grid redrawn, continuous target only), the
/// distributions of its pixels, and each sample a pixel.
struct RoundCost {
  double frame = 0, distributions = 0, sample = 0;

  bool known() const { return sample > 0; }
  double of_pixels(double samples) const { return distributions + sample * samples; }
  double of(double samples) const { return frame + of_pixels(samples); }
};

class Sampler {
 public:
  Sampler(Session& session, const SamplingGoal& goal, const Stopwatch& clock, std::stop_token stop,
          const std::function<void()>& after_pass)
      : session_(session), goal_(goal), clock_(clock), stop_(std::move(stop)), after_pass_(after_pass) {}

  StopReason run();

 private:
  uint32_t next_round() const;
  StopReason only_round(const TechniqueInfo&);
  void whole_round(uint32_t samples);
  void round_in_subsets(uint32_t samples, bool every_pixel);
  double time_left() const { return goal_.seconds ? *goal_.seconds - clock_.seconds() : infinity; }
  double timed_pass(uint32_t samples, std::optional<uint32_t> subset);
  bool time_is_up() const;

  Session& session_;
  SamplingGoal goal_;
  const Stopwatch& clock_;
  std::stop_token stop_;
  const std::function<void()>& after_pass_;
  uint32_t done_ = 0;
  double error_ = -1;  ///< relMSE that the film estimates of itself where that is a goal, below 0 for none
  RoundCost cost_;
};

/// With a number of samples alone, the session's own way of sharing them out. Otherwise rounds grow with what
/// is done, so that the goal is looked at often, and are large enough for the samples to be worth their
/// distributions.
uint32_t Sampler::next_round() const {
  const bool only_samples = goal_.samples && !goal_.seconds && !goal_.error;
  uint32_t wanted = session_.round_samples(only_samples ? *goal_.samples : std::max(done_, first_round));
  if (!only_samples && cost_.known())
    wanted = std::max(wanted, static_cast<uint32_t>(std::min(
                                  most_for_balance, (cost_.frame + cost_.distributions) / cost_.sample)));
  // Where one round uses many samples well, rounds are as large as the time allows.
  if (goal_.seconds && cost_.known()) {
    const double most = find_technique(session_.settings().technique).samples_a_round;
    const double fit = (most_of_time_left * time_left() - cost_.frame - cost_.distributions) / cost_.sample;
    wanted = std::max(wanted, static_cast<uint32_t>(std::clamp(fit, 1.0, most)));
  }
  // Not far beyond the error asked for, which falls as 1/N.
  if (error_ > 0)
    wanted = static_cast<uint32_t>(std::clamp(std::ceil(error_margin * done_ * (error_ / *goal_.error - 1)),
                                              1.0, static_cast<double>(wanted)));
  return goal_.samples ? std::min(*goal_.samples - done_, wanted) : wanted;
}

/// Runs a pass and learns from it what a round of the whole picture costs. Returns which share of the pixels
/// it has visited.
double Sampler::timed_pass(uint32_t samples, std::optional<uint32_t> subset) {
  Stopwatch watch;
  const StageSeconds before = session_.stats().seconds;
  double share = 1;
  if (subset) {
    const auto pixels = static_cast<double>(session_.film().width()) * session_.film().height();
    share = static_cast<double>(session_.run_subset(samples, *subset, stop_)) / pixels;
  } else {
    session_.run_pass(samples, 1, 0, stop_);
  }
  const StageSeconds& after = session_.stats().seconds;
  const double frame = after.lights - before.lights + after.raster - before.raster;
  if (session_.plan().redraws && subset.value_or(0) == 0) cost_.frame = frame;
  if (share == 0) return share;
  const double pixels = std::max(1e-9, watch.seconds() - frame);
  const double distributions = std::min(after.distribution - before.distribution, pixels);
  cost_.distributions = distributions / share;
  cost_.sample = std::max(1e-9, pixels - distributions) / (share * samples);
  return share;
}

void Sampler::whole_round(uint32_t samples) {
  timed_pass(samples, std::nullopt);
  done_ += samples;
}

/// Samples are taken back where the time would not last; unless `every_pixel`, subsets may be left out at the
/// end.
void Sampler::round_in_subsets(uint32_t samples, bool every_pixel) {
  uint32_t most = 0;
  double left = 1;  // of the pixels
  const uint32_t count = session_.subset_count();
  for (uint32_t subset = 0; subset < count && !stop_.stop_requested(); ++subset) {
    if (cost_.known()) {
      const double seconds =
          (time_left() - (subset == 0 ? cost_.frame : 0)) / std::max(left, subset_share / 2);
      const double fit = (seconds - cost_.distributions) / cost_.sample;
      samples = static_cast<uint32_t>(std::clamp(fit, 1.0, static_cast<double>(samples)));
      if (!every_pixel && time_left() < 0.5 * cost_.of_pixels(samples) * subset_share) break;
    }
    left -= timed_pass(samples, subset);
    most = std::max(most, samples);
    if (after_pass_) after_pass_();
  }
  done_ += most;
}

bool Sampler::time_is_up() const {
  return time_left() <
         std::max(0.03 * goal_.seconds.value_or(0), cost_.frame + cost_.of_pixels(1) * subset_share);
}

/// All there is in one round. What the GPU does is quick, and best done at once.
StopReason Sampler::only_round(const TechniqueInfo& technique) {
  const uint32_t samples = session_.round_samples(goal_.samples.value_or(exact_samples));
  if (technique.device == Device::gpu) {
    whole_round(samples);
    if (after_pass_) after_pass_();
  } else {
    round_in_subsets(samples, true);
  }
  return stop_.stop_requested() ? StopReason::interrupted : StopReason::samples;
}

StopReason Sampler::run() {
  const TechniqueInfo& technique = find_technique(session_.settings().technique);
  if (technique.exact) return only_round(technique);
  for (bool first = true;; first = false) {
    if (stop_.stop_requested()) return StopReason::interrupted;
    if (goal_.samples && done_ >= *goal_.samples) return StopReason::samples;
    if (!first && goal_.seconds && time_is_up()) return StopReason::time;
    if (goal_.error && !first) error_ = session_.film().estimated_relmse();
    if (goal_.error && error_ >= 0 && error_ <= *goal_.error) return StopReason::error;

    // Until the first subset has told what a sample costs, a timed picture starts with as few as give both
    // halves one.
    const uint32_t samples = first && goal_.seconds ? std::min(next_round(), 2u) : next_round();
    const bool may_be_long =
        cost_.known() ? cost_.of(samples) > longest_whole_round : samples > most_unmeasured;
    const bool fits = !goal_.seconds || (!first && cost_.of(samples) < time_left());
    if (fits && !may_be_long) {
      whole_round(samples);
      if (after_pass_) after_pass_();
    } else {
      round_in_subsets(samples, first || fits);
    }
  }
}

}  // namespace

std::string_view stop_reason_name(StopReason reason) {
  switch (reason) {
    case StopReason::samples:
      return "samples";
    case StopReason::time:
      return "time";
    case StopReason::error:
      return "error";
    default:
      return "interrupted";
  }
}

bool samples_adaptively(const Session& session, const SamplingGoal& goal) {
  return goal.adaptive && !find_technique(session.settings().technique).exact;
}

StopReason sample_until(Session& session, const SamplingGoal& goal, const Stopwatch& clock,
                        std::stop_token stop, const std::function<void()>& after_pass) {
  if (samples_adaptively(session, goal))
    return AdaptiveSampler(session, goal, clock, std::move(stop), after_pass).run();
  return Sampler(session, goal, clock, std::move(stop), after_pass).run();
}

}  // namespace halflight
