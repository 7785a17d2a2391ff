// The G-buffer: drawn, read back, and kept on the GPU for the direct light. Private to this folder.
#pragma once

#include <map>

#include "raster/scene_upload.h"

namespace halflight {

/// Textures the G-buffer is drawn to, for one picture size; see GBUFFER_TARGETS in shaders/shared_layout.h.
struct GBufferTargets {
  int width = 0, height = 0;
  std::array<GlName, GBUFFER_TARGETS> colors;
  GlName depth, framebuffer;
  GlName read_back;  ///< pixel buffer all targets are copied to
};

/// Programs and targets; drawn with a StateGuard alive.
class GBufferPass {
 public:
  GBufferPass(GlContextBase&, const GpuScene&);

  /// Draws the scene and reads it back into `gbuffer` (whose size says the picture's).
  void draw(const GpuScene&, const Scene&, const Camera&, Vec2 jitter, uint32_t alpha_seed, GBuffer& gbuffer);

  const GBufferTargets& targets() const { return targets_; }
  /// The camera of the last `draw`.
  const Camera& camera() const { return camera_; }

 private:
  void make_targets(int width, int height);
  void draw_batches(const GpuScene&, const Mat4& projection, Vec2 jitter, uint32_t alpha_seed);
  void read_back(const Scene&, Vec2 jitter, GBuffer&);

  GlContextBase& context_;
  std::map<uint32_t, GlProgram> programs_;  ///< by alpha test and texture mask
  GBufferTargets targets_;
  Camera camera_;
};

/// Binds the G-buffer drawn last for a compute `program` that includes gbuffer_point.glsl and is in use.
void bind_gbuffer(const GlFunctions&, const GlProgram& program, const GpuScene&, const GBufferPass&);

/// Clip space from offsets to the eye in world axes: rows from the top, depth near/z (perspective) or 1 −
/// z/far (orthographic), so that floating point resolves every distance alike. `jitter` moves the sample
/// points, in pixels.
Mat4 raster_projection(const Camera&, const Aabb& bounds, int width, int height, Vec2 jitter);

}  // namespace halflight
