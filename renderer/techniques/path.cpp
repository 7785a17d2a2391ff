// Path tracing (Kajiya 1986, "The Rendering Equation") with light samples and BRDF rays under the balance
// heuristic (Veach & Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering").
//
//   L = L_e(seen) + Σ_k Π_{j≤k} (f cos θ / p)_j w_k L_e,k + Π_{j<k} (f cos θ / p)_j D_k
//
// over the surfaces k = 0, 1 … of a path: L_e,k is what the BRDF ray of surface k meets, and D_k the light of
// a direction of the environment, a point of an emitter and punctual lights there; w_k weighs the two.
//
// Unbiased for the picture of the continuous target by default: emission seen, direct light, and one bounce
// from surfaces that return albedo/π. With path.bounces and path.model: unbiased for more bounces, or for
// whole BRDFs at them.
//
// It is the truth that the other techniques are tested against, and so has nothing of theirs: no S, no
// G-buffer, none of their light tables. Each path has its own place in the pixel and its own hash of what
// blends let through.
#include <mutex>

#include "core/errors.h"
#include "core/parallel.h"
#include "core/stopwatch.h"
#include "techniques/path_tracer.h"

namespace halflight {

namespace {

constexpr std::array<std::string_view, 2> model_names{"lambert", "whole"};

constexpr std::array settings{
    SettingInfo{"path.bounces", 1, 0, 64, "surfaces at most between the one that is seen and a light"},
    SettingInfo{"path.model", 0, 0, 1,
                "what those surfaces return: their albedo evenly, or by their whole BRDF", model_names},
};

/// The film's pixels that a pass covers.
struct PixelSubset {
  uint32_t width, height, stride, first_x, first_y;

  PixelSubset(const Film& film, const PassRequest& request)
      : width(static_cast<uint32_t>(film.width())),
        height(static_cast<uint32_t>(film.height())),
        stride(request.stride),
        first_x(request.offset % request.stride),
        first_y(request.offset / request.stride) {}

  uint32_t columns() const { return width > first_x ? (width - first_x + stride - 1) / stride : 0; }
  uint32_t rows() const { return height > first_y ? (height - first_y + stride - 1) / stride : 0; }
  uint32_t x(size_t column) const { return first_x + static_cast<uint32_t>(column) * stride; }
  uint32_t y(size_t row) const { return first_y + static_cast<uint32_t>(row) * stride; }
};

StageSet own_stages(const SettingValues&, Target, const LightKinds& kinds) {
  return StageSet().add(Stage::traced_brdf_rays, kinds.any());
}

class Path final : public Technique {
 public:
  void prepare(const FrameView& frame) override {
    lights_ = std::make_unique<PathLights>(*frame.scene);
    settings_.bounces = static_cast<int>(frame.settings->get("path.bounces"));
    settings_.model = static_cast<PathModel>(static_cast<int>(frame.settings->get("path.model")));
    settings_.light = frame.light;
  }

  PassStats run_pass(const FrameView& frame, const PassRequest& request, Film& film) override {
    HALFLIGHT_CHECK(frame.camera);
    Stopwatch watch;
    const PixelSubset subset(film, request);
    PassStats stats;
    std::mutex mutex;
    parallel_for(0, subset.rows(), 1, [&](size_t begin, size_t end) {
      PathTracer tracer(*frame.rays, *lights_, settings_, request.watch_rays);
      PassStats local;
      for (size_t row = begin; row < end; ++row) {
        if (request.stop.stop_requested()) {
          local.finished = false;
          break;
        }
        for (uint32_t column = 0; column < subset.columns(); ++column) {
          const uint32_t x = subset.x(column), y = subset.y(row);
          if (!request.samples_pixel(y * subset.width + x)) continue;
          render_pixel(frame, request, x, y, tracer, film);
          ++local.pixels;
        }
      }
      local.rays = tracer.counters();
      local.useful_rays = tracer.useful_rays();
      local.stages[Stage::traced_brdf_rays].calls = tracer.brdf_rays();
      std::lock_guard lock(mutex);
      stats += local;  // whole numbers: the order does not matter
    });
    stats.stages[Stage::antialiasing].calls = 1;
    stats.sampling_seconds = watch.seconds() * thread_count();
    return stats;
  }

 private:
  static void render_pixel(const FrameView& frame, const PassRequest& request, uint32_t x, uint32_t y,
                           PathTracer& tracer, Film& film) {
    constexpr uint64_t own_numbers = 0x70617468;  // other techniques draw from the same seeds
    const uint32_t pixel = y * static_cast<uint32_t>(film.width()) + x;
    const uint32_t count = request.samples_at(pixel);
    // Unless one half takes all, each takes its part.
    std::array<uint32_t, 2> samples{count - count / 2, count / 2};
    if (request.half) samples[*request.half] = count, samples[1 - *request.half] = 0;
    RandomStream random(pixel, request.pass, hash_combine(frame.seed, own_numbers));
    for (int half = 0; half < 2; ++half) {
      if (samples[half] == 0) continue;
      Vec3d sum(0);
      for (uint32_t i = 0; i < samples[half]; ++i) {
        const Vec2 place = Vec2(x, y) + random.next2();
        const CameraRay ray = camera_ray(*frame.camera, place, film.width(), film.height());
        sum += tracer.trace(ray, static_cast<uint32_t>(random.next_bits()), random);
      }
      film.add(pixel, half, Vec3(sum / static_cast<double>(samples[half])), samples[half]);
    }
  }

  std::unique_ptr<PathLights> lights_;
  PathSettings settings_;
};

}  // namespace

TechniqueInfo path_technique() {
  TechniqueInfo info{"path",
                     "Paths from the camera",
                     "Kajiya 1986; Veach & Guibas 1995",
                     TargetSupport::continuous,
                     Bias::unbiased,
                     settings,
                     []() -> std::unique_ptr<Technique> { return std::make_unique<Path>(); },
                     "unbiased for the integral; more bounces and whole BRDFs at them by settings"};
  info.stages = own_stages;
  info.leaves_s_when_continuous = true;
  info.traces_from_camera = true;
  return info;
}

}  // namespace halflight
