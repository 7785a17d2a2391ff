// Draws a window's content: textured, coloured triangles with scissors, over the picture. Works in any of our
// contexts, on screen or into an image. Knows no user-interface library; no OpenGL type leaves it.
#pragma once

#include <memory>
#include <span>

#include "core/image.h"
#include "raster/rasterizer.h"

namespace halflight {

/// A corner of a triangle: position in points, texture coordinates, RGBA8 colour.
struct UiVertex {
  Vec2 position, uv;
  uint32_t color;
};

/// Triangles that share texture and scissor.
struct UiCommand {
  Vec2 clip_low, clip_high;  ///< points
  uint32_t texture;          ///< as returned by `add_texture` or `set_texture`
  uint32_t first_index, index_count, base_vertex;
};

struct UiMesh {
  std::span<const UiVertex> vertices;
  std::span<const uint16_t> indices;
  std::span<const UiCommand> commands;
};

class UiPainter {
 public:
  explicit UiPainter(GlContext&);
  ~UiPainter();

  /// Makes a texture (`id` 0) or replaces one; returns its id, never 0.
  uint32_t set_texture(uint32_t id, const ImageRgba8&);

  // One picture of the window, kept by the painter for the viewer.
  void set_picture(const ImageRgba8& image) { picture_ = set_texture(picture_, image); }
  void* picture() const { return reinterpret_cast<void*>(static_cast<uintptr_t>(picture_)); }

  /// Draws meshes over a clear ground into the window (`target` null) or into `target`, which has the pixels'
  /// size. `size` is the display's size in points, `pixels` in pixels.
  void draw(std::span<const UiMesh> meshes, Vec2 size, glm::ivec2 pixels, ImageRgba8* target);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  uint32_t picture_ = 0;
};

}  // namespace halflight
