// Multiple importance sampling of light and BRDF: Křivánek, "Image-based direct illumination", §4; Veach &
// Guibas 1995.
//
// Discrete target: of N draws n_l come from `illumination` with its P_l(i), n_b from `brdf` with its P_b(i),
// and each, whichever made it, is weighed with the balance heuristic: Σ f cos θ L Ω V/(n_l P_l + n_b P_b).
// Unbiased for the sum over S: every lit member has P_l > 0, and the expected number of draws of i is what i
// is divided by. Continuous target: mis_traced.h.
#include "techniques/brdf_cut.h"
#include "techniques/illumination.h"
#include "techniques/inspect_leaves.h"
#include "techniques/mis_traced.h"

namespace halflight {

namespace {

constexpr std::array settings{
    SettingInfo{"mis.brdf-share", 0.5, 0, 1, "share of samples that follow the BRDF (see brdf.*)"},
    SettingInfo{"mis.strategy", 0, 0, 2, "both, or one parent alone", mis_strategy_names},
};

/// What all pixels share.
struct MisTables {
  BrdfCut brdf;
  CutDistribution illumination;
  std::vector<uint32_t> cluster;  ///< of each leaf
  double brdf_share = 0;
  bool drawable = false;
};

class MisSampler {
 public:
  MisSampler(const FrameView& frame, const MisTables& tables)
      : cut_(frame.cut), tables_(&tables), brdf_(tables.brdf.sampler()) {}

  void count_stages(StageCounters& counters) const { brdf_.count_stages(counters); }

  bool begin_pixel(const GBufferTexel& texel, RandomStream& random) {
    has_brdf_ = tables_->drawable && tables_->brdf_share > 0 && brdf_.begin_pixel(texel, random);
    return tables_->drawable;
  }

  void draw(RandomStream& random, std::span<LightSample> out) {
    const auto n = static_cast<uint32_t>(out.size());
    const uint32_t n_b = brdf_count(n);
    parts_.resize(std::max<size_t>(parts_.size(), n));
    const std::span<LightSample> by_brdf(parts_.data(), n_b), by_light(parts_.data() + n_b, n - n_b);
    if (n_b > 0) brdf_.draw(random, by_brdf);
    if (n > n_b) tables_->illumination.draw(*cut_, random, by_light);
    std::merge(by_brdf.begin(), by_brdf.end(), by_light.begin(), by_light.end(), out.begin(),
               [](const LightSample& a, const LightSample& b) { return a.light < b.light; });
    for (LightSample& sample : out) sample.weight = weight_of(probability(sample.light, n));
  }

  /// (n_l P_l + n_b P_b)/n.
  double probability(uint32_t leaf, uint32_t n) const {
    const uint32_t k = tables_->cluster[leaf];
    if (k >= cut_->size) return 0;
    const double share = static_cast<double>(brdf_count(n)) / n;
    double p = share < 1 ? (1 - share) * tables_->illumination.probability(*cut_, k, leaf) : 0.0;
    if (share > 0) p += share * brdf_.distribution().probability(tables_->brdf.cut, k, leaf);
    return p;
  }

 private:
  uint32_t brdf_count(uint32_t n) const {
    return has_brdf_ ? static_cast<uint32_t>(tables_->brdf_share * n) : 0;
  }

  const Cut* cut_;
  const MisTables* tables_;
  CountedCut brdf_;
  bool has_brdf_ = false;
  std::vector<LightSample> parts_;
};

MisStrategy strategy_of(const SettingValues& values) {
  return static_cast<MisStrategy>(static_cast<int>(values.get("mis.strategy")));
}

/// Share of the draws that follow the BRDF in the discrete target.
double brdf_share_of(const SettingValues& values) {
  const MisStrategy strategy = strategy_of(values);
  return strategy == MisStrategy::both ? values.get("mis.brdf-share") : strategy == MisStrategy::brdf ? 1 : 0;
}

StageSet own_stages(const SettingValues& values, Target target, const LightKinds& kinds) {
  if (target == Target::continuous)
    return StageSet().add(Stage::traced_brdf_rays,
                          mis_shares(kinds, strategy_of(values), values.get("mis.brdf-share"))[0] > 0);
  return StageSet()
      .add(Stage::cut)
      .add(Stage::counted_brdf_rays, brdf_share_of(values) > 0 && values.get("brdf.brdf-samples") > 0);
}

class Mis final : public Technique {
 public:
  void prepare(const FrameView& frame) override {
    if (frame.target == Target::continuous) return traced_.prepare(frame);
    tables_.brdf = {};
    if (brdf_share_of(*frame.settings) > 0) tables_.brdf.prepare(frame);
    tables_.drawable = build_illumination(*frame.cut, tables_.illumination);
    tables_.brdf_share = brdf_share_of(*frame.settings);
    tables_.cluster.assign(frame.tree->lights.size(), frame.cut->size);
    for (uint32_t k = 0; k < frame.cut->size; ++k)
      std::fill(tables_.cluster.begin() + frame.cut->begin[k], tables_.cluster.begin() + frame.cut->end[k],
                k);
  }

  PassStats run_pass(const FrameView& frame, const PassRequest& request, Film& film) override {
    if (frame.target == Target::continuous) return traced_.run_pass(frame, request, film);
    return run_sampler_pass<MisSampler>(frame, request, film, [&] { return MisSampler(frame, tables_); });
  }

  void count_held(const FrameView& frame, StageCounters& counters) const override {
    if (frame.target == Target::discrete) tables_.brdf.count_held(frame, counters);
  }

  std::optional<PixelInspection> inspect(const FrameView& frame, const PassRequest& request,
                                         uint32_t pixel) override {
    if (frame.target == Target::continuous) return std::nullopt;
    MisSampler sampler(frame, tables_);
    return inspect_leaves(sampler, frame, request, pixel);
  }

 private:
  MisTables tables_;
  MisTraced traced_;
};

}  // namespace

TechniqueInfo mis_technique() {
  return {"mis",
          "Light and BRDF, balance heuristic",
          "Křivánek, §4; Veach & Guibas 1995",
          TargetSupport::both,
          Bias::unbiased,
          settings,
          []() -> std::unique_ptr<Technique> { return std::make_unique<Mis>(); },
          "unbiased for the sum over S or the integral",
          own_stages,
          true};
}

}  // namespace halflight
