// The window's behaviour without the window: reads snapshots, handles input through ImGui, draws picture and
// panels.
#pragma once

#include <memory>
#include <stop_token>
#include <string>

#include "raster/ui_painter.h"
#include "viewer/panels.h"
#include "viewer/render_thread.h"
#include "viewer/viewer_state.h"

namespace halflight {

/// How a viewer starts.
struct ViewerStart {
  SceneLoader loader;
  RenderSettings render;
  bool fixed_size = false;       ///< keep render.width × height; otherwise the picture follows the window
  uint32_t sample_limit = 4096;  ///< a pixel; then the machine rests
  DisplaySettings display;
  LoadOptions load;
};

class Viewer {
 public:
  Viewer(ViewerStart, UiPainter&);

  /// One frame between ImGui::NewFrame and ImGui::Render; `now` is the window's clock in seconds.
  void frame(double now);

  // What ImGui does not carry.
  void key(
      char key);  ///< one of the letters of `key_help`, upper case; ' ' , '[' , ']' , '\t' and '\x1b' too
  void drop(const std::string& path);

  bool wants_to_close() const { return closing_; }
  std::string title() const;
  const Snapshot* snapshot() const { return snapshot_.get(); }
  /// The picture has the size the window asks for.
  bool picture_fits() const;
  bool loading() const { return render_.busy_loading(); }
  void show_help(bool show) { state_.show_help = show; }

 private:
  void take_snapshot(double now);
  void take_notices(double now);
  void draw_picture();
  Changes move_camera();
  void act(const Changes&, double now);
  void follow_window(double now);
  void save_screenshot(double now);
  void toast(const std::string& text, double now);

  ViewerStart start_;
  UiPainter& painter_;
  ViewerState state_;
  RenderThread render_;
  std::shared_ptr<const Snapshot> snapshot_;
  Changes from_keys_;
  bool picture_is_stale_ = true, closing_ = false;
  uint64_t scene_number_ = 0;
  double resized_at_ = -1;
};

/// Opens a window and runs until it is closed or a stop is requested. Throws Error (exit code 4) where no
/// window can be had.
void run_window(ViewerStart, std::stop_token);

/// Draws the window's content without one until `samples` a pixel are there, or a stop is requested, and
/// writes it as a PNG.
struct CaptureRequest {
  std::string path;
  int width = 1280, height = 720;
  uint32_t samples = 16;
  bool help = false;
};
void run_capture(ViewerStart, const CaptureRequest&, std::stop_token);

}  // namespace halflight
