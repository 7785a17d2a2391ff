#include "commands/adaptive_sampling.h"

#include <algorithm>
#include <bit>

namespace halflight {

namespace {

constexpr uint32_t pilot_samples = 8;      ///< a pixel, of the first uniform pass
constexpr double uniform_share = 1.0 / 8;  ///< of all samples, least
constexpr double most_growth = 4;  ///< of the samples so far in one step: the error is looked at often
// Samples of a round at a pixel share S and their place in it where the target is continuous.
constexpr uint32_t most_in_a_visit = 256, most_in_a_continuous_visit = 32;
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
      allocation_(session.film().width(), session.film().height()) {}

void AdaptiveSampler::after_pass() const {
  if (after_pass_) after_pass_();
}

bool AdaptiveSampler::interrupted_or_late() const {
  return stop_.stop_requested() || (goal_.seconds && clock_.seconds() >= *goal_.seconds);
}

std::optional<StopReason> AdaptiveSampler::done() {
  if (stop_.stop_requested()) return StopReason::interrupted;
  if (uniform_ == 0) return std::nullopt;
  const double samples = session_.film().mean_samples();
  if (goal_.samples && samples >= *goal_.samples) return StopReason::samples;
  if (goal_.seconds && clock_.seconds() >= *goal_.seconds) return StopReason::time;
  if (goal_.error) error_ = session_.film().estimated_relmse();
  if (goal_.error && error_ >= 0 && error_ <= *goal_.error) return StopReason::error;
  return std::nullopt;
}

/// As many samples at every pixel, half of them in each half of the film.
void AdaptiveSampler::uniform_pass(uint32_t samples) {
  const Film before = session_.film();
  const double start = clock_.seconds();
  if (session_.plan().redraws) {
    for (int half = 0; half < 2; ++half) session_.run_pass(samples / 2, 1, 0, stop_);
  } else {
    session_.run_pass(samples, 1, 0, stop_);
  }
  if (stop_.stop_requested()) return;
  allocation_.learn(before, session_.film());
  uniform_ += samples;
  seconds_a_sample_ = (clock_.seconds() - start) / samples;
  after_pass();
}

/// The scale of the next step: towards the error or the samples asked for, and not too far at once.
double AdaptiveSampler::next_scale() const {
  const Film& film = session_.film();
  const double samples = film.mean_samples();
  double most = samples * most_growth;
  if (goal_.samples) most = std::min<double>(most, *goal_.samples);
  if (goal_.seconds)
    most = std::min(most, samples + std::max(1.0, (*goal_.seconds - clock_.seconds()) / seconds_a_sample_));
  double scale = allocation_.scale_for_samples(film, most);
  if (goal_.error) {
    // What the film finds against what was expected of it corrects the expectation.
    const double expected = allocation_.expected_relmse(film, 0);
    const double wanted = error_ > 0 ? aim * *goal_.error * expected / error_ : *goal_.error;
    const double least = allocation_.scale_for_samples(film, samples * least_step);
    scale = std::min(scale, std::max(least, allocation_.scale_for_error(film, wanted)));
  }
  return scale;
}

/// One pass, in which neighbours share what is made for them. Where rounds redraw S, one for each number of
/// samples that pixels get, and the whole twice, once for each half of the film.
bool AdaptiveSampler::run_visits() {
  if (!session_.plan().redraws) {
    session_.run_pass(*std::max_element(visits_.begin(), visits_.end()), {visits_}, stop_);
    if (interrupted_or_late()) return false;
    after_pass();
    return true;
  }
  constexpr int rounds = 2;
  std::vector<uint16_t> levels(visits_);
  std::sort(levels.begin(), levels.end());
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
  std::erase(levels, uint16_t{0});
  for (int round = 0; round < rounds; ++round) {
    for (size_t i = 0; i < levels.size(); ++i) {
      std::transform(visits_.begin(), visits_.end(), chosen_.begin(), [&](uint16_t samples) {
        return static_cast<uint16_t>(samples == levels[i] ? samples / rounds : 0);
      });
      session_.run_pass(levels[i] / rounds, {chosen_, i == 0, i + 1 == levels.size()}, stop_);
      if (interrupted_or_late()) return false;
      after_pass();
    }
  }
  return true;
}

/// Brings the pixels to one scale; false when it was cut short.
bool AdaptiveSampler::adapted_round() {
  const Film& film = session_.film();
  const bool redraws = session_.plan().redraws;
  const uint32_t most = redraws ? most_in_a_continuous_visit : most_in_a_visit;
  const VisitSizes sizes = redraws ? VisitSizes::powers_of_two : VisitSizes::any;
  double scale = next_scale();
  while (!allocation_.next_round(film, scale, most, sizes, visits_)) scale *= least_step;
  do {
    const double start = clock_.seconds(), samples = film.mean_samples();
    if (!run_visits()) return false;
    seconds_a_sample_ = (clock_.seconds() - start) / (film.mean_samples() - samples);
  } while (allocation_.next_round(film, scale, most, sizes, visits_));
  return true;
}

StopReason AdaptiveSampler::run() {
  chosen_.resize(static_cast<size_t>(session_.film().width()) *
                 static_cast<size_t>(session_.film().height()));
  for (;;) {
    if (const auto reason = done()) return *reason;
    if (uniform_ < uniform_share * session_.film().mean_samples() || uniform_ == 0)
      uniform_pass(std::max(std::clamp(goal_.samples.value_or(pilot_samples), 2u, pilot_samples),
                            std::bit_floor(uniform_)));
    else
      adapted_round();
  }
}

}  // namespace halflight
