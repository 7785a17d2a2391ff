// No light sampling at all: every pixel gets its base (emission seen, punctual light found by other stages).
// What it costs is what a frame and its harness cost under any technique.
#include "core/parallel.h"
#include "techniques/technique.h"

namespace halflight {

namespace {

class Null final : public Technique {
 public:
  PassStats run_pass(const FrameView& frame, const PassRequest& request, Film& film) override {
    const auto width = static_cast<uint32_t>(frame.gbuffer->width);
    const uint32_t first_x = request.offset % request.stride, first_y = request.offset / request.stride;
    const int half = request.half.value_or(static_cast<int>(request.pass & 1));
    parallel_for(0, static_cast<size_t>(frame.gbuffer->height), 8, [&](size_t begin, size_t end) {
      for (auto y = static_cast<uint32_t>(begin); y < end; ++y) {
        if (y % request.stride != first_y) continue;
        for (uint32_t x = first_x; x < width; x += request.stride)
          if (const uint32_t pixel = y * width + x; request.samples_pixel(pixel))
            film.add(pixel, half, (*frame.base)[pixel], request.samples_at(pixel));
      }
    });
    PassStats stats;
    stats.pixels = frame.gbuffer->pixel_count() / (request.stride * request.stride);
    return stats;
  }
};

}  // namespace

TechniqueInfo null_technique() {
  TechniqueInfo info{"null",
                     "Nothing: the cost of a frame without a technique",
                     "",
                     TargetSupport::both,
                     Bias::biased,
                     {},
                     []() -> std::unique_ptr<Technique> { return std::make_unique<Null>(); },
                     "leaves out all light that other techniques sample"};
  info.stages = reads_cut;
  info.hidden = true;
  return info;
}

}  // namespace halflight
