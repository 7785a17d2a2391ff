// Where a case's checks get pictures from: sessions, truths and independent runs.
#pragma once

#include <map>

#include "stress/stress_case.h"
#include "stress/stress_statistics.h"

namespace halflight {

/// The picture that a case's runs are measured against.
struct StressTruth {
  MarkStatistics marks;
  ImageRgb picture;
  std::vector<Vec3d> variance;  ///< of each pixel of `picture`
  double mean = 0;              ///< of the picture, over channels
};

/// Number of runs for a test's mean.
struct RunCounts {
  uint32_t pilot, least, most;
};

class StressStage {
 public:
  StressStage(const StressCase&, const StressEffort&, std::stop_token);

  const StressCase& stress_case() const { return case_; }
  const std::stop_token& stop() const { return stop_; }
  RunCounts run_counts(Target) const;
  uint32_t samples() const { return case_.samples; }

  /// The settings of the case for a technique.
  RenderSettings settings(std::string_view technique, Target,
                          const std::vector<std::pair<std::string, std::string>>& more = {}) const;
  /// A session of the case's scene, or of the one its truth is of, with the settings; one a target is kept.
  Session& session(const RenderSettings&, bool of_truth = false);
  /// `reference` of the same S, `path`, or what the case knows.
  const StressTruth& truth(Target);

 private:
  StressTruth find_truth(Target);

  const StressCase& case_;
  const StressEffort& effort_;
  std::stop_token stop_;
  Messages messages_;
  std::map<std::pair<Target, bool>, std::unique_ptr<Session>> sessions_;
  std::map<Target, StressTruth> truths_;
};

/// A run's picture and what was no number in it.
struct StressPicture {
  ImageRgb image;
  uint64_t nan_samples = 0;
  std::optional<NanPlace> first_nan;
};

/// Independent runs of a contestant in one session.
///
/// Continuous target: the places in a pixel are a fixed sequence over rounds, of which a few rounds see a few
/// only. So runs of the same seed follow one another, each with the rounds after those of the run before it,
/// and a seed has `block` of them.
class StressRuns {
 public:
  /// Starts over, so that `first_picture` is all the work from the scene in memory to a sample in each pixel.
  StressRuns(StressStage&, const Contestant&, bool of_truth = false);

  static constexpr uint32_t block = 8;

  /// A picture of the case's samples; another index is an independent one. Discrete target: of the same S.
  /// Indices go up by one from a multiple of `block`.
  StressPicture run(uint32_t index);
  double first_picture() const { return first_picture_; }
  /// See Measured; NaN where the technique tells no probabilities.
  double largest_weight();
  Session& session() { return session_; }

 private:
  StressStage& stage_;
  RenderSettings settings_;
  Session& session_;
  std::unique_ptr<Technique> technique_;  ///< discrete target
  FrameView frame_;
  std::vector<Vec3d> sum_;  ///< of the runs of this seed so far
  uint64_t sum_nans_ = 0;
  double first_picture_ = 0;
};

/// The checks. Each returns what it found and why that falls short.
Finding check_mean(StressStage&, const Contestant&);
/// Pictures of the case's scene and of its truth's, from the same random numbers, are one: `factor` × as
/// bright, up to the case's tolerance of their sums of absolute differences.
Finding check_same_picture(StressStage&, const Contestant&, double factor);
/// Lights edited between frames give what a new session with those lights gives.
Finding check_edited_lights(StressStage&, const Contestant&);
/// A radiance that is not a number is counted, its pixel told, and the picture stays finite.
Finding check_counted_nans(StressStage&, const Contestant&);
/// Relative variance × samples in the case's scene is at most `most` × that in its truth's.
Finding check_variance_growth(StressStage&, const Contestant&, double most);

}  // namespace halflight
