// From options to the scene every command works on.
#pragma once

#include "film/image_writers.h"
#include "options.h"

namespace halflight {

/// A loaded scene with what the options add to it; the camera asked for comes first.
struct OpenedScene {
  Scene scene;
  DisplaySettings display;
  double seconds = 0;  ///< it took
};

/// Loads the scene, then applies --view, --environment… and --camera, later ones winning. Throws Error as
/// `load_scene` does, and with exit code 2 for an unknown camera.
OpenedScene open_scene(const Options&, Messages&);

/// Index of the camera of that name, or at that place. Throws Error (exit code 2).
size_t find_camera(const Scene&, const std::string& name_or_index);

}  // namespace halflight
