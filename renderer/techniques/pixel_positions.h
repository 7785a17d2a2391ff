// What the pixels of a tile see from several positions each: antialiasing for techniques that can use one
// distribution for all of them. Position 0 is the frame's G-buffer; the others are traced when asked for.
#pragma once

#include <span>
#include <vector>

#include "techniques/technique.h"

namespace halflight {

/// A surface seen through a pixel, and what the picture holds there without the technique's part. The texel
/// belongs to whoever tells of it.
struct SeenTexel {
  const GBufferTexel* texel = nullptr;
  Vec3 base{0};
};

/// One thread's. Allocates for its first tile and not after.
class PixelPositions {
 public:
  static constexpr uint32_t most = 16;

  /// `round` numbers the sets of positions: those of one round are spread evenly over a pixel, and so are
  /// those of successive rounds. Each position is uniform in its pixel over seeds. Without a camera or
  /// antialiasing there is but the one of the G-buffer.
  PixelPositions(const FrameView&, uint32_t round, uint32_t positions);

  uint32_t count() const { return positions_; }
  /// Finds what the pixels see. Valid until the next call.
  void look(std::span<const uint32_t> pixels, RayCounters&);
  /// `i`: place in the span of `look`.
  SeenTexel at(size_t i, uint32_t position) const;

 private:
  Vec2 place(uint32_t pixel, uint32_t position) const;

  const FrameView& frame_;
  uint32_t round_, positions_;
  std::span<const uint32_t> pixels_;
  std::vector<ClosestRay> rays_;
  std::vector<GBufferTexel> texels_;  ///< positions 1 and up of each pixel in turn
  std::vector<Vec3> base_;
};

}  // namespace halflight
