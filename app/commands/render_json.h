// What a rendered picture says about itself: the JSON of `render` and the attributes of its file.
#pragma once

#include <string>
#include <vector>

#include "commands/json_output.h"
#include "commands/sampling.h"
#include "film/image_writers.h"
#include "options.h"

namespace halflight {

/// A finished picture as reports need it; everything it points at must outlive it.
struct RenderRecord {
  const Options* options = nullptr;
  const Session* session = nullptr;
  const std::vector<std::string>* warnings = nullptr;
  StopReason stopped_by = StopReason::samples;
  bool adaptive = false;     ///< pixels got samples by their estimated error
  double load_seconds = 0;   ///< reading the scene, before the session
  double total_seconds = 0;  ///< wall clock, everything but writing the files
  double cpu_seconds = 0;    ///< all threads
};

/// The object of `render --json`; DESIGN lists its keys.
Json render_json(const RenderRecord&);

/// Attributes of the picture's file, and with `aovs` the layers Albedo, N, P and Variance.
ImageMetadata render_metadata(const RenderRecord&, bool aovs);

/// The plan as an array of {stage, runs, why}, with counters also {calls, bytes, seconds}; bytes are held at
/// the end, seconds 0 where they are not measured apart.
Json plan_json(const Plan&, const StageCounters* = nullptr);
/// {backend, renderer, version}; backend "none" where the pixels come from rays.
Json gl_json(const Session&);

Target used_target(const Session&);

/// Largest memory the process has held, in MB (10^6 bytes).
double peak_memory_mb();
/// Processor time of all threads so far, in seconds.
double process_cpu_seconds();

}  // namespace halflight
