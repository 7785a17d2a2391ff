#include "commands/adaptive_sampling.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/errors.h"

namespace halflight {

namespace {

constexpr uint32_t least_samples = 2;      ///< of a uniform pass: both halves of the film get some
constexpr uint32_t pilot_samples = 8;      ///< a pixel, of the first uniform pass
constexpr double uniform_share = 1.0 / 8;  ///< of all samples, least
constexpr double most_growth = 4;  ///< of the samples so far in one step: the error is looked at often
constexpr uint32_t most_in_a_visit = 256;
constexpr double aim = 0.95;         ///< share of the error asked for that a step aims at
constexpr double least_step = 1.15;  ///< of the samples, where a step has to be taken

}  // namespace

AdaptiveSampler::AdaptiveSampler(Session& session, const SamplingGoal& goal, const Stopwatch& clock,
                                 std::stop_token stop, const std::function<void()>& after_pass)
    : session_(session),
      goal_(goal),
      clock_(clock),
      stop_(std::move(stop)),
      after_pass_(after_pass),
      allocation_(session.film().width(), session.film().height()) {
  HALFLIGHT_CHECK(!session.plan().redraws);
}

std::optional<StopReason> AdaptiveSampler::cut_short() const {
  if (stop_.stop_requested()) return StopReason::interrupted;
  if (goal_.seconds && clock_.seconds() >= *goal_.seconds) return StopReason::time;
  return std::nullopt;
}

std::optional<StopReason> AdaptiveSampler::done() {
  if (stop_.stop_requested()) return StopReason::interrupted;
  if (uniform_ == 0) return std::nullopt;
  if (goal_.samples && session_.film().mean_samples() >= *goal_.samples) return StopReason::samples;
  if (const auto reason = cut_short()) return reason;
  if (goal_.error) error_ = session_.film().estimated_relmse();
  if (goal_.error && error_ >= 0 && error_ <= *goal_.error) return StopReason::error;
  return std::nullopt;
}

AdaptiveSampler::Room AdaptiveSampler::room() const {
  Room room;
  if (goal_.samples) room.samples = std::max(0.0, *goal_.samples - session_.film().mean_samples());
  if (!goal_.seconds || seconds_a_sample_ <= 0) return room;
  const double fit = std::max(0.0, (*goal_.seconds - clock_.seconds()) / seconds_a_sample_);
  return fit < room.samples ? Room{fit, StopReason::time} : room;
}

void AdaptiveSampler::end_pass(double start, double samples) {
  seconds_a_sample_ = (clock_.seconds() - start) / samples;
  if (after_pass_) after_pass_();
}

/// As many samples at every pixel, half of them in each half of the film. A timed picture starts with as few
/// as tell what a sample costs.
std::optional<StopReason> AdaptiveSampler::uniform_pass() {
  uint32_t samples = std::bit_floor(uniform_);
  if (uniform_ == 0) {
    samples = goal_.seconds ? least_samples : pilot_samples;
    if (goal_.samples) samples = std::clamp(*goal_.samples, least_samples, samples);
  } else {
    const Room left = room();
    if (left.samples < least_samples) return left.end;
    samples = static_cast<uint32_t>(std::min<double>(samples, left.samples));
  }
  const Film before = session_.film();
  const double start = clock_.seconds();
  session_.run_pass(samples, 1, 0, stop_);
  if (stop_.stop_requested()) return StopReason::interrupted;
  allocation_.learn(before, session_.film());
  uniform_ += samples;
  end_pass(start, samples);
  return std::nullopt;
}

/// The scale of the next step: towards the error or the samples asked for, and not too far at once.
double AdaptiveSampler::next_scale() const {
  const Film& film = session_.film();
  const double samples = film.mean_samples();
  double scale =
      allocation_.scale_for_samples(film, std::min(samples * most_growth, samples + room().samples));
  if (goal_.error) {
    // What the film finds against what was expected of it corrects the expectation.
    const double expected = allocation_.expected_relmse(film, 0);
    const double wanted = error_ > 0 ? aim * *goal_.error * expected / error_ : *goal_.error;
    const double least = allocation_.scale_for_samples(film, samples * least_step);
    scale = std::min(scale, std::max(least, allocation_.scale_for_error(film, wanted)));
  }
  return scale;
}

/// Brings the pixels to one scale, in passes that neighbours share what is made for them in.
std::optional<StopReason> AdaptiveSampler::adapted_round() {
  const Film& film = session_.film();
  // Pixels wait until they lack enough to be worth a visit; with none worth one the step has to be larger.
  double scale = next_scale();
  const Room left = room();
  const double most = film.mean_samples() + left.samples;
  const double most_scale = std::isfinite(most) ? allocation_.scale_for_samples(film, most) : infinity;
  while (!allocation_.next_round(film, scale, most_in_a_visit, visits_)) {
    if (scale >= most_scale) return left.end;
    scale = std::min(scale * least_step, most_scale);
  }
  do {
    const double start = clock_.seconds(), samples = film.mean_samples();
    session_.run_visits(*std::max_element(visits_.begin(), visits_.end()), visits_, stop_);
    if (stop_.stop_requested()) return StopReason::interrupted;
    end_pass(start, film.mean_samples() - samples);
    if (const auto reason = cut_short()) return reason;
  } while (allocation_.next_round(film, scale, most_in_a_visit, visits_));
  return std::nullopt;
}

StopReason AdaptiveSampler::run() {
  for (;;) {
    if (const auto reason = done()) return *reason;
    const bool learns = uniform_ == 0 || uniform_ < uniform_share * session_.film().mean_samples();
    if (const auto reason = learns ? uniform_pass() : adapted_round()) return *reason;
  }
}

}  // namespace halflight
