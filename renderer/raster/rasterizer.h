// OpenGL: contexts, G-buffer, shadow maps and the lighting of surface points. No GL type leaves this folder.
#pragma once

#include <functional>
#include <memory>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

#include "core/errors.h"
#include "lights/light_points.h"
#include "scene/camera.h"
#include "scene/gbuffer.h"

namespace halflight {

/// Where pixels of the G-buffer come from. `automatic`: rays on a software rasteriser, OpenGL on a real GPU.
enum class Backend { automatic, window, egl, osmesa, none };

struct GlDescription {
  std::string backend, renderer, version;
  bool software = false;  ///< llvmpipe, softpipe or swrast
};

/// An OpenGL core context, 4.3 or later with ARB_clip_control, current on the thread that made it. Several
/// may live at once.
class GlContext {
 public:
  /// Throws Error (exit code 4) naming what was tried and why it failed. `automatic` tries EGL (GPUs first),
  /// then OSMesa; `window` makes a hidden GLFW window.
  static std::unique_ptr<GlContext> make_headless(Backend);
  /// Wraps a context that is current and stays so (a GLFW window's); `get_proc` finds its functions. Throws
  /// Error (exit code 4) where it will not do.
  static std::unique_ptr<GlContext> adopt(void* (*get_proc)(const char*));
  virtual ~GlContext() = default;

  const GlDescription& description() const { return description_; }

 protected:
  GlDescription description_;
};

struct RasterSettings {
  int shadow_map_size = 2048;  ///< spots, projectors and directional lights
  int shadow_cube_size = 1024;
};

/// One pass of filtered importance sampling over every `stride`-th pixel in x and y (see `PassRequest`).
struct FilteredRequest {
  uint32_t samples = 40;
  bool filter = true;  ///< false: every sample is looked up in the full map
  float bias = 1;      ///< added to the mip level
  uint32_t stride = 1, offset = 0;
  std::stop_token stop{};
};

struct FilteredResult {
  std::vector<Vec3> radiance;  ///< of the subset's pixels, row by row; 0 where nothing reflects
  double gpu_seconds = 0;
  bool finished = true;  ///< false when stopped early: the radiances are good for nothing
};

/// A scene on the GPU. Keeps references to the context and the scene. Its functions make the context current
/// on the calling thread, leave its state as they found it, and throw Error: exit code 4 where OpenGL runs
/// out of memory or its context is lost (the caller may go on with rays), else 1.
class Rasterizer {
 public:
  /// Uploads geometry, materials and textures. Out of memory halves the textures and says so in `messages`,
  /// which must outlive this.
  Rasterizer(GlContext&, const Scene&, const RasterSettings&, Messages&);
  ~Rasterizer();

  /// Draws and reads back the G-buffer; same meaning of `jitter` and `alpha_seed` as `trace_gbuffer`.
  void draw_gbuffer(const Camera&, Vec2 jitter, uint32_t alpha_seed, GBuffer&);

  /// Takes the scene's material parameters again (not their textures).
  void update_materials();

  /// Draws the shadow maps of all punctual lights; call again when a light's place changes. They are made
  /// when first asked for.
  void update_shadow_maps();
  void drop_shadow_maps();
  size_t shadow_map_bytes() const;

  /// Irradiance from the punctual lights on both sides of each point (2·i front, 2·i + 1 back), all in one
  /// dispatch. Here and below, shadow maps are drawn first where a light's place is not the one they show.
  std::vector<Vec3> light_points(const std::vector<BouncePoint>&);

  /// D_punctual of the G-buffer drawn last, by shadow maps: f · cos θ · E, added to `radiance` (one a pixel).
  void add_punctual(const GBuffer&, std::vector<Vec3>& radiance);

  /// Makes maps of the environment of `map_size`² texels (a power of two) for `filtered_light`, unless they
  /// stand.
  void prepare_filtered(int map_size);
  void drop_filtered();
  size_t filtered_bytes() const;

  /// Light of the environment, unshadowed, on the G-buffer drawn last (GPU Gems 3, chapter 20); the maps are
  /// those of the last `prepare_filtered`, which must have been called.
  FilteredResult filtered_light(const GBuffer&, const FilteredRequest&);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace halflight
