// GPU-based importance sampling (Colbert & Křivánek 2007, GPU Gems 3, chapter 20), on OpenGL.
//
//   L_o = E_d(n) ρ_d/π + (1/N) Σ_k L(u_k, l_k) f_s(u_k, v) cos θ_k / p(u_k, v)            (their eq. 2)
//
// The u_k are N Hammersley points sent through the inverse of the specular lobe's distribution, the same for
// all pixels. L(u, l) is the environment in scaled dual-paraboloid maps at the mip level that averages a
// sample's share of the sphere: l = max(0, ½ log2(wh/N) − ½ log2(p d)) + bias (eqs. 13 and 14). E_d comes
// from nine spherical harmonics. Biased: nothing casts a shadow or reflects light on something else, maps
// blur, harmonics ring; only the environment is light (punctual lights are those of the frame). Without the
// filter and with N → ∞ the specular part converges to unshadowed light of the maps.
#include <array>

#include "core/parallel.h"
#include "core/stopwatch.h"
#include "raster/rasterizer.h"
#include "techniques/technique.h"

namespace halflight {

namespace {

constexpr std::string_view on_off[] = {"off", "on"};
constexpr std::string_view map_sizes[] = {"64", "128", "256", "512", "1024"};
constexpr int least_map_size = 64;

constexpr std::array settings{
    SettingInfo{"filtered.filter", 1, 0, 1, "off: samples see single texels, as plain importance sampling",
                on_off},
    SettingInfo{"filtered.bias", 1, -16, 16, "added to the mip level, so that samples overlap"},
    SettingInfo{"filtered.map-size", 2, 0, 4, "texels along a side of either map of the environment",
                map_sizes},
};

class Filtered final : public Technique {
 public:
  void prepare(const FrameView& frame) override {
    HALFLIGHT_CHECK(frame.raster);
    if (frame.kinds.environment)
      frame.raster->prepare_filtered(least_map_size
                                     << static_cast<int>(frame.settings->get("filtered.map-size")));
    request_.filter = frame.settings->get("filtered.filter") != 0;
    request_.bias = static_cast<float>(frame.settings->get("filtered.bias"));
  }

  PassStats run_pass(const FrameView& frame, const PassRequest& request, Film& film) override {
    FilteredRequest wanted = request_;
    wanted.samples = request.samples, wanted.stride = request.stride, wanted.offset = request.offset;
    wanted.stop = request.stop;
    Stopwatch watch;
    PassStats stats;
    FilteredResult lit;
    if (frame.kinds.environment) {
      lit = frame.raster->filtered_light(*frame.gbuffer, wanted);
      stats.stages[Stage::gpu_environment].calls = 1;
    }
    stats.gpu_seconds = lit.gpu_seconds;
    stats.sampling_seconds = watch.lap() * thread_count();
    stats.finished = lit.finished;
    if (!lit.finished) return stats;
    stats.pixels = add_to_film(frame, request, lit.radiance, film);
    stats.resolve_seconds = watch.seconds() * thread_count();
    return stats;
  }

 private:
  /// The subset's pixels with their light, or with none where `radiance` is empty; returns their number. Both
  /// halves get the same, for there is no noise that they could tell.
  static uint64_t add_to_film(const FrameView& frame, const PassRequest& request,
                              const std::vector<Vec3>& radiance, Film& film) {
    const auto width = static_cast<uint32_t>(frame.gbuffer->width);
    const auto height = static_cast<uint32_t>(frame.gbuffer->height);
    const uint32_t first_x = request.offset % request.stride, first_y = request.offset / request.stride;
    const uint32_t columns = (width - std::min(first_x, width) + request.stride - 1) / request.stride;
    const uint32_t rows = (height - std::min(first_y, height) + request.stride - 1) / request.stride;
    const uint32_t second = request.samples / 2, first = request.samples - second;
    parallel_for(0, size_t{columns} * rows, 4096, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        const auto x = first_x + static_cast<uint32_t>(i % columns) * request.stride;
        const auto y = first_y + static_cast<uint32_t>(i / columns) * request.stride;
        const uint32_t pixel = y * width + x;
        Vec3 sum = (*frame.base)[pixel];
        if (!radiance.empty()) sum += frame.gbuffer->texels[pixel].throughput * radiance[i];
        film.add(pixel, 0, sum, first);
        if (second > 0) film.add(pixel, 1, sum, second);
      }
    });
    return uint64_t{columns} * rows;
  }

  FilteredRequest request_;
};

}  // namespace

TechniqueInfo filtered_technique() {
  TechniqueInfo info{"filtered",
                     "BRDF samples in filtered maps, on the GPU",
                     "Colbert & Křivánek 2007, GPU Gems 3 ch. 20",
                     TargetSupport::own,
                     Bias::biased,
                     settings,
                     []() -> std::unique_ptr<Technique> { return std::make_unique<Filtered>(); },
                     "biased: light of the environment only, without shadows; maps are blurred"};
  info.exact = true;
  info.device = Device::gpu;
  return info;
}

}  // namespace halflight
