// A scene as the shaders read it: triangles sorted into draws, materials, textures. Private to this folder.
#pragma once

#include <array>
#include <vector>

#include "raster/gl_objects.h"
#include "shared_layout.h"

namespace halflight {

/// Triangles drawn together: same textures, and vertices within one range of the vertex buffer.
struct DrawBatch {
  uint32_t first_triangle = 0, triangle_count = 0;  ///< in the sorted order
  uint32_t first_vertex = 0;  ///< of the range the shaders see; a multiple of `vertex_step`
  bool alpha_test = false;
  std::array<int32_t, MATERIAL_TEXTURES> images{};  ///< index into Scene::images by slot, or -1

  bool operator==(const DrawBatch&) const = default;
};

/// Bit `slot` for each texture the batch looks up.
uint32_t texture_mask(const DrawBatch&);

/// Ranges of storage buffers start at multiples of 256 bytes at most: 64 vertices of 60 bytes are 15 · 256.
inline constexpr uint32_t vertex_step = 64;

/// Triangles in the order they are drawn: opaque ones first, then by textures.
struct DrawList {
  std::vector<UVec3> indices;     ///< vertices of each sorted triangle
  std::vector<glm::uvec2> facts;  ///< its index in Scene::triangles, its material
  std::vector<DrawBatch> batches;
  uint32_t opaque_triangles = 0;  ///< the first so many need no alpha test
};

/// Sorts the scene's triangles into batches none of which spans more than `vertex_window` vertices.
/// Throws Error (no_gl) where one triangle does.
DrawList make_draw_list(const Scene&, size_t vertex_window);

/// The scene's materials as the shaders read them.
std::vector<gpu::GpuMaterial> make_gpu_materials(const Scene&);

/// Half the size (rounded up) by averaging 2 × 2 texels as they are stored.
ImageRgba8 halve(const ImageRgba8&);

/// What the passes draw from.
struct GpuScene {
  GlName vertices, indices, triangles, materials, srgb_table, vertex_array, white;
  GlName triangle_materials;   ///< by index into Scene::triangles
  std::vector<GlName> images;  ///< by index into Scene::images; 0 where no material in use looks one up
  DrawList draws;              ///< its indices and facts are on the GPU only
  size_t vertex_bytes = 0, vertex_window_bytes = 0;
};

/// Uploads; textures that do not fit are halved and named in `messages`. Throws Error (no_gl) when the rest
/// does not.
GpuScene upload_scene(GlContextBase&, const Scene&, Messages&);

/// Takes the parameters of the materials from the scene again.
void update_gpu_materials(GlContextBase&, const Scene&, GpuScene&);

/// Binds what every draw of the scene reads.
void bind_scene(const GlFunctions&, const GpuScene&);

/// Draws one batch with `program`, which is in use; binds its textures and its range of the vertices.
void draw_batch(const GlFunctions&, const GpuScene&, const GlProgram& program, const DrawBatch&);

}  // namespace halflight
