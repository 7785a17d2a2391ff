// The one scene type: what the importers fill, and what the rays, the rasteriser and the light generators
// read. Geometry is flattened to world space at the chosen time, one vertex pool and one triangle list.
#pragma once

#include <string>
#include <vector>

#include "core/image.h"
#include "core/math.h"
#include "scene/environment.h"
#include "scene/material.h"

namespace halflight {

/// A vertex; 60 bytes, uploaded to the GPU as it is.
struct Vertex {
  Vec3 position;
  Vec3 normal;   ///< unit; made from the faces where the file has none
  Vec4 tangent;  ///< unit xyz, w = ±1 handedness; w = 0 where there is no tangent
  Vec2 uv[2];
  uint32_t color;  ///< RGBA8 linear vertex colour, multiplies the base colour
};

enum class PunctualKind : uint32_t { point, spot, directional };

/// A punctual light; KHR_lights_punctual's units. A projector is a spot with a picture.
struct PunctualLight {
  std::string name;
  PunctualKind kind = PunctualKind::point;
  Vec3 position{0};
  Vec3 direction{0, 0, -1};  ///< unit, the way the light travels
  Vec3 up{0, 1, 0};          ///< unit, orthogonal to direction: top of a projected picture
  Vec3 intensity{1};         ///< candela (point, spot), lux (directional); colour × intensity
  float range = infinity;    ///< KHR's smooth cut-off; infinity: none
  float inner_cone = 0, outer_cone = pi / 4;  ///< radians from the axis
  int32_t picture = -1;  ///< projector: index into Scene::pictures, over the square that holds the outer cone
};

enum class Projection : uint32_t { perspective, orthographic };

/// A camera: looks along −z of its frame, +y up, as glTF has it.
struct Camera {
  std::string name;
  Projection projection = Projection::perspective;
  Vec3 position{0};
  Vec3 right{1, 0, 0}, up{0, 1, 0}, back{0, 0, 1};  ///< orthonormal; view direction is −back
  float vertical_fov = pi / 4;                      ///< radians
  float half_height = 1;                            ///< orthographic: half of the height seen
  bool generated = false;                           ///< made by `complete_camera`, not by a file
};

/// Where the scene came from and what was made of it; printed by `info`.
struct SceneFacts {
  std::string source;                        ///< path or built-in name
  std::vector<std::string> extensions_used;  ///< of the file
  std::vector<std::string> ignored_extensions;
  size_t skipped_primitives = 0;  ///< points, lines, empty
  size_t skipped_triangles = 0;   ///< degenerate, or with a vertex that is not finite
  size_t animations = 0;          ///< of the file, posed once when it was read
  double at_seconds = 0;          ///< the moment they were posed at
  bool added_camera = false, added_sky = false, added_lamp = false;
};

struct Scene {
  std::vector<Vertex> vertices;
  std::vector<UVec3> triangles;
  std::vector<uint32_t> triangle_material;  ///< one a triangle
  std::vector<Material> materials;          ///< never empty when there are triangles
  std::vector<ImageRgba8> images;
  std::vector<Texture> textures;
  std::vector<ImageRgb> pictures;  ///< projectors' slides, linear
  std::vector<PunctualLight> lights;
  std::vector<Camera> cameras;  ///< at least one after `complete_camera`
  Environment environment;
  Aabb bounds;  ///< of the triangles
  SceneFacts facts;
};

/// Geometric normal (not unit; twice the area) by the winding.
inline Vec3 triangle_cross(const Scene& scene, uint32_t triangle) {
  const UVec3 t = scene.triangles[triangle];
  const Vec3 a = scene.vertices[t.x].position;
  return glm::cross(scene.vertices[t.y].position - a, scene.vertices[t.z].position - a);
}

/// How far a ray's origin is moved off the surface at `p`: a few units in the last place of the coordinates
/// there and in the scene, so that it scales with the scene and with its distance from the origin.
inline float surface_epsilon(const Scene& scene, Vec3 p) {
  const Vec3 extreme =
      scene.bounds.empty() ? Vec3(0) : glm::max(glm::abs(scene.bounds.low), glm::abs(scene.bounds.high));
  return 0x1p-19f * max_component(glm::abs(p)) + 0x1p-21f * max_component(extreme);
}

/// Recomputes `bounds` from the vertices that triangles use; empty where there is no triangle.
void update_bounds(Scene&);

}  // namespace halflight
