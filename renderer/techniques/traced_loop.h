// What techniques share that follow rays from a pixel: how a pixel's draws are shared out among the ways of
// drawing, the balance heuristic over them, and batches of shadow rays in two stages: from the pixel's point,
// and from surfaces that return light to it.
#pragma once

#include <array>

#include "techniques/learned_lights.h"
#include "techniques/learned_visibility.h"
#include "techniques/pixel_loop.h"
#include "techniques/pixel_positions.h"
#include "techniques/traced_light.h"

namespace halflight {

/// The ways to draw a direction at a pixel. BRDF rays find environment, emitters and surfaces alike; each of
/// the others finds one kind of light. Punctual light is drawn in one way only.
enum class DrawKind : size_t { brdf, environment, emitters, surfaces, punctual };
inline constexpr size_t draw_kind_count = 5;

/// How a pixel's draws are shared out. Each kind of draw with a share gets a fixed number where that is at
/// least one for all; else which kinds go without is left to chance, and the weights know the expected
/// numbers only.
class DrawAllocation {
 public:
  using Shares = std::array<double, draw_kind_count>;

  DrawAllocation() = default;
  /// `shares` are in proportion; all 0 draws nothing.
  DrawAllocation(const Shares& shares, uint32_t samples);

  /// `brdf_rays` BRDF rays beside `light_samples` draws that find light of every kind.
  static DrawAllocation of_rays_and_samples(float brdf_rays, float light_samples);

  /// n of the balance heuristic.
  float expected(DrawKind kind) const { return expected_[static_cast<size_t>(kind)]; }
  /// How many draws of each kind a pixel takes; `u` uniform in [0, 1).
  std::array<uint32_t, draw_kind_count> counts(float u) const;

 private:
  std::array<float, draw_kind_count> expected_{};
  std::array<double, draw_kind_count + 1> prefix_{};
};

/// 1 over (n + m q/p), which is the balance heuristic's weight over n: `n` draws with density `p` beside `m`
/// with density `q` (Křivánek eq. 18, Veach & Guibas 1995).
inline float balance_over_n(float n, float p, float m, float q) {
  return 1 / (n + (m > 0 && q > 0 ? m * (q / p) : 0.0f));
}

/// Which BRDF value a BRDF ray carries.
enum class BrdfEstimator { whole, chosen_lobe };

struct TracedParameters {
  DrawAllocation::Shares shares{};
  BrdfEstimator brdf_estimator =
      BrdfEstimator::whole;  ///< chosen_lobe: only without light samples of what it finds
};

/// Where light samples come from a distribution over strata: what it is at the pixel in hand.
struct StrataDensity {
  const LearnedLights* lights = nullptr;
  const CutDistribution* distribution = nullptr;  ///< over the lights' cut; null: no light samples

  /// Density per area (at infinity, per solid angle) with which light samples fall there.
  float of(const std::optional<LearnedLights::Met>& met) const {
    if (!met || !distribution) return 0;
    const uint32_t cluster = lights->cluster_of(met->leaf);
    if (cluster == LearnedLights::none) return 0;
    return static_cast<float>(distribution->probability(lights->cut(), cluster, met->leaf)) / met->measure;
  }
};

/// One thread's part of a pass. Allocates when made and not after.
class TracedWorker {
 public:
  /// `samples`: draws of each half of the film in one call of `draw`.
  TracedWorker(const FrameView&, const PassRequest&, Film&, const LightSources&, const TracedParameters&,
               std::array<uint32_t, 2> samples);

  /// Starts a pixel as the frame's G-buffer has it. False: no light can be reflected there, and the pixel has
  /// got its base alone.
  bool open(uint32_t pixel);
  /// Starts a pixel as it is seen from some position, with what each half's samples there count.
  bool open(uint32_t pixel, const SeenTexel&, std::array<uint32_t, 2> samples);
  /// Adds what the picture holds without the technique's part.
  void add_base(uint32_t pixel, const SeenTexel&, std::array<uint32_t, 2> samples);
  const GBufferTexel& texel() const { return *texel_; }
  const Basis& basis() const { return basis_; }
  const RayOrigin& origin() const { return origin_; }

  /// All draws of a half: adds `scale` times an estimate of the pixel's light of `frame.kinds`.
  void draw(int half, RandomStream&, float scale = 1);
  /// BRDF rays alone, weighed beside light samples from strata. They are traced later: the allocation must
  /// stay, and the distribution until `trace_brdf_rays`.
  void draw_brdf(int half, uint32_t count, const DrawAllocation&, const StrataDensity&, RandomStream&);
  /// Traces the BRDF rays that wait.
  void trace_brdf_rays();
  /// `value` is added where nothing blocks the ray; `visibility`, where given, learns whether it arrived.
  void add_ray(const ShadowRay&, Vec3 value, int half, VisibilityCount* visibility = nullptr);

  /// Ends the pixel; traces when enough rays are waiting.
  void close();
  /// Traces what waits and adds all open pixels to the film.
  void finish();

  PassStats& stats() { return stats_; }

  TileClock clock;

 private:
  static constexpr uint32_t most_pixels = 64;
  static constexpr size_t enough_rays = 512, most_rays = 1024, most_brdf_rays = 128;
  static constexpr uint32_t no_bounce = 0xffffffffu;

  struct OpenPixel {
    uint32_t index;
    std::array<uint32_t, 2> samples;
    Vec3 base, throughput;
    std::array<Vec3d, 2> sum;
  };
  struct Waiting {
    Vec3 value;
    uint32_t slot;                ///< 2 · open pixel + half
    uint32_t bounce;              ///< what to light when the ray arrives, instead of adding the value
    VisibilityCount* visibility;  ///< what learns of it, or null
  };
  struct WaitingBounce {
    BouncePlace place;
    uint64_t key;  ///< of its random numbers
  };

  /// A drawn direction, f cos θ/p of it, and what it met.
  struct BrdfRay {
    Vec3 wi;
    float pdf;
    Vec3 reflected;
    uint32_t slot;  ///< 2 · open pixel + half
    uint64_t key;   ///< of the random numbers at what it meets
    const DrawAllocation* allocation;
    RayHit hit;
  };

  void draw_brdf_rays(uint32_t count, RandomStream&);
  void push_brdf_ray(const BrdfRay&);
  void add_environment_met(const BrdfRay&);
  void add_hit(const BrdfRay&);
  MetLight environment_met(const BrdfRay&) const;
  MetLight emission_met(const BrdfRay&) const;
  float surface_pdf(const BrdfRay&, const BouncePlace&) const;
  float weigh(const BrdfRay&, float light_pdf, DrawKind) const;
  void draw_environment(uint32_t count, RandomStream&);
  void draw_emitters(uint32_t count, RandomStream&);
  void draw_surfaces(uint32_t count, RandomStream&);
  void draw_punctual(uint32_t count, RandomStream&);
  void add_light_sample(const IncidentSample&, DrawKind);
  void add_surface_sample(SurfacePoint, RandomStream&);
  void push(const ShadowRay&, Vec3 value, uint32_t bounce, VisibilityCount* visibility = nullptr);
  void light_bounce(const BouncePlace&, Vec3 value, uint32_t slot, uint64_t key);
  void trace_first();
  void trace_second();
  template <class Arrive>
  void trace(std::vector<ShadowRay>& rays, Arrive&& arrive);
  void add_to_film(const OpenPixel&);
  float expected(DrawKind kind) const { return allocation_->expected(kind); }

  const FrameView& frame_;
  const PassRequest& request_;
  Film& film_;
  const LightSources& lights_;
  BrdfEstimator brdf_estimator_;
  std::array<uint32_t, 2> split_;
  std::array<DrawAllocation, 2> allocations_;

  const GBufferTexel* texel_ = nullptr;
  Basis basis_{};
  RayOrigin origin_;
  // Of the draws in hand.
  const DrawAllocation* allocation_ = nullptr;
  StrataDensity strata_;  ///< without lights: light samples come from the sources themselves
  float scale_ = 1;
  uint32_t slot_ = 0;

  std::array<OpenPixel, most_pixels> open_;
  uint32_t open_count_ = 0;
  std::vector<BrdfRay> brdf_rays_;  ///< not traced yet
  std::vector<ClosestRay> closest_;
  std::vector<ShadowRay> rays_, bounce_rays_;
  std::vector<Waiting> waiting_, bounce_waiting_;
  std::vector<WaitingBounce> bounces_;

  PassStats stats_;
};

/// Runs `render_tile(worker, pixels)` for each tile on all cores, with workers one a thread.
template <class MakeWorker, class RenderTile>
PassStats run_traced_tiles(const FrameView& frame, const PassRequest& request, const MakeWorker& make_worker,
                           const RenderTile& render_tile) {
  tbb::enumerable_thread_specific<TracedWorker> workers(make_worker);
  const TileGrid grid(*frame.gbuffer, request);
  parallel_for(0, grid.tile_count(), 1, [&](size_t begin, size_t end) {
    TracedWorker& worker = workers.local();
    std::array<uint32_t, TileGrid::side * TileGrid::side> pixels;
    for (size_t tile = begin; tile < end; ++tile) {
      if (request.stop.stop_requested()) {
        worker.stats().finished = false;
        return;
      }
      const uint32_t count = grid.pixels(static_cast<uint32_t>(tile), pixels);
      worker.clock.begin();
      render_tile(worker, std::span<const uint32_t>(pixels.data(), count));
      worker.finish();
      worker.clock.end(worker.stats());
    }
  });
  PassStats stats;
  for (TracedWorker& worker : workers) stats += worker.stats();
  return stats;
}

/// The same, calling `render_pixel(worker, pixel, random)` for each pixel that reflects light.
template <class MakeWorker, class RenderPixel>
PassStats run_traced_pixels(const FrameView& frame, const PassRequest& request, const MakeWorker& make_worker,
                            const RenderPixel& render_pixel) {
  return run_traced_tiles(frame, request, make_worker,
                          [&](TracedWorker& worker, std::span<const uint32_t> pixels) {
                            for (const uint32_t pixel : pixels) {
                              if (!worker.open(pixel)) continue;
                              RandomStream random = pixel_stream(frame, request, pixel);
                              render_pixel(worker, pixel, random);
                              worker.close();
                            }
                          });
}

/// A pass in which each pixel takes the request's draws once.
PassStats run_traced_pass(const FrameView&, const PassRequest&, Film&, const LightSources&,
                          const TracedParameters&);

}  // namespace halflight
