// A small toolkit for making the built-in scenes: shapes as triangle meshes with smooth normals and texture
// coordinates, placed into a Scene under a material. Lengths are the scene's; +y is up; fronts wind
// counter-clockwise.
#pragma once

#include <functional>
#include <span>
#include <string>

#include "scene/scene.h"

namespace halflight {

/// A shape in its own frame, without a material.
struct Mesh {
  std::vector<Vertex> vertices;
  std::vector<UVec3> triangles;
};

/// Adds a vertex without a normal; returns its index.
uint32_t add_vertex(Mesh&, Vec3 position, Vec2 uv = Vec2(0));

/// Appends `other`, moved by `transform`.
void append(Mesh&, const Mesh& other, const Mat4& transform = Mat4(1));

/// Normals from the faces, weighted by area. Vertices at the same position share a normal where theirs differ
/// by less than `crease` radians. Drops triangles without area.
void smooth_normals(Mesh&, float crease = 0.9f);

/// Moves every vertex by `displacement(position, normal, uv)` and makes the normals anew.
void displace(Mesh&, const std::function<Vec3(Vec3, Vec3, Vec2)>& displacement);

/// Grid over the unit square: (columns × rows) quads at `position(u, v)`, fronts on the side of ∂u × ∂v. A
/// side that closes on itself is made seamless by `wrap_u`, `wrap_v`. Texture coordinates are (u, v).
struct GridShape {
  int columns = 1, rows = 1;
  bool wrap_u = false, wrap_v = false;
};
Mesh grid_mesh(GridShape, const std::function<Vec3(float u, float v)>& position);

/// Rectangle from `corner` along two edges; the front is on the side of a × b. Texture coordinates are
/// lengths.
Mesh rectangle_mesh(Vec3 corner, Vec3 a, Vec3 b);

/// Box centred at the origin whose edges are rounded with `radius` in `segments` steps for a quarter (0:
/// sharp, 12 triangles). Texture coordinates are lengths, so that one material fits boxes of all sizes.
Mesh box_mesh(Vec3 size, float radius = 0, int segments = 1);

/// Superquadric with the given half axes: |x|^(2/e) + |z|^(2/e) in plan with e = `round`.y, upright with
/// `round`.x; 1 is an ellipsoid, towards 0 a box (Barr 1981).
Mesh superquadric_mesh(Vec3 half_axes, Vec2 round, int columns, int rows);

/// Surface of revolution about y of a profile of (radius, height); outside is to the right of the way up.
/// Corners sharper than `crease` radians stay sharp.
Mesh lathe_mesh(std::span<const Vec2> profile, int segments, float crease = 0.6f);

/// Catmull–Rom curve through the points, `steps` pieces between each two.
std::vector<Vec2> smooth_curve(std::span<const Vec2> points, int steps);
std::vector<Vec3> smooth_curve(std::span<const Vec3> points, int steps);

/// Round tube along a path, with flat ends; `radius(t)` for t in [0, 1] along the path.
Mesh tube_mesh(std::span<const Vec3> path, int sides, const std::function<float(float)>& radius);
Mesh tube_mesh(std::span<const Vec3> path, int sides, float radius);

/// Prism over a simple polygon in the xy plane (counter-clockwise), from z = 0 to z = depth, both ends
/// closed.
Mesh extrude_mesh(std::span<const Vec2> outline, float depth);

/// Picture-frame ring of four mitred pieces about an opening in the xy plane, its profile (distance outwards
/// from the opening, height along +z) swept around; a flat profile faces +z.
Mesh frame_mesh(Vec2 opening, std::span<const Vec2> profile);

Mat4 move(Vec3 by);
Mat4 turn(float radians, Vec3 axis);
Mat4 stretch(Vec3 factors);

/// Puts a mesh into the scene; a mirroring transform turns the winding over.
void place(Scene&, const Mesh&, uint32_t material, const Mat4& transform = Mat4(1));

uint32_t add_material(Scene&, Material);
/// A material of glTF's GGX that is no metal; `color` is linear.
Material plain_material(std::string name, Vec3 color, float roughness);
Material metal_material(std::string name, Vec3 color, float roughness);
/// A use of a new sRGB texture, scaled so that it repeats every `size` units of the texture coordinates.
TextureUse add_texture(Scene&, ImageRgba8, std::string name, Vec2 size);

/// Smooth noise in [-1, 1] with features of about one unit (lattice gradients, quintic fade: Perlin 2002).
float gradient_noise(Vec3 p, uint32_t seed = 0);
/// The same, repeating every `period` units in x and y.
float periodic_noise(Vec2 p, int period, uint32_t seed);
/// Sum of `octaves` noises, each twice as fine and half as strong; repeats every `period` units when period >
/// 0.
float fractal_noise(Vec2 p, int octaves, int period, uint32_t seed);

}  // namespace halflight
