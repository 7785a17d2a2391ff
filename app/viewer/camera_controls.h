// Mouse to camera: pure functions, so that they can be tested without a window.
#pragma once

#include "scene/camera.h"

namespace halflight {

/// Turns about `pivot`: a drag across the height of the view is half a turn.
Camera orbit_by_drag(const Camera&, Vec3 pivot, Vec2 pixels, int view_height);

/// Moves sideways so that a point at the pivot's depth stays under the pointer.
Camera pan_by_drag(const Camera&, Vec3 pivot, Vec2 pixels, int view_height);

/// Moves towards the pivot (away for negative clicks); never reaches it. An orthographic view widens instead.
Camera zoom_by_wheel(const Camera&, Vec3 pivot, float clicks);

}  // namespace halflight
