// Bidirectional importance sampling: Wang & Åkerlund 2009, §3.3. The cut's importances times an estimate of
// the BRDF's share in each cluster, from counting BRDF rays that meet its box.
//
// form = repaired (default): unbiased for the sum over S.
//   q̂_k = l_k [k_s ŝ_k + (k_d/π) cos θ_k Ω_k], ŝ_k = (N_k + τ g_k)/(N_ρ + τ), g_k > 0 the lobe's analytic
//   mass in the cluster; a ray that meets m boxes adds 1/m to each; q = (1 − α) q̂/Σq̂ + α u, u_k ∝ Φ_k/(r_k² +
//   R_k²); leaves ∝ Φ_i.
// form = printed: eq. 9 as it stands, ρ_k = |k_s| r² N_k/(A_k N_ρ) + |k_d| cos θ_k, leaves alike. Biased: a
// cluster that no
//   ray met has probability 0 where k_d = 0, and so has one whose centre lies below the horizon.
#include "core/parallel.h"
#include "techniques/counted_cut.h"
#include "techniques/pixel_loop.h"

namespace halflight {

namespace {

enum class Form { repaired, printed };
constexpr std::array<std::string_view, 2> form_names{"repaired", "printed"};

// In the continuous target nothing bounds what a near point sends, and what one pixel's distribution misses
// of it for another makes the tails heavier.
enum class Share { never, discrete, always };
constexpr std::array<std::string_view, 3> share_names{"never", "discrete", "always"};

constexpr std::array settings{
    SettingInfo{"bidirectional.form", 0, 0, 1,
                "repaired is unbiased; printed is the paper's eq. 9 as it stands", form_names},
    SettingInfo{"bidirectional.brdf-samples", 64, 0, RayBundle::capacity, "counting rays a pixel, N_ρ"},
    SettingInfo{"bidirectional.tau", 16, 0, 1e6, "weight of the analytic estimate, in rays"},
    SettingInfo{"bidirectional.alpha", 0.05, 0, 1, "share of draws that ignore the BRDF"},
    SettingInfo{"bidirectional.share", 1, 0, 2,
                "whether what is alike in 4×4 pixels draws from one distribution: never, in the discrete "
                "target alone, always",
                share_names},
    SettingInfo{"bidirectional.near", 0.5, 0, 1e6,
                "clusters that reach further than this share of their distance are split; 0: none"},
};

constexpr std::array<std::pair<std::string_view, std::string_view>, 2> draft_values{
    {{"bidirectional.near", "0"}, {"bidirectional.brdf-samples", "0"}}};

struct Parameters {
  Form form;
  Share share;
  CountedCutParameters counting;
  float near;

  explicit Parameters(const SettingValues& values)
      : form(static_cast<Form>(static_cast<int>(values.get("bidirectional.form")))),
        share(static_cast<Share>(static_cast<int>(values.get("bidirectional.share")))),
        counting{static_cast<uint32_t>(values.get("bidirectional.brdf-samples")),
                 static_cast<float>(values.get("bidirectional.tau")),
                 static_cast<float>(values.get("bidirectional.alpha"))},
        near(static_cast<float>(values.get("bidirectional.near"))) {}

  CountedCut sampler(const FrameView& frame) const {
    CountedCutParameters its = planned(frame, counting);
    its.share = share == Share::always || (share == Share::discrete && frame.target == Target::discrete);
    return near > 0 && frame.runs(Stage::near_clusters) ? CountedCut(*frame.tree, *frame.cut, its, near)
                                                        : CountedCut(*frame.cut, its);
  }
};

StageSet own_stages(const SettingValues& values, Target, const LightKinds&) {
  const Parameters parameters(values);
  return StageSet()
      .add(Stage::cut)
      .add(Stage::counted_brdf_rays, parameters.counting.ray_count > 0)
      .add(Stage::near_clusters, parameters.near > 0 && parameters.form == Form::repaired);
}

class PrintedSampler {
 public:
  PrintedSampler(const FrameView& frame, const CountedCutParameters& counting)
      : cut_(*frame.cut),
        total_lights_(frame.tree->lights.size()),
        ray_count_(planned(frame, counting).ray_count) {}

  bool begin_pixel(const GBufferTexel&, RandomStream&);
  void draw(RandomStream& random, std::span<LightSample> out) const { distribution_.draw(cut_, random, out); }
  const CutDistribution& distribution() const { return distribution_; }
  const Cut& cut() const { return cut_; }
  void count_stages(StageCounters& counters) const {
    counters[Stage::counted_brdf_rays].calls += counted_rays_;
  }

 private:
  const Cut& cut_;
  size_t total_lights_;
  uint32_t ray_count_;
  CutDistribution distribution_;
  ClusterCounter counter_;
  RayBundle rays_;
  uint64_t counted_rays_ = 0;
};

bool PrintedSampler::begin_pixel(const GBufferTexel& texel, RandomStream& random) {
  const std::span<float> importance = distribution_.importance(cut_);
  const float diffuse = luminance(texel.brdf.diffuse), specular = luminance(texel.brdf.specular);
  // p ∝ |C_k| l_k ρ_k for a cluster; the diffuse term first.
  const auto weight = [&](uint32_t k) {
    return cut_.radiance[k] * static_cast<float>(cut_.end[k] - cut_.begin[k]);
  };
  const auto towards = [&](uint32_t k) {
    return Vec3(cut_.centre_x[k], cut_.centre_y[k], cut_.centre_z[k]) - cut_.local[k] * texel.position;
  };
  for (uint32_t k = 0; k < cut_.size; ++k) {
    const Vec3 to = towards(k);
    const float length = glm::length(to);
    const float cosine = length > 0 ? std::max(0.0f, glm::dot(texel.shading_normal, to) / length) : 0.0f;
    importance[k] = weight(k) * diffuse * cosine;
  }
  if (ray_count_ > 0 && texel.brdf.has_specular()) {
    shoot_lobe_rays(texel, ray_count_, random, rays_);
    counted_rays_ += ray_count_;
    const float rays = static_cast<float>(ray_count_);
    for (const auto& [k, hits] : counter_.count(cut_, texel.position, {}, rays_, CountRule::whole)) {
      const Vec3 to = towards(k);
      // Eq. 6: Ω_k = |C_k| 4π/|S| at infinity, A_k/r² elsewhere and a hemisphere at most.
      const float omega =
          cut_.local[k] == 0
              ? static_cast<float>(cut_.end[k] - cut_.begin[k]) * 4 * pi / static_cast<float>(total_lights_)
              : std::min(cut_.measure[k] / std::max(glm::dot(to, to), 1e-36f), 2 * pi);
      if (omega > 0) importance[k] += weight(k) * specular * hits / (omega * rays);
    }
  }
  return distribution_.build(cut_, {}, 0, LeafRule::uniform);
}

class Bidirectional final : public Technique {
 public:
  PassStats run_pass(const FrameView& frame, const PassRequest& request, Film& film) override {
    const Parameters parameters(*frame.settings);
    if (parameters.form == Form::printed)
      return run_sampler_pass<PrintedSampler>(frame, request, film,
                                              [&] { return PrintedSampler(frame, parameters.counting); });
    return run_sampler_pass<CountedCut>(frame, request, film, [&] { return parameters.sampler(frame); });
  }

  std::optional<PixelInspection> inspect(const FrameView& frame, const PassRequest& request,
                                         uint32_t pixel) override {
    const Parameters parameters(*frame.settings);
    if (parameters.form == Form::printed)
      return inspect_sampler(PrintedSampler(frame, parameters.counting), frame, request, pixel);
    return inspect_sampler(parameters.sampler(frame), frame, request, pixel);
  }
};

}  // namespace

TechniqueInfo bidirectional_technique() {
  TechniqueInfo info{"bidirectional",
                     "Cut × BRDF, counted",
                     "Wang & Åkerlund 2009, §3.3",
                     TargetSupport::both,
                     Bias::unbiased,
                     settings,
                     []() -> std::unique_ptr<Technique> { return std::make_unique<Bidirectional>(); },
                     "unbiased for the sum over S; with form = printed a cluster that no ray met is lost",
                     own_stages};
  info.draft_values = draft_values;
  info.neighbours_share = true;
  return info;
}

}  // namespace halflight
