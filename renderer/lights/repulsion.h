// Pushing points apart over a surface (Turk 1991; Wang & Åkerlund §4).
#pragma once

#include <vector>

#include "scene/scene.h"
#include "scene/shading.h"

namespace halflight {

/// Moves each point away from its neighbours `steps` times; `spacing` is the distance evenly spread points
/// would have. Points on surfaces that face apart do not see each other. The same for any number of threads.
void repel(const Scene&, std::vector<SurfacePoint>& points, float spacing, int steps);

}  // namespace halflight
