// What all techniques that sum over members of S share: tiles, the two halves of the film, batches of shadow
// rays, timers.
#pragma once

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <concepts>
#include <utility>

#include "core/parallel.h"
#include "core/simd.h"
#include "lights/cut_distribution.h"
#include "lights/tile_cut.h"
#include "techniques/connection_batch.h"
#include "techniques/shared_distribution.h"
#include "techniques/technique.h"
#include "techniques/tile_clock.h"

namespace halflight {

/// Draws members of S at a pixel. `begin_pixel` makes the distribution; false: nothing can be drawn.
/// Independent calls of `draw` are independent given that distribution, and each weighs its draws so that
/// their mean estimates the sum over S.
template <class S>
concept LightSampler = requires(S& sampler, const GBufferTexel& texel, RandomStream& random,
                                std::span<LightSample> out) {
  { sampler.begin_pixel(texel, random) } -> std::same_as<bool>;
  sampler.draw(random, out);
};

/// A sampler that prepares for neighbouring pixels: `begin_group` gets their points.
template <class S>
concept PreparesGroups = requires(S& sampler, const PointGroup& points) {
  sampler.begin_group(points);
};

/// A sampler whose distribution for one point may serve some neighbours of it, too.
template <class S>
concept SharesDistributions = requires(S& sampler, const GBufferTexel& leader, const GBufferTexel& texel,
                                       const SharedPoint& point, RandomStream& random) {
  { sampler.shares() } -> std::same_as<bool>;
  { sampler.serves(leader, texel) } -> std::same_as<bool>;
  { sampler.begin_pixels(point, random) } -> std::same_as<bool>;
};

/// A sampler over a cut whose probabilities can be told.
template <class S>
concept HasPmf = LightSampler<S> && requires(const S& sampler) {
  { sampler.cut() } -> std::same_as<const Cut&>;
  { sampler.distribution() } -> std::same_as<const CutDistribution&>;
};

/// A sampler with stages of its own to account for: adds what it did to a pass's counters.
template <class S>
concept CountsStages = requires(const S& sampler, StageCounters& counters) {
  sampler.count_stages(counters);
};

/// How many of a pixel's samples each half of the film gets; without `samples`, of as many as a pass has.
std::array<uint32_t, 2> split_samples(const PassRequest&);
std::array<uint32_t, 2> split_samples(const PassRequest&, uint32_t samples);

/// One thread's part of a pass: gathers the draws of some neighbouring pixels, traces their rays together,
/// adds the result to the film. Allocates when made and not after.
class PixelWorker {
 public:
  /// With `exhaustive` the samples are summed instead of averaged, and both halves get the same sum.
  PixelWorker(const FrameView&, const PassRequest&, Film&, bool exhaustive);

  /// Starts a pixel that reflects light.
  void open(uint32_t pixel);
  /// A pixel that reflects none: it gets its base alone.
  void pass_by(uint32_t pixel);
  const GBufferTexel& texel() const { return *texel_; }

  /// Light of one member of S, shadowed when its ray has been traced.
  void add(const LightSample& sample, int half) {
    batch_.add(
        {&frame_.tree->lights[sample.light], sample.weight, 2 * open_count_ + static_cast<uint32_t>(half)});
    if (batch_.full()) connect();
  }

  /// After the last `add` of a pixel: makes the rays.
  void end_draws();
  /// Ends the pixel; traces when enough rays are waiting.
  void close();
  /// Traces what waits and adds all open pixels to the film.
  void finish();

  PassStats& stats() { return stats_; }

  TileClock clock;

 private:
  static constexpr uint32_t most_pixels = 64;
  // The longer a stream, the fuller its packets of one octant: 1024 rays take up to 2 % less than 512.
  static constexpr size_t enough_rays = 1024, most_rays = 2048;

  struct OpenPixel {
    uint32_t index;
    std::array<uint32_t, 2> samples;
    std::array<Vec3d, 2> sum;
  };
  struct Waiting {
    Vec3 value;     ///< f cos θ L Ω · weight
    uint32_t slot;  ///< 2 · open pixel + half
  };

  OpenPixel opened(uint32_t pixel);
  void connect();
  void trace();
  void add_to_film(const OpenPixel&);

  const FrameView& frame_;
  const PassRequest& request_;
  Film& film_;
  bool exhaustive_;
  GeometryTerm term_;

  const GBufferTexel* texel_ = nullptr;
  Basis basis_{};
  RayOrigin origin_;
  std::array<OpenPixel, most_pixels> open_;
  uint32_t open_count_ = 0;
  ConnectionBatch batch_;
  // The first `ray_count_` of each wait to be traced.
  std::vector<ShadowRay> rays_;
  std::vector<Waiting> waiting_;
  size_t ray_count_ = 0;

  PassStats stats_;
};

/// Pixels of a pass in tiles of 16×16 of its interleaved subset, along a Morton curve inside each.
class TileGrid {
 public:
  static constexpr uint32_t side = 16;

  /// The request must outlive it.
  TileGrid(const GBuffer&, const PassRequest&);
  uint32_t tile_count() const { return columns_ * rows_; }
  /// Writes the pixels of a tile; returns how many there are.
  uint32_t pixels(uint32_t tile, std::array<uint32_t, side * side>& out) const;

 private:
  const PassRequest& request_;
  uint32_t width_, height_, stride_, offset_x_, offset_y_, columns_, rows_;
};

/// Calls `begin_group` of whoever prepares for neighbouring pixels each time a pixel lies in another block of
/// 16×16 than the one before: the same blocks for any subset of the pixels, so that subsets make up a whole
/// pass.
class PixelGroups {
 public:
  explicit PixelGroups(const GBuffer& gbuffer) : gbuffer_(&gbuffer) {}

  template <class BeginGroup>
  void next(uint32_t pixel, const BeginGroup& begin_group) {
    const uint32_t width = static_cast<uint32_t>(gbuffer_->width);
    const glm::uvec2 block = glm::uvec2(pixel % width, pixel / width) / side;
    if (block == block_) return;
    block_ = block;
    if (const PointGroup points = points_of(block); !points.empty()) begin_group(points);
  }

 private:
  static constexpr uint32_t side = TileGrid::side;
  PointGroup points_of(glm::uvec2 block) const;

  const GBuffer* gbuffer_;
  glm::uvec2 block_{0xffffffffu};
};

/// Random numbers of a pixel in a pass; and those of a distribution made for it that others share.
RandomStream pixel_stream(const FrameView&, const PassRequest&, uint32_t pixel);
RandomStream distribution_stream(const FrameView&, const PassRequest&, uint32_t pixel);

/// Runs `render_tile(worker, sampler, pixels)` for each tile on all cores; workers and samplers are one a
/// thread.
template <class MakeSampler, class RenderTile>
PassStats run_tiles(const FrameView& frame, const PassRequest& request, Film& film, bool exhaustive,
                    const MakeSampler& make_sampler, const RenderTile& render_tile) {
  struct Local {
    PixelWorker worker;
    decltype(make_sampler()) sampler;
  };
  tbb::enumerable_thread_specific<Local> locals([&] {
    return Local{PixelWorker(frame, request, film, exhaustive), make_sampler()};
  });
  const TileGrid grid(*frame.gbuffer, request);
  parallel_for(0, grid.tile_count(), 1, [&](size_t begin, size_t end) {
    Local& local = locals.local();
    std::array<uint32_t, TileGrid::side * TileGrid::side> pixels;
    for (size_t tile = begin; tile < end; ++tile) {
      if (request.stop.stop_requested()) {
        local.worker.stats().finished = false;
        return;
      }
      const uint32_t count = grid.pixels(static_cast<uint32_t>(tile), pixels);
      local.worker.clock.begin();
      render_tile(local.worker, local.sampler, std::span<const uint32_t>(pixels.data(), count));
      local.worker.clock.end(local.worker.stats());
    }
  });
  PassStats stats;
  for (Local& local : locals) {
    stats += local.worker.stats();
    if constexpr (CountsStages<decltype(local.sampler)>) local.sampler.count_stages(stats.stages);
  }
  return stats;
}

/// One thread's sampler, and whose distribution it holds.
template <LightSampler Sampler>
class PixelSampler {
 public:
  /// Frame and request must outlive it.
  PixelSampler(const FrameView& frame, const PassRequest& request, Sampler its_sampler)
      : sampler(std::move(its_sampler)),
        frame_(frame),
        request_(request),
        groups_(*frame.gbuffer),
        leaders_(*frame.gbuffer) {}

  /// Calls `visit(pixel)` for each pixel, those of a block that share a distribution one after the other.
  template <class Visit>
  void in_turn(std::span<const uint32_t> pixels, TileClock& clock, const Visit& visit) {
    if (!shares()) {
      for (const uint32_t pixel : pixels) visit(pixel);
      return;
    }
    for (size_t begin = 0, end = 0; begin < pixels.size(); begin = end) {
      while (end < pixels.size() && leaders_.block_of(pixels[end]) == leaders_.block_of(pixels[begin])) ++end;
      std::array<std::pair<uint32_t, uint32_t>, DistributionLeaders::most> block;
      {
        const TickScope scope(clock.distribution);
        for (size_t i = begin; i < end; ++i) block[i - begin] = {leader_of(pixels[i]), pixels[i]};
        std::sort(block.begin(), block.begin() + (end - begin));
      }
      for (size_t i = 0; i < end - begin; ++i) visit(block[i].second);
    }
  }

  /// Makes the pixel's distribution, or keeps the one in hand where that is the pixel's. False: nothing can
  /// be drawn.
  bool begin(uint32_t pixel, RandomStream& random) {
    if constexpr (SharesDistributions<Sampler>) {
      if (shares()) {
        const uint32_t leader = leader_of(pixel);
        if (leader == leader_) return drawable_;
        leader_ = leader;
        RandomStream of_leader = distribution_stream(frame_, request_, leader);
        return drawable_ = sampler.begin_pixels(leaders_.shared(leader), of_leader);
      }
    }
    begin_group(pixel);
    return sampler.begin_pixel(frame_.gbuffer->texels[pixel], random);
  }

  void count_stages(StageCounters& counters) const {
    if constexpr (CountsStages<Sampler>) sampler.count_stages(counters);
  }

  Sampler sampler;

 private:
  void begin_group(uint32_t pixel) {
    if constexpr (PreparesGroups<Sampler>)
      groups_.next(pixel, [&](const PointGroup& points) { sampler.begin_group(points); });
  }

  bool shares() const {
    if constexpr (SharesDistributions<Sampler>)
      return sampler.shares();
    else
      return false;
  }

  uint32_t leader_of(uint32_t pixel) {
    begin_group(pixel);
    if constexpr (SharesDistributions<Sampler>)
      return leaders_.of(pixel, [&](const GBufferTexel& one, const GBufferTexel& other) {
        return sampler.serves(one, other);
      });
    else
      return pixel;
  }

  const FrameView& frame_;
  const PassRequest& request_;
  PixelGroups groups_;
  DistributionLeaders leaders_;
  uint32_t leader_ = DistributionLeaders::none;
  bool drawable_ = false;
};

/// Draws of a pixel, for each half of the film.
struct PixelDraws {
  uint32_t pixel = 0;
  bool waits = false;
  std::array<std::vector<LightSample>, 2> halves;
};

/// One thread's part of a pass of a technique that draws members of S. What a pixel drew lies scattered over
/// S, and memory is slow: it is asked for at once, and connected when the next pixel has drawn.
template <LightSampler Sampler>
class SampledPixels {
 public:
  SampledPixels(const FrameView& frame, const PassRequest& request, Sampler sampler)
      : frame_(frame), request_(request), sampler_(frame, request, std::move(sampler)) {
    const std::array<uint32_t, 2> split = split_samples(request);
    for (PixelDraws& draws : draws_)
      for (int half = 0; half < 2; ++half) draws.halves[half].reserve(split[half]);
  }

  void render(PixelWorker& worker, std::span<const uint32_t> pixels) {
    sampler_.in_turn(pixels, worker.clock, [&](uint32_t pixel) { draw(worker, pixel); });
    connect(worker, draws_[1 - turn_]);
    worker.finish();
  }

  void count_stages(StageCounters& counters) const { sampler_.count_stages(counters); }

 private:
  void draw(PixelWorker& worker, uint32_t pixel) {
    if (!reflects(frame_.gbuffer->texels[pixel])) return worker.pass_by(pixel);
    RandomStream random = pixel_stream(frame_, request_, pixel);
    if (!begin(worker, pixel, random)) {
      worker.open(pixel);
      return worker.close();
    }
    PixelDraws& drawn = draws_[turn_];
    drawn.pixel = pixel, drawn.waits = true;
    const std::array<uint32_t, 2> split = split_samples(request_, request_.samples_at(pixel));
    for (int half = 0; half < 2; ++half) {
      std::vector<LightSample>& draws = drawn.halves[half];
      draws.resize(split[half]);
      if (!draws.empty()) sampler_.sampler.draw(random, draws);
      for (const LightSample& draw : draws) prefetch_whole(frame_.tree->lights[draw.light]);
    }
    turn_ = 1 - turn_;
    connect(worker, draws_[turn_]);
  }

  bool begin(PixelWorker& worker, uint32_t pixel, RandomStream& random) {
    const TickScope scope(worker.clock.distribution);
    return sampler_.begin(pixel, random);
  }

  void connect(PixelWorker& worker, PixelDraws& drawn) {
    if (!drawn.waits) return;
    drawn.waits = false;
    worker.open(drawn.pixel);
    // Both halves run along the leaves: side by side their rays stay in the order of the tree.
    const size_t most = std::max(drawn.halves[0].size(), drawn.halves[1].size());
    for (size_t j = 0; j < most; ++j)
      for (int half = 0; half < 2; ++half)
        if (j < drawn.halves[half].size()) worker.add(drawn.halves[half][j], half);
    worker.end_draws();
    worker.close();
  }

  const FrameView& frame_;
  const PassRequest& request_;
  PixelSampler<Sampler> sampler_;
  std::array<PixelDraws, 2> draws_;
  int turn_ = 0;  ///< whose draws are made next; the other's may wait
};

/// A pass of a technique that draws members of S.
template <LightSampler Sampler, class MakeSampler>
PassStats run_sampler_pass(const FrameView& frame, const PassRequest& request, Film& film,
                           const MakeSampler& make_sampler) {
  return run_tiles(
      frame, request, film, false, [&] { return SampledPixels<Sampler>(frame, request, make_sampler()); },
      [](PixelWorker& worker, SampledPixels<Sampler>& state, std::span<const uint32_t> pixels) {
        state.render(worker, pixels);
      });
}

/// `Technique::inspect` of a sampler over the cut.
template <HasPmf Sampler>
PixelInspection inspect_sampler(Sampler sampler, const FrameView& frame, const PassRequest& request,
                                uint32_t pixel) {
  PixelInspection result;
  result.probability.assign(frame.tree->lights.size(), 0.0);
  result.weight.assign(frame.tree->lights.size(), 0.0f);
  RandomStream random = pixel_stream(frame, request, pixel);
  PixelSampler<Sampler> state(frame, request, std::move(sampler));
  if (!state.begin(pixel, random)) return result;
  const Cut& cut = state.sampler.cut();
  const CutDistribution& distribution = state.sampler.distribution();
  for (uint32_t k = 0; k < cut.size; ++k) {
    for (uint32_t i = cut.begin[k]; i < cut.end[k]; ++i) {
      result.probability[i] = distribution.probability(cut, k, i);
      if (result.probability[i] > 0) result.weight[i] = distribution.weight(cut, k, i);
    }
  }
  result.draws.resize(request.samples);
  state.sampler.draw(random, result.draws);
  return result;
}

}  // namespace halflight
