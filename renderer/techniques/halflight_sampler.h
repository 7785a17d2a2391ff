// One thread's draws of `halflight`: pixels of a block, each seen from a few positions, share one
// distribution where they see the same surface; each pixel's light samples are stratified as a whole and
// dealt to its positions.
#pragma once

#include "techniques/connection_batch.h"
#include "techniques/learned_lights.h"
#include "techniques/learned_visibility.h"
#include "techniques/traced_loop.h"

namespace halflight {

struct HalflightParameters {
  float brdf_share, specular_share, alpha;
  bool share;               ///< one distribution for all that is alike in a block
  bool powers, visibility;  ///< whether rounds teach what strata send, and what arrives
  uint32_t position_samples;
  bool punctual_clusters;
  uint32_t environment_clusters;
  uint32_t pilot_rays, light_rays;
};

class HalflightSampler {
 public:
  HalflightSampler(const FrameView&, const PassRequest&, const HalflightParameters&, const LearnedLights&,
                   LearnedVisibility&);

  /// All draws of a tile's pixels, which lie along a Morton curve.
  void render(TracedWorker&, std::span<const uint32_t> pixels);

 private:
  static constexpr uint32_t block_side = 4;
  static constexpr size_t block_size = block_side * block_side;
  static constexpr uint32_t unset = 0xffffffffu;

  /// A pixel of the block from one position.
  struct View {
    uint32_t pixel;  ///< of the film
    uint32_t place;  ///< of the pixel in the block
    SeenTexel seen;
    std::array<uint32_t, 2> samples;  ///< for each half of the film
    bool narrow;
    uint32_t group;
  };
  /// Views that share a distribution, made for the first of them.
  struct Group {
    uint32_t leader, count;
  };

  glm::uvec2 block_of(uint32_t pixel) const;
  void look_at_block(TracedWorker&, std::span<const uint32_t> pixels, size_t first_in_tile);
  uint32_t group_of(const View&) const;
  void sort_by_group();
  void render_group(TracedWorker&, std::span<const View> views);
  void render_pixel(TracedWorker&, std::span<const View> views, float share, int half, RandomStream&);
  void share_out(std::span<const View> views, float share, int half, float phase);
  void draw_and_deal(size_t views, RandomStream&);
  void draw_view(TracedWorker&, const View&, size_t index, float share, int half, RandomStream&);
  void connect(TracedWorker&, int half, float expected_samples);
  void prepare_visibility(TracedWorker&, uint32_t pixel);
  bool build(const GBufferTexel&);
  float brdf_share(const GBufferTexel&) const;

  const FrameView& frame_;
  const PassRequest& request_;
  const HalflightParameters& parameters_;
  const LearnedLights& lights_;
  LearnedVisibility& visibility_;
  PixelPositions positions_;

  std::vector<View> views_, sorted_;
  std::vector<Group> groups_;
  std::vector<RandomStream> random_;  ///< of each pixel of the block

  CutDistribution distribution_;
  bool drawable_ = false;
  std::vector<float> guard_, arriving_, factor_;
  uint32_t tile_ = unset;  ///< that `factor_` is of
  std::span<VisibilityCount> counts_;

  // Of the pixel in hand: how many BRDF rays and light samples each of its views takes, where its draws
  // begin, and all draws, first along the tree and then view by view.
  std::array<uint32_t, PixelPositions::most> rays_{}, samples_{}, begin_{};
  std::vector<uint8_t> turns_;  ///< which view's turn it is
  std::vector<LightSample> draws_, dealt_;
  std::vector<DrawAllocation> allocations_;  ///< of the group's views; never grows while rays wait
  ConnectionBatch batch_;
};

/// Samples that position `position` of `positions` gets of `samples`.
uint32_t share_of_position(uint32_t samples, uint32_t position, uint32_t positions);

}  // namespace halflight
