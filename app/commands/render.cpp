// halflight render: one picture, no window.
#include <algorithm>

#include "commands/commands.h"
#include "commands/json_output.h"
#include "commands/open_scene.h"
#include "commands/render_json.h"
#include "commands/sampling.h"
#include "console.h"
#include "core/parallel.h"
#include "interruption.h"
#include "progress.h"

namespace halflight {

namespace {

constexpr uint32_t default_samples = 32;

std::string lower_extension(const std::string& file) {
  std::string extension = std::filesystem::path(file).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

/// Everything about the outputs that can be known before minutes of rendering.
void check_outputs(const Options& options) {
  if (options.output.empty())
    throw usage_error("`halflight render` needs -o FILE: a picture ending in .exr, .hdr or .png");
  const std::string extension = lower_extension(options.output);
  if (extension != ".exr" && extension != ".hdr" && extension != ".png")
    throw usage_error(fmt::format("--output: '{}' ends in none of .exr, .hdr and .png", options.output));
  if (options.aovs && extension != ".exr")
    throw usage_error("--aovs: only an .exr holds layers beside the picture");
  check_writable(options.output);
  check_writable(options.json);
}

SamplingGoal goal_of(const Options& options) {
  SamplingGoal goal{options.samples, options.seconds, options.until_error};
  if (!goal.samples && !goal.seconds && !goal.error) goal.samples = default_samples;
  // Pixels of a round of the continuous target share S and the pixel grid: a pixel's neighbours tell of its
  // own samples, and numbers of samples that follow them bias the mean (docs/performance.md).
  const bool discrete =
      choose_target(find_technique(options.render.technique), options.render.target) == Target::discrete;
  if (options.adaptive.value_or(false) && !discrete)
    throw usage_error(
        "--adaptive on: the continuous target has no adaptive sampling, it would bias the mean");
  goal.adaptive = options.adaptive.value_or(goal.error && !goal.seconds && discrete);
  return goal;
}

std::string progress_text(const Session& session, const SamplingGoal& goal) {
  const Film& film = session.film();
  std::string text = fmt::format("{:.4g}", film.mean_samples());
  if (goal.samples) text += fmt::format(" of {}", *goal.samples);
  text += " samples a pixel";
  if (const double error = session.estimated_relmse(); error >= 0)
    text += fmt::format(", estimated error {:.2g}", error);
  if (goal.error) text += fmt::format(" (goal {:.2g})", *goal.error);
  return text;
}

/// The film; where a stop left pixels without a sample, their neighbours' values stand in.
ImageRgb finished_picture(const Film& film) {
  const uint32_t pixels = static_cast<uint32_t>(film.width() * film.height());
  for (uint32_t i = 0; i < pixels; ++i)
    if (film.samples(i) == 0) return film.preview();
  return film.image();
}

std::string summary(const RenderRecord& record) {
  const Film& film = record.session->film();
  const double error = record.session->estimated_relmse();
  return fmt::format("{}: {}x{}, {:.4g} samples a pixel in {:.1f} s{}{}", record.options->output,
                     film.width(), film.height(), film.mean_samples(), record.total_seconds,
                     error < 0 ? "" : fmt::format(", estimated relMSE {:.2g}", error),
                     record.stopped_by == StopReason::interrupted ? " (interrupted)" : "");
}

}  // namespace

int run_render(const Options& options) {
  check_outputs(options);
  Stopwatch since_start;
  Interruption interruption;
  set_thread_count(options.threads);
  Progress progress(!options.quiet);
  WarningPrinter warnings(options.quiet);

  // Scene and session.
  Messages messages;
  progress.show(fmt::format("opening {}", options.scene));
  OpenedScene opened = open_scene(options, messages);
  const Stopwatch clock;
  Session session(std::move(opened.scene), options.render, messages);
  progress.hide();
  warnings.print_new(messages);

  // Samples, until the goal or Ctrl-C; before the lights stand there is nothing to keep.
  const SamplingGoal goal = goal_of(options);
  progress.show("lights");
  session.frame();
  interruption.keep_what_there_is();
  progress.show("first samples");
  RenderRecord record{&options, &session, &messages.warnings};
  record.stopped_by = sample_until(session, goal, clock, interruption.token(), [&] {
    if (progress.visible()) progress.show(progress_text(session, goal));
  });
  record.adaptive = samples_adaptively(session, goal);
  record.load_seconds = opened.seconds;
  record.total_seconds = since_start.seconds();
  record.cpu_seconds = process_cpu_seconds();
  if (max_component(session.film().mean_radiance()) <= 0)
    messages.warn("the picture is black: no light reaches what the camera sees");
  if (const TechniqueInfo& info = find_technique(session.settings().technique);
      info.device == Device::gpu && !session.plan().runs.has(Stage::gpu_environment))
    messages.warn(fmt::format("{} shows light of the environment only, and here is none", info.id));
  if (const auto first = session.film().first_nan()) {
    const auto width = static_cast<uint32_t>(session.film().width());
    messages.warn(fmt::format(
        "{} samples were not finite and count as 0; the first in pixel ({}, {}), sample {}, seed {}",
        session.film().nan_samples(), first->pixel % width, first->pixel / width, first->sample,
        session.settings().seed));
  }
  progress.hide();
  warnings.print_new(messages);

  // Files.
  const bool interrupted = record.stopped_by == StopReason::interrupted;
  if (interrupted && session.film().mean_samples() == 0) {
    print_note("interrupted before the first sample; nothing is written");
    return static_cast<int>(ExitCode::interrupted);
  }
  write_image(options.output, finished_picture(session.film()), opened.display,
              render_metadata(record, options.aovs));
  if (!options.json.empty()) write_json(options.json, render_json(record));
  if (!options.quiet) print_note(summary(record));
  return static_cast<int>(interrupted ? ExitCode::interrupted : ExitCode::ok);
}

}  // namespace halflight
