// How long a session takes to a given error, everything but loading included.
#pragma once

#include "session.h"

namespace halflight {

struct ErrorGoal {
  double relmse = 1e-2;
  int runs = 5;  ///< of seeds 1, 2, …; each is measured against the mean of the others
  uint32_t samples_a_round = 16;
};

/// The mean picture of some runs with the error that its noise leaves.
struct MeanPicture {
  ImageRgb image;
  double relmse = 0;
};

/// What it takes until the error meets the goal, preparation included; means over the runs.
struct Reached {
  double samples = 0;  ///< a pixel
  double seconds = 0, cpu_seconds = 0;
};

struct TimeToError {
  double prepare_seconds = 0;  ///< S, tree, cut and G-buffer
  Reached whole;               ///< by relMSE
  Reached trimmed;             ///< by relMSE without the worst 0.1 % of pixels, which a few samples decide
  uint32_t lights = 0, cut = 0;
  MeanPicture mean;
};

/// Runs the session's technique over and over from S on. The error at each round is that against the mean of
/// the other runs less what that mean is off itself; the goal is met where a line through the logarithms
/// meets it.
TimeToError time_to_error(Session&, const ErrorGoal&);

/// relMSE between what two means estimate: what their noise adds is subtracted, so that it may fall below 0.
double relmse_between(const MeanPicture&, const MeanPicture& reference);

}  // namespace halflight
