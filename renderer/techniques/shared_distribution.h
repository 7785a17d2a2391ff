// Neighbouring pixels that can draw from one distribution.
#pragma once

#include <array>

#include "lights/cut_importance.h"
#include "scene/gbuffer.h"

namespace halflight {

/// Whether any light can be reflected there.
bool reflects(const GBufferTexel&);

/// Whether a distribution made for one of two neighbouring points serves the other: on one plane, with
/// normals whose cosine is at least `least_cosine`, of like lobes.
bool alike(const GBufferTexel&, const GBufferTexel&, float least_cosine);

/// Points that share a distribution: one in their midst, and how far they lie around it.
struct SharedPoint {
  GBufferTexel texel;
  PointSpread spread;
};

/// Whose distribution the pixels of a 4×4 block draw from. It hangs on the G-buffer alone: the same for any
/// subset of the pixels that a pass visits.
class DistributionLeaders {
 public:
  static constexpr uint32_t side = 4, most = side * side, none = 0xffffffffu;

  explicit DistributionLeaders(const GBuffer& gbuffer) : gbuffer_(&gbuffer) {}

  /// The first pixel of `pixel`'s block that reflects light and whose distribution serves `pixel`:
  /// `serves(texel of one, texel of the other)`. Pixels that reflect nothing have themselves.
  template <class Serves>
  uint32_t of(uint32_t pixel, const Serves& serves) {
    if (const glm::uvec2 block = block_of(pixel); block != block_) {
      block_ = block;
      find(serves);
    }
    const glm::uvec2 place = position(pixel) % side;
    return leader_[place.y * side + place.x];
  }

  /// Those of the block that `of` was last asked about which draw with `leader`.
  SharedPoint shared(uint32_t leader) const;

  glm::uvec2 block_of(uint32_t pixel) const { return position(pixel) / side; }

 private:
  glm::uvec2 position(uint32_t pixel) const {
    const auto width = static_cast<uint32_t>(gbuffer_->width);
    return {pixel % width, pixel / width};
  }

  /// Of a place in the block; none beyond the picture.
  uint32_t pixel_at(uint32_t place) const {
    const auto width = static_cast<uint32_t>(gbuffer_->width),
               height = static_cast<uint32_t>(gbuffer_->height);
    const glm::uvec2 at = block_ * side + glm::uvec2(place % side, place / side);
    return at.x < width && at.y < height ? at.y * width + at.x : none;
  }

  template <class Serves>
  void find(const Serves& serves) {
    leader_.fill(none);
    std::array<uint32_t, most> found;
    size_t count = 0;
    for (uint32_t place = 0; place < most; ++place) {
      const uint32_t pixel = pixel_at(place);
      if (pixel == none) continue;
      const GBufferTexel& texel = gbuffer_->texels[pixel];
      leader_[place] = pixel;
      if (!reflects(texel)) continue;
      size_t i = 0;
      while (i < count && !serves(gbuffer_->texels[found[i]], texel)) ++i;
      if (i == count) found[count++] = pixel;
      leader_[place] = found[i];
    }
  }

  const GBuffer* gbuffer_;
  glm::uvec2 block_{none};
  std::array<uint32_t, most> leader_{};
};

}  // namespace halflight
