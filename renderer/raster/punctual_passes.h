// Compute passes that light things by the punctual lights through their shadow maps. Private to this folder.
#pragma once

#include <span>
#include <vector>

#include "raster/gbuffer_pass.h"
#include "raster/shadow_maps.h"

namespace halflight {

class PunctualPasses {
 public:
  explicit PunctualPasses(GlContextBase&);

  /// Irradiance on both sides of each point: 2·i front, 2·i + 1 back.
  std::vector<Vec3> light_points(ShadowMaps&, const Scene&, std::span<const BouncePoint>);

  /// Adds Σ f · cos θ · E to each pixel of the G-buffer drawn last.
  void add_direct(ShadowMaps&, const GpuScene&, const Scene&, const GBufferPass&, std::span<Vec3> radiance);

 private:
  GlContextBase& context_;
  GlProgram points_, direct_;
};

}  // namespace halflight
