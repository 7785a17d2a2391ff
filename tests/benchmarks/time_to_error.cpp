#include "benchmarks/time_to_error.h"

#include <cmath>

#include "benchmarks/benchmarks.h"
#include "core/errors.h"
#include "core/stopwatch.h"
#include "film/metrics.h"

namespace halflight {

namespace {

struct Round {
  double seconds, cpu_seconds;
  ImageRgb picture;
};

struct Run {
  double prepare_seconds;
  std::vector<Round> rounds;
};

/// One run; it ends after `rounds`, or where that is 0 when the film's own estimate is well below the goal.
Run run_once(Session& session, const ErrorGoal& goal, size_t rounds) {
  constexpr size_t most_rounds = 64;
  Run run;
  session.start_over();
  const double cpu_start = process_cpu_seconds();
  Stopwatch watch;
  session.frame();
  run.prepare_seconds = watch.seconds();
  double seconds = run.prepare_seconds, cpu_seconds = process_cpu_seconds() - cpu_start;
  const auto done = [&] {
    if (rounds > 0) return run.rounds.size() >= rounds;
    const double error = session.estimated_relmse();
    return run.rounds.size() >= most_rounds ||
           (run.rounds.size() >= 2 && error >= 0 && error < 0.6 * goal.relmse);
  };
  while (!done()) {
    const double cpu_before = process_cpu_seconds();
    watch.lap();
    session.run_pass(goal.samples_a_round, 1, 0);
    seconds += watch.lap(), cpu_seconds += process_cpu_seconds() - cpu_before;
    run.rounds.push_back({seconds, cpu_seconds, session.film().image()});
  }
  return run;
}

using Metric = double ErrorMetrics::*;

ImageRgb mean_of(const std::vector<const ImageRgb*>& pictures) {
  ImageRgb mean(pictures[0]->width, pictures[0]->height);
  for (size_t i = 0; i < mean.pixels.size(); ++i) {
    Vec3d sum(0);
    for (const ImageRgb* picture : pictures) sum += Vec3d(picture->pixels[i]);
    mean.pixels[i] = Vec3(sum / static_cast<double>(pictures.size()));
  }
  return mean;
}

/// The mean of last pictures; its own error from how much they differ from it: σ²(n − 1)/n, of which it keeps
/// σ²/n.
MeanPicture mean_picture(const std::vector<const ImageRgb*>& pictures, Metric metric) {
  MeanPicture mean{mean_of(pictures), 0};
  double apart = 0;
  for (const ImageRgb* picture : pictures) apart += measure_radiance_error(*picture, mean.image).*metric;
  const auto n = static_cast<double>(pictures.size());
  mean.relmse = apart / n / std::max(n - 1, 1.0);
  return mean;
}

/// The error after each round, the mean over the runs.
std::vector<double> errors_of(const std::vector<Run>& runs, Metric metric) {
  std::vector<double> errors(runs[0].rounds.size(), 0.0);
  for (size_t r = 0; r < runs.size(); ++r) {
    std::vector<const ImageRgb*> others;
    for (size_t o = 0; o < runs.size(); ++o)
      if (o != r) others.push_back(&runs[o].rounds.back().picture);
    const MeanPicture reference = mean_picture(others, metric);
    for (size_t i = 0; i < errors.size(); ++i)
      errors[i] +=
          (measure_radiance_error(runs[r].rounds[i].picture, reference.image).*metric - reference.relmse) /
          static_cast<double>(runs.size());
  }
  return errors;
}

/// Where the error meets the goal, in rounds (1 is after the first); by error ∝ 1/rounds before the first and
/// after the last.
double rounds_to_goal(const std::vector<double>& errors, double goal) {
  if (errors.front() <= goal) return errors.front() / goal;
  for (size_t i = 1; i < errors.size(); ++i) {
    if (errors[i] > goal) continue;
    const double share = std::log(errors[i - 1] / goal) / std::log(errors[i - 1] / errors[i]);
    const auto begin = static_cast<double>(i), end = static_cast<double>(i + 1);
    return begin * std::pow(end / begin, share);
  }
  return static_cast<double>(errors.size()) * errors.back() / goal;
}

/// From the runs' own times; linear in rounds.
Reached reached_after(double rounds, const std::vector<Run>& runs, uint32_t samples_a_round) {
  Reached reached{rounds * samples_a_round, 0, 0};
  const auto n = static_cast<double>(runs.size());
  for (const Run& run : runs) {
    const Round& end = run.rounds.back();
    const double cpu_before = run.rounds.front().cpu_seconds, before = run.prepare_seconds;
    const auto all_rounds = static_cast<double>(run.rounds.size());
    // The CPU time of the preparation is what the first round has beyond the mean of those after it.
    const double cpu_a_round =
        run.rounds.size() > 1 ? (end.cpu_seconds - cpu_before) / (all_rounds - 1) : cpu_before;
    reached.seconds += (before + (end.seconds - before) / all_rounds * rounds) / n;
    reached.cpu_seconds += (cpu_before + cpu_a_round * (rounds - 1)) / n;
  }
  return reached;
}

}  // namespace

TimeToError time_to_error(Session& session, const ErrorGoal& goal) {
  HALFLIGHT_CHECK(goal.runs >= 3);
  std::vector<Run> runs;
  for (int r = 0; r < goal.runs; ++r) {
    RenderSettings settings = session.settings();
    settings.seed = static_cast<uint64_t>(r) + 1;
    session.set_settings(settings);
    runs.push_back(run_once(session, goal, r == 0 ? 0 : runs[0].rounds.size()));
  }
  const auto reached = [&](Metric metric) {
    return reached_after(rounds_to_goal(errors_of(runs, metric), goal.relmse), runs, goal.samples_a_round);
  };
  TimeToError result;
  result.whole = reached(&ErrorMetrics::relmse), result.trimmed = reached(&ErrorMetrics::relmse_trimmed);
  std::vector<const ImageRgb*> last;
  for (const Run& run : runs) {
    result.prepare_seconds += run.prepare_seconds / static_cast<double>(runs.size());
    last.push_back(&run.rounds.back().picture);
  }
  result.lights = session.stats().light_count, result.cut = session.stats().cut_size;
  result.mean = mean_picture(last, &ErrorMetrics::relmse);
  return result;
}

double relmse_between(const MeanPicture& picture, const MeanPicture& reference) {
  return measure_radiance_error(picture.image, reference.image).relmse - picture.relmse - reference.relmse;
}

}  // namespace halflight
