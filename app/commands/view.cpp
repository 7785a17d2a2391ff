#include <fmt/format.h>

#include "commands/commands.h"
#include "commands/json_output.h"
#include "commands/open_scene.h"
#include "interruption.h"
#include "viewer/viewer.h"

namespace halflight {

namespace {

/// What can be known of the capture before minutes of sampling.
void check_capture(const std::string& file) {
  if (file.empty()) return;
  if (!file.ends_with(".png") && !file.ends_with(".PNG"))
    throw usage_error(fmt::format("--capture: '{}' does not end in .png", file));
  check_writable(file);
}

}  // namespace

int run_view(const Options& options) {
  check_capture(options.capture);
  Interruption interruption;
  interruption.keep_what_there_is();
  ViewerStart start;
  start.loader = [options](Messages& messages, DisplaySettings& display) {
    OpenedScene opened = open_scene(options, messages);
    display = opened.display;
    return std::move(opened.scene);
  };
  start.render = options.render;
  start.fixed_size = options.size_given && options.capture.empty();
  start.display.tonemap = options.tonemap;
  start.display.ev = options.ev.value_or(0.0f);
  start.load = options.load;
  if (options.samples) start.sample_limit = *options.samples;
  if (options.capture.empty()) {
    run_window(std::move(start), interruption.token());
  } else {
    CaptureRequest request{options.capture};
    if (options.size_given) request.width = options.render.width, request.height = options.render.height;
    if (options.samples) request.samples = *options.samples;
    run_capture(std::move(start), request, interruption.token());
  }
  return static_cast<int>(interruption.requested() ? ExitCode::interrupted : ExitCode::ok);
}

}  // namespace halflight
