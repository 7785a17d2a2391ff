// Shadow maps of the punctual lights: where each light looks from, and the drawing of what it sees. Spots,
// projectors and directional lights have one view each; point lights, and spots too wide for one plane, the
// six faces of a cube. Private to this folder.
#pragma once

#include <span>
#include <vector>

#include "raster/scene_upload.h"

namespace halflight {

/// The lights of a scene as the shaders read them, and the views they have.
struct LightViews {
  std::vector<gpu::GpuLight> lights;
  std::vector<gpu::GpuShadowView> views;
  uint32_t map_layers = 0, cube_layers = 0;  ///< of the two arrays
};

/// Where one of Scene::pictures lies in the buffer of all.
struct PictureSlot {
  uint32_t first_pixel, width, height;
};

LightViews make_light_views(const Scene&, const RasterSettings&, std::span<const PictureSlot>);

class ShadowMaps {
 public:
  /// Sizes that do not fit beside the rest are halved and named in `messages`.
  ShadowMaps(GlContextBase&, const Scene&, const RasterSettings&, Messages&);

  /// Draws all views of the scene's lights.
  void draw(const GpuScene&, const Scene&);

  size_t bytes() const;  ///< of their texels

  /// Draws them if a light's place differs from when they were drawn last.
  void draw_if_moved(const GpuScene&, const Scene&);

  /// Uploads the lights as they are now and binds all that punctual.glsl reads; sets its uniforms in
  /// `program`.
  void bind(const Scene&, const GlProgram& program);

 private:
  void upload_pictures(const Scene&, Messages&);
  void make_arrays(uint32_t map_layers, uint32_t cube_layers, Messages&);
  void draw_view(const GpuScene&, const gpu::GpuShadowView&);

  GlContextBase& context_;
  RasterSettings settings_;
  GlProgram opaque_;
  GlProgram alpha_tested_[2];  ///< without and with a base colour texture
  GlName maps_, cubes_, framebuffer_, lights_, views_, pictures_;
  uint32_t map_layers_ = 0, cube_layers_ = 0;
  std::vector<PictureSlot> picture_slots_;
  std::vector<PunctualLight> drawn_;
};

}  // namespace halflight
