// Pushing points apart over a surface (Turk 1991; Wang & Åkerlund §4).
#pragma once

#include <span>
#include <vector>

#include "lights/point_grid.h"
#include "scene/scene.h"
#include "scene/shading.h"

namespace halflight {

/// Moves each point away from its neighbours `steps` times; `spacing` is the distance evenly spread points
/// would have; they stay on `triangles`. Points on surfaces that face apart do not see each other. The same
/// for any number of threads.
void repel(const Scene&, std::span<const uint32_t> triangles, std::vector<SurfacePoint>& points,
           float spacing, int steps);

/// Position and geometric normal of a point; normal 0 where the triangle has none.
PlacedPoint place_point(const Scene&, SurfacePoint);

}  // namespace halflight
