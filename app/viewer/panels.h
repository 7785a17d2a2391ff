// The panels: they edit the state and report what they changed; they never render.
#pragma once

#include "viewer/render_thread.h"
#include "viewer/viewer_state.h"

namespace halflight {

inline constexpr float panel_width = 340;

/// Colours, spacing and font of the window. `scale` is the display's content scale.
void set_panel_style(float scale);

/// Width of the side panel in the window as it is now, points.
float side_panel_width();

/// Draws everything over the picture: the side panel, the status line, the help and dialogs. `snapshot` may
/// be null while the first scene loads. `now` is the window's clock in seconds.
Changes draw_panels(ViewerState&, const Snapshot* snapshot, bool loading, double now);

/// The keys, once: the help overlay and `view --help` read this.
struct KeyHelp {
  const char *key, *action;
};
std::span<const KeyHelp> key_help();

}  // namespace halflight
