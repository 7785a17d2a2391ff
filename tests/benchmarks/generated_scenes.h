// Scenes of any number of triangles, made on the spot: the benchmarks need no file that is not in the
// project.
#pragma once

#include "scene/mesh_builder.h"

namespace halflight {

/// A (2, 3) torus knot about the origin that fits a ball of radius 1, its tube ribbed so that the triangles
/// are not all alike; about `triangles` of them, with smooth normals and texture coordinates.
Mesh knot_mesh(size_t triangles);

/// How a scene comes to its triangles.
enum class Growth { mesh, instances };

/// A closed room of 4 × 3 × 4 with a lamp below the ceiling (an emitter), a camera, and a glossy knot that
/// brings about `triangles` triangles: one mesh, or copies of a knot of 5,000 in a block of their own.
Scene knot_room(size_t triangles, Growth);

/// The room without the knot: walls, lamp and camera.
Scene empty_room();

/// The knot alone under no light of its own, seen by no camera: what opens gets a frame and a sky.
Scene bare_knot(size_t triangles);

}  // namespace halflight
