// Brute force over all of S: what Wang & Åkerlund §5 measure against. One ray to every lit member from every
// pixel, so the discrete sum is exact and a second pass changes nothing.
#include "core/parallel.h"
#include "techniques/pixel_loop.h"

namespace halflight {

namespace {

class Reference final : public Technique {
 public:
  PassStats run_pass(const FrameView& frame, const PassRequest& request, Film& film) override {
    const std::vector<VirtualLight>& lights = frame.tree->lights;
    const auto render_tile = [&](PixelWorker& worker, const int&, std::span<const uint32_t> pixels) {
      for (const uint32_t pixel : pixels) {
        // A pixel is long work here; one left out keeps what it has.
        if (request.stop.stop_requested()) break;
        if (!reflects(frame.gbuffer->texels[pixel])) {
          worker.pass_by(pixel);
          continue;
        }
        worker.open(pixel);
        for (uint32_t i = 0; i < lights.size(); ++i)
          if (leaf_power(lights[i]) > 0) worker.add({i, 1.0f}, 0);
        worker.end_draws();
        worker.close();
      }
      worker.finish();
      if (request.stop.stop_requested()) worker.stats().finished = false;
    };
    return run_tiles(
        frame, request, film, true, [] { return 0; }, render_tile);
  }
};

}  // namespace

TechniqueInfo reference_technique() {
  TechniqueInfo info{"reference",
                     "Brute force over all of S",
                     "Wang & Åkerlund 2009, §5",
                     TargetSupport::discrete,
                     Bias::unbiased,
                     {},
                     []() -> std::unique_ptr<Technique> { return std::make_unique<Reference>(); },
                     "unbiased, and without noise: the exact sum over S"};
  info.exact = true;
  return info;
}

}  // namespace halflight
