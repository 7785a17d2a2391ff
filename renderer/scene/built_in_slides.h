// Slides for the built-in scenes' projectors: linear, black outside of their figure.
#pragma once

#include "core/image.h"

namespace halflight {

/// A rose window of coloured glass between leads, transmittance up to 1.
ImageRgb rose_window_slide(int size);

/// A window of many panes at sunset: a banded sky and land of radiance about 1, a sun of `sun` times that.
ImageRgb sunset_window_slide(int size, float sun);

/// A lancet of stained glass: pointed, twice as high as wide, a lattice of lozenges within a border. `hue`
/// turns the palette.
ImageRgb lancet_slide(int size, int hue);

}  // namespace halflight
