// What the built-in scenes of punctual lights, slides and glossy surfaces share. Lengths are the scene's.
#pragma once

#include <string>

#include "core/image.h"
#include "scene/mesh_builder.h"

namespace halflight {

/// Modified Phong of the given reflectances.
Material phong_material(std::string name, Vec3 diffuse, Vec3 specular, float exponent);

/// Adds a camera that looks from `eye` at `target`; `degrees` is its vertical field of view.
void add_camera(Scene&, std::string name, Vec3 eye, Vec3 target, float degrees);

/// A spot from `position` towards `target` whose cone ends at `outer_degrees` from the axis, sharply; the top
/// of its picture is up.
PunctualLight aimed_spot(std::string name, Vec3 position, Vec3 target, float outer_degrees, Vec3 candela);

/// Adds a spot that throws `slide`.
void add_projector(Scene&, PunctualLight spot, ImageRgb slide);

/// Height of the lowest vertex under `transform`: what has to be taken away for the mesh to stand at 0.
float lowest_point(const Mesh&, const Mat4& transform = Mat4(1));

/// Sets the tangents of a `lathe_mesh` along its circles (+v of its profile is then the bitangent).
void set_lathe_tangents(Mesh&);

/// Closed tube along a trefoil knot that lies in the xy plane and reaches 3 + `radius` from the origin.
Mesh trefoil_mesh(float radius, int along, int around);

}  // namespace halflight
