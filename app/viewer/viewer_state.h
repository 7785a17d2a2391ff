// What the window shows and edits: panels change it and say what changed; the viewer acts on that.
#pragma once

#include <string>

#include "session.h"

namespace halflight {

struct ViewerState {
  RenderSettings render;
  Camera camera;
  LightEdits lights;
  float ev = 0;
  std::string tonemap;
  bool show_panels = true, show_help = false, paused = false;
  std::string error_text;  ///< shown in a dialog until it is closed
  std::string toast;       ///< a short note at the bottom of the picture
  double toast_until = 0;  ///< seconds on the window's clock
};

/// What a frame's input changed.
struct Changes {
  bool settings = false, lights = false, camera = false, display = false, paused = false;
  bool screenshot = false, reset_camera = false, next_technique = false, quit = false;

  Changes& operator|=(const Changes& o) {
    settings |= o.settings, lights |= o.lights, camera |= o.camera, display |= o.display, paused |= o.paused;
    screenshot |= o.screenshot, reset_camera |= o.reset_camera, next_technique |= o.next_technique,
        quit |= o.quit;
    return *this;
  }
};

}  // namespace halflight
