// What the camera sees at each pixel: the same data whether the rasteriser or the rays filled it.
#pragma once

#include <vector>

#include "core/math.h"
#include "scene/brdf.h"
#include "scene/scene.h"

namespace halflight {

inline constexpr uint32_t no_triangle = 0xffffffffu;

/// One pixel's surface. Where nothing was hit, `triangle` is `no_triangle` and `emission` is the environment's radiance.
struct GBufferTexel {
  Vec3 position{0};
  uint32_t triangle = no_triangle;
  Vec3 geometric_normal{0};  ///< unit, on the viewer's side
  uint32_t material = 0;
  Vec3 shading_normal{0};    ///< unit, on the viewer's side (dot with wo > 0)
  float time = 0;
  Vec3 tangent{0};           ///< unit, orthogonal to the shading normal: the BRDF's first axis
  Vec3 wo{0};                ///< unit, towards the camera
  Vec3 emission{0};          ///< radiance the surface itself sends to the camera
  Vec3 throughput{1};        ///< of what lies between camera and surface
  Brdf brdf;

  bool hit() const { return triangle != no_triangle; }
  Basis basis() const {
    return {tangent, glm::cross(shading_normal, tangent), shading_normal};
  }
};

/// Row-major from the top left.
struct GBuffer {
  int width = 0, height = 0;
  std::vector<GBufferTexel> texels;

  void resize(int w, int h) { width = w, height = h, texels.resize(static_cast<size_t>(w) * h); }
  size_t pixel_count() const { return texels.size(); }
};

}  // namespace halflight
