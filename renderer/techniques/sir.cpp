// Sampling importance resampling: Burke et al. 2005, "Bidirectional Importance Sampling for Direct
// Illumination"; Talbot et al. 2005; as raced by Wang & Åkerlund 2009, §5.
//
// M initial members X_j of S come from `illumination` with its P; each gets the weight w_j = Y(c_j)/P(X_j), Y
// the luminance and c_j = f cos θ L Ω the light X_j sends without visibility: as P ∝ Φ, this is f cos θ at
// infinity, and f cos θ with the geometry term nearby. N of them, chosen ∝ w_j by stratified numbers, are
// traced:
//   (1/N) Σ_s c_s V_s/Y(c_s) · (1/M) Σ_j w_j.
// Given the initial set its mean is (1/M) Σ_j c_j V_j/P(X_j): unbiased for the sum over S. Each half of the
// film has an initial set of its own, M shared out between those that get samples, so that the halves are
// independent.
#include "lights/leaf_table.h"
#include "techniques/illumination.h"
#include "techniques/pixel_loop.h"

namespace halflight {

namespace {

constexpr std::array settings{
    SettingInfo{"sir.initial", 800, 1, 65536, "initial samples a pixel, M, that are resampled"},
};

class SirSampler {
 public:
  SirSampler(const FrameView& frame, const PassRequest& request, const LeafTable& illumination)
      : frame_(&frame), illumination_(&illumination) {
    const auto initial = static_cast<size_t>(frame.settings->get("sir.initial"));
    const std::array<uint32_t, 2> split = split_samples(request);
    const size_t each = split[0] > 0 && split[1] > 0 ? (initial + 1) / 2 : initial;
    initial_.resize(each);
    sum_.reserve(each);
  }

  bool begin_pixel(const GBufferTexel& texel, RandomStream&) {
    texel_ = &texel, basis_ = texel.basis();
    return illumination_->drawable();
  }

  void draw(RandomStream& random, std::span<LightSample> out) {
    illumination_->draw(random, initial_);
    weigh();
    resample(random, out);
  }

 private:
  void weigh();
  void resample(RandomStream&, std::span<LightSample> out) const;

  const FrameView* frame_;
  const LeafTable* illumination_;
  const GBufferTexel* texel_ = nullptr;
  Basis basis_{};
  ConnectionBatch batch_;
  std::vector<LightSample> initial_;  ///< of one half of the film
  std::vector<double> sum_;           ///< running sum of the initial samples' w
};

/// w of all initial samples, summed up.
void SirSampler::weigh() {
  const std::vector<VirtualLight>& lights = frame_->tree->lights;
  const GeometryTerm term = frame_->geometry_term();
  sum_.resize(initial_.size());
  double sum = 0;
  for (size_t first = 0; first < initial_.size(); first += ConnectionBatch::capacity) {
    const size_t count = std::min(ConnectionBatch::capacity, initial_.size() - first);
    for (size_t i = 0; i < count; ++i) prefetch_whole(lights[initial_[first + i].light]);
    for (size_t i = 0; i < count; ++i) {
      const LightSample& sample = initial_[first + i];
      batch_.add({&lights[sample.light], sample.weight});
    }
    batch_.connect(*frame_->scene, *texel_, basis_, term);
    for (size_t i = 0; i < count; ++i) {
      const float w = luminance(batch_.value(i));
      if (batch_.matters[i] > 0 && w > 0) sum += std::min(w, std::numeric_limits<float>::max());
      sum_[first + i] = sum;
    }
    batch_.size = 0;
  }
}

void SirSampler::resample(RandomStream& random, std::span<LightSample> out) const {
  const double total = sum_.back(), mean = total / static_cast<double>(sum_.size());
  const double step = total / static_cast<double>(out.size());
  size_t j = 0;
  for (size_t s = 0; s < out.size(); ++s) {
    if (!(total > 0)) {  // nothing of the initial set sends light
      out[s] = {initial_[0].light, 0};
      continue;
    }
    const double jitter = static_cast<double>(random.next_bits() >> 11) * 0x1p-53;
    const double target = std::min((static_cast<double>(s) + jitter) * step, std::nextafter(total, 0.0));
    while (sum_[j] <= target) ++j;
    const double w = sum_[j] - (j > 0 ? sum_[j - 1] : 0.0);
    out[s] = {initial_[j].light, static_cast<float>(initial_[j].weight * (mean / w))};
  }
}

class Sir final : public Technique {
 public:
  void prepare(const FrameView& frame) override {
    CutDistribution over_cut;
    const bool drawable = build_illumination(*frame.cut, over_cut);
    illumination_.build(*frame.cut, over_cut, static_cast<uint32_t>(frame.tree->lights.size()), drawable);
  }

  PassStats run_pass(const FrameView& frame, const PassRequest& request, Film& film) override {
    return run_sampler_pass<SirSampler>(frame, request, film,
                                        [&] { return SirSampler(frame, request, illumination_); });
  }

 private:
  LeafTable illumination_;
};

}  // namespace

TechniqueInfo sir_technique() {
  return {"sir",
          "Light, resampled by the BRDF",
          "Burke et al. 2005; Wang & Åkerlund 2009, §5",
          TargetSupport::both,
          Bias::unbiased,
          settings,
          []() -> std::unique_ptr<Technique> { return std::make_unique<Sir>(); },
          "unbiased for the sum over S",
          reads_cut};
}

}  // namespace halflight
