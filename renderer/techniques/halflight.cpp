// Light samples from the product of light and BRDF over a cut, and BRDF rays, under one balance heuristic: an
// estimate of the integral itself that no near surface, sharp lobe or small light throws off.
//
// Light is cut into strata by geometry; each round draws one point uniform in each and lights it by rays
// (learned_lights.h). Of N samples at a pixel n_b follow the BRDF to what they meet, n_v come from
//   q_k ∝ (1 − α) l_k Ω_k [k_s D_k + (k_d/π) cos θ_k] √v̂_k + α u_k,
// D_k the lobe filtered by the cluster's extent (lights/cut_importance.h), v̂_k what was seen to arrive from
// cluster k in earlier rounds (learned_visibility.h). Strata, powers and v̂ come from earlier sets only, so
// that the density p_v(ω) = P(i)/A_i · r²/|cos θ'| is known for whatever a BRDF ray meets, and
//   Σ f L cos θ/(n_v p_v + n_b p_b)
// is unbiased for the integral (Veach & Guibas 1995; Wang & Åkerlund 2009 for light × BRDF over a cut;
// Tokuyoshi et al. 2024 for the filtered lobe). Inside a cluster leaves are drawn by what this round's points
// send, P' in place of P; such a sample is multiplied by P/P' ≤ 10 and weighed by p_v as before: weights of
// two ways to a point must sum to 1 and know nothing of the set in hand, no more. So no sample exceeds 10 f L
// cos θ/(n_b p_b).
#include "techniques/halflight_sampler.h"

namespace halflight {

namespace {

constexpr std::array settings{
    SettingInfo{"halflight.brdf-share", 0.125, 0, 1, "share of a pixel's samples that follow the BRDF"},
    SettingInfo{"halflight.specular-share", 0.25, 0, 1,
                "the same where a specular lobe reflects as much or more of the light"},
    SettingInfo{"halflight.alpha", 0.05, 0, 1, "share of light samples that ignore the BRDF"},
    SettingInfo{"halflight.share", 1, 0, 1, "1: all that is alike in 4×4 pixels draws from one distribution"},
    SettingInfo{
        "halflight.position-samples", 4, 1, 4096,
        "samples that share a position in the pixel; from 8 positions on, twice as many; up to 16 positions"},
    SettingInfo{"halflight.punctual-clusters", 1, 0, 1,
                "1: each punctual light is a cluster of its own, up to cut.most; 0: cut.error decides"},
    SettingInfo{"halflight.environment-clusters", 512, 0, 1e6,
                "clusters of the environment at least, up to cut.most"},
    SettingInfo{"halflight.visibility", 1, 0, 1, "1: draws learn which clusters are hidden; 0: not"},
    SettingInfo{"halflight.powers", 1, 0, 1,
                "1: strata learn from each round what they send; 0: from the pilot alone"},
    SettingInfo{"halflight.pilot-rays", 4, 1, 4096,
                "shadow rays that light a stratum in all sets of the pilot together"},
    SettingInfo{"halflight.light-rays", 0, 0, 4096,
                "shadow rays that light a point of a round's set; 0: as many as cost an eighth of the round"},
};

HalflightParameters parameters_of(const SettingValues& values) {
  HalflightParameters parameters;
  parameters.brdf_share = static_cast<float>(values.get("halflight.brdf-share"));
  parameters.specular_share = static_cast<float>(values.get("halflight.specular-share"));
  parameters.alpha = static_cast<float>(values.get("halflight.alpha"));
  parameters.share = values.get("halflight.share") > 0;
  parameters.powers = values.get("halflight.powers") > 0;
  parameters.visibility = values.get("halflight.visibility") > 0;
  parameters.position_samples = static_cast<uint32_t>(values.get("halflight.position-samples"));
  parameters.punctual_clusters = values.get("halflight.punctual-clusters") > 0;
  parameters.environment_clusters = static_cast<uint32_t>(values.get("halflight.environment-clusters"));
  parameters.pilot_rays = static_cast<uint32_t>(values.get("halflight.pilot-rays"));
  parameters.light_rays = static_cast<uint32_t>(values.get("halflight.light-rays"));
  return parameters;
}

StageSet own_stages(const SettingValues& values, Target, const LightKinds& kinds) {
  const HalflightParameters parameters = parameters_of(values);
  return StageSet()
      .add(Stage::strata)
      .add(Stage::pilot_set)
      .add(Stage::cut)
      .add(Stage::traced_brdf_rays,
           kinds.met_by_rays() && (parameters.brdf_share > 0 || parameters.specular_share > 0))
      .add(Stage::learned_visibility, parameters.visibility);
}

// A tile's counts are written by the one thread that renders it.
static_assert(TileGrid::side % LearnedVisibility::side == 0);

class Halflight final : public Technique {
 public:
  void prepare(const FrameView&) override { lights_.reset(); }

  void count_held(const FrameView& frame, StageCounters& counters) const override {
    if (lights_) lights_->count_held(frame, counters);
    counters[Stage::learned_visibility].bytes += visibility_.held_bytes();
  }

  PassStats run_pass(const FrameView& frame, const PassRequest& request, Film& film) override {
    HalflightParameters parameters = parameters_of(*frame.settings);
    parameters.visibility &= frame.runs(Stage::learned_visibility);
    PassStats stats;
    Stopwatch watch;
    prepare_round(frame, request, parameters, stats);
    stats.lights_seconds = watch.seconds();
    stats.light_count = static_cast<uint32_t>(lights_->tree().lights.size());
    stats.cut_size = lights_->cut().size;

    tbb::enumerable_thread_specific<HalflightSampler> samplers(
        [&] { return HalflightSampler(frame, request, parameters, *lights_, visibility_); });
    stats += run_traced_tiles(
        frame, request,
        [&] {
          return TracedWorker(frame, request, film, lights_->sources(), TracedParameters{},
                              split_samples(request));
        },
        [&](TracedWorker& worker, std::span<const uint32_t> pixels) {
          samplers.local().render(worker, pixels);
        });
    return stats;
  }

 private:
  void prepare_round(const FrameView&, const PassRequest&, const HalflightParameters&, PassStats&);

  std::unique_ptr<LearnedLights> lights_;
  LearnedVisibility visibility_;
  uint32_t round_ = 0;
  bool has_set_ = false;
};

void Halflight::prepare_round(const FrameView& frame, const PassRequest& request,
                              const HalflightParameters& parameters, PassStats& stats) {
  const bool fresh = !lights_;
  if (fresh) {
    lights_ = std::make_unique<LearnedLights>(frame, parameters.pilot_rays, parameters.punctual_clusters,
                                              parameters.environment_clusters, stats);
    has_set_ = false;
  }
  const bool begins_again = has_set_ && request.pass == round_ && request.offset == 0;
  const int width = frame.gbuffer->width, height = frame.gbuffer->height;
  const size_t clusters = lights_->cut().padded_size();
  if (!parameters.visibility)
    visibility_ = {};
  else if (!visibility_.fits(width, height, clusters))
    visibility_ = LearnedVisibility(width, height, clusters);
  else if (fresh || request.pass < round_ || begins_again)
    visibility_.forget();  // rounds repeat their numbers: what they taught before belongs to these very sets
  else if (request.pass > round_)
    visibility_.publish();
  if (!fresh && (request.pass < round_ || begins_again))
    lights_->forget();
  else if (has_set_ && parameters.powers && request.pass > round_)
    lights_->learn();
  if (has_set_ && request.pass == round_ && !begins_again) return;
  round_ = request.pass;
  has_set_ = true;
  uint32_t rays = parameters.light_rays;
  if (rays == 0) {
    const double round_rays = static_cast<double>(frame.gbuffer->pixel_count()) * request.samples;
    const double points = std::max(1u, lights_->point_count());
    rays = static_cast<uint32_t>(std::clamp(round_rays / 8 / points, 1.0, 16.0));
  }
  lights_->draw_set(frame, request.pass, rays, stats);
}

}  // namespace

TechniqueInfo halflight_technique() {
  TechniqueInfo info{"halflight",
                     "Light × BRDF over strata, with BRDF rays",
                     "Wang & Åkerlund 2009; Veach & Guibas 1995; Tokuyoshi et al. 2024",
                     TargetSupport::continuous,
                     Bias::unbiased,
                     settings,
                     []() -> std::unique_ptr<Technique> { return std::make_unique<Halflight>(); },
                     "unbiased for the integral"};
  info.leaves_s_when_continuous = true;
  info.has_own_lights = true;
  info.samples_a_round = 64;
  info.stages = own_stages;
  info.spares_brdf_rays = true;
  info.draft_by = "bidirectional";
  return info;
}

}  // namespace halflight
