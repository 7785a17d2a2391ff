#include <imgui.h>

#include <chrono>
#include <thread>

#include "core/stopwatch.h"
#include "film/image_writers.h"
#include "viewer/ui_frame.h"
#include "viewer/viewer.h"

namespace halflight {

void run_capture(ViewerStart start, const CaptureRequest& request, std::stop_token stop) {
  // The panels need OpenGL even where the picture comes from rays.
  const Backend backend = start.render.backend == Backend::none ? Backend::automatic : start.render.backend;
  auto context = GlContext::make_headless(backend);
  UiPainter painter(*context);
  UiContext ui(painter, 1);
  start.sample_limit = request.samples;
  Viewer viewer(std::move(start), painter);
  viewer.show_help(request.help);

  ImGuiIO& io = ImGui::GetIO();
  io.DisplaySize = {static_cast<float>(request.width), static_cast<float>(request.height)};
  io.DeltaTime = 1.0f / 30;
  const Stopwatch clock;
  // The picture follows the window's size half a second in; then it converges to the limit.
  int settled_frames = 0;
  while (settled_frames < 3 && !stop.stop_requested()) {
    ImGui::NewFrame();
    viewer.frame(clock.seconds());
    ImGui::Render();
    const bool done =
        viewer.snapshot() && viewer.snapshot()->converged && !viewer.loading() && viewer.picture_fits();
    settled_frames = done ? settled_frames + 1 : 0;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  if (!viewer.snapshot()) return;  // stopped before there was anything
  ImageRgba8 frame;
  ui.draw({request.width, request.height}, &frame);
  write_png(request.path, frame, {});
}

}  // namespace halflight
