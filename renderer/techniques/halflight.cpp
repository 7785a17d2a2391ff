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
// Tokuyoshi et al. 2024 for the filtered lobe). No sample exceeds f L cos θ/(n_b p_b).
#include "lights/cut_importance.h"
#include "techniques/connection_batch.h"
#include "techniques/learned_lights.h"
#include "techniques/learned_visibility.h"
#include "techniques/traced_loop.h"

namespace halflight {

namespace {

constexpr std::array settings{
    SettingInfo{"halflight.brdf-share", 0.0625, 0, 1, "share of a pixel's samples that follow the BRDF"},
    SettingInfo{"halflight.narrow-share", 0.25, 0, 1,
                "the same where the lobe is narrower than the cut's clusters"},
    SettingInfo{"halflight.alpha", 0.05, 0, 1, "share of light samples that ignore the BRDF"},
    SettingInfo{"halflight.near", 0, 0, 1e6,
                "clusters that reach further than this share of their distance are split; 0: none"},
    SettingInfo{"halflight.share", 4, 1, 16,
                "like pixels of a block of this edge draw from one distribution"},
    SettingInfo{"halflight.visibility", 1, 0, 1, "1: draws learn which clusters are hidden; 0: not"},
    SettingInfo{"halflight.pilot-rays", 16, 1, 4096, "shadow rays that light a point of the pilot set"},
    SettingInfo{"halflight.light-rays", 0, 0, 4096,
                "shadow rays that light a point of a round's set; 0: as many as cost an eighth of the round"},
};

struct Parameters {
  float brdf_share, narrow_share, alpha, near;
  uint32_t share;
  bool visibility;
  uint32_t pilot_rays, light_rays;

  explicit Parameters(const SettingValues& values)
      : brdf_share(static_cast<float>(values.get("halflight.brdf-share"))),
        narrow_share(static_cast<float>(values.get("halflight.narrow-share"))),
        alpha(static_cast<float>(values.get("halflight.alpha"))),
        near(static_cast<float>(values.get("halflight.near"))),
        share(static_cast<uint32_t>(values.get("halflight.share"))),
        visibility(values.get("halflight.visibility") > 0),
        pilot_rays(static_cast<uint32_t>(values.get("halflight.pilot-rays"))),
        light_rays(static_cast<uint32_t>(values.get("halflight.light-rays"))) {}
};

// A lobe below this roughness is a mirror: no light sample finds it.
constexpr float mirror_alpha = 1e-3f;
// K clusters that share the sphere have a variance of about 1/K radians² each along an axis.
constexpr float narrow_lobe = 1;
constexpr float most_share_beside_punctual = 0.75f;

bool is_mirror(const Brdf& brdf) {
  return brdf.model == BrdfModel::ggx && max_component(brdf.diffuse) <= 0 &&
         std::max(brdf.roughness.x, brdf.roughness.y) < mirror_alpha;
}

/// How many of a pixel's samples follow the BRDF, and how many come from light.
struct Split {
  uint32_t rays, samples;
  float expected_rays, expected_samples;
};

/// Whole numbers whose means over a uniform `phase` in [0, 1) are the expected ones: with few samples a
/// round, neither way gets more than its share. Weights know the expected numbers, so that no sample loses
/// its bound.
Split split_of(float share, uint32_t count, float phase) {
  const float expected = std::clamp(share, 0.0f, 1.0f) * static_cast<float>(count);
  const uint32_t rays = std::min(static_cast<uint32_t>(expected + phase), count);
  return {rays, count - rays, expected, static_cast<float>(count) - expected};
}

/// Uniform over seeds; neighbours and successive rounds differ as much as can be (Roberts 2018, the R3
/// sequence).
float split_phase(const FrameView& frame, uint32_t pixel, uint32_t round) {
  const auto width = static_cast<uint32_t>(frame.gbuffer->width);
  const auto seed = static_cast<uint32_t>(hash_combine(frame.seed, 0x73706c6974ull));
  return to_unit_float(seed + pixel % width * 0xd1b54a33u + pixel / width * 0xabc98388u +
                       round * 0x8cb92ba7u);
}

/// Share of the specular lobe in what a point reflects.
float specular_share(const Brdf& brdf) {
  const float specular = luminance(brdf.specular), diffuse = luminance(brdf.diffuse);
  return specular > 0 ? specular / (specular + diffuse) : 0.0f;
}

/// Whether a distribution made for one of two neighbouring points serves the other: on one plane, of like
/// lobes.
bool alike(const GBufferTexel& a, const GBufferTexel& b) {
  constexpr float least_cosine = 0.95f, most_off_plane = 0.1f, most_ratio = 1.25f, most_apart = 0.1f;
  const Vec3 apart = b.position - a.position;
  const float off_plane = std::abs(glm::dot(apart, a.geometric_normal));
  const auto close = [](float x, float y) { return x <= most_ratio * y && y <= most_ratio * x; };
  return a.brdf.model == b.brdf.model && glm::dot(a.shading_normal, b.shading_normal) > least_cosine &&
         off_plane <= most_off_plane * glm::length(apart) && close(a.brdf.roughness.x, b.brdf.roughness.x) &&
         close(a.brdf.roughness.y, b.brdf.roughness.y) &&
         std::abs(specular_share(a.brdf) - specular_share(b.brdf)) < most_apart;
}

/// One thread's draws.
class PixelSampler {
 public:
  PixelSampler(const FrameView& frame, const Parameters& parameters, const LearnedLights& lights,
               LearnedVisibility& visibility, uint32_t round)
      : frame_(frame),
        round_(round),
        parameters_(parameters),
        lights_(lights),
        visibility_(visibility),
        cut_(lights.tree(), lights.cut()),
        groups_(*frame.gbuffer),
        guard_(lights.cut().padded_size()),
        arriving_(guard_.size()),
        factor_(guard_.size(), 1.0f) {}

  void render(TracedWorker&, uint32_t pixel, int half, uint32_t count, RandomStream&);

 private:
  void begin_group(const Aabb& points);
  bool is_narrow(const Brdf&) const;
  bool build(const GBufferTexel&);
  uint32_t representative(uint32_t pixel) const;
  bool build_or_share(uint32_t pixel);
  float brdf_share(const GBufferTexel&) const;
  void draw_light(TracedWorker&, int half, const Split&, RandomStream&);
  void connect(TracedWorker&, int half, const Split&);

  const FrameView& frame_;
  uint32_t round_;
  const Parameters& parameters_;
  const LearnedLights& lights_;
  LearnedVisibility& visibility_;
  TileCut cut_;
  PixelGroups groups_;
  std::vector<float> guard_, arriving_;
  std::vector<float> factor_;  ///< of the base cut's clusters
  uint32_t tile_ = LearnedLights::none;
  std::span<VisibilityCount> counts_;
  CutDistribution distribution_;
  uint32_t built_for_ = LearnedLights::none;  ///< the pixel that `distribution_` was made for
  bool built_ = false;
  std::vector<LightSample> draws_;
  ConnectionBatch batch_;
};

void PixelSampler::begin_group(const Aabb& points) {
  cut_.refine(points, parameters_.near);
  guard_.resize(cut_.cut().padded_size()), arriving_.resize(guard_.size());
}

bool PixelSampler::build(const GBufferTexel& texel) {
  const Cut& cut = cut_.cut();
  if (cut.size == 0) return false;
  const std::span<float> importance = distribution_.importance(cut);
  analytic_importance(cut, texel, 0, {importance, guard_, arriving_});
  if (parameters_.visibility)
    for (uint32_t k = 0; k < cut.size; ++k) importance[k] *= factor_[cut_.base_of(k)];
  return distribution_.build(cut, guard_, parameters_.alpha);
}

/// The pixel whose distribution serves this one: the first of its block that sees the same plane alike, in
/// the order of rows. It does not hang on which pixels a pass visits.
uint32_t PixelSampler::representative(uint32_t pixel) const {
  const std::vector<GBufferTexel>& texels = frame_.gbuffer->texels;
  if (parameters_.share < 2 || is_narrow(texels[pixel].brdf)) return pixel;
  const auto width = static_cast<uint32_t>(frame_.gbuffer->width);
  const uint32_t x = pixel % width, y = pixel / width;
  const uint32_t left = x - x % parameters_.share, top = y - y % parameters_.share;
  for (uint32_t v = top; v <= y; ++v)
    for (uint32_t u = left; u < std::min(left + parameters_.share, width); ++u) {
      const uint32_t candidate = v * width + u;
      if (candidate == pixel) return pixel;
      if (texels[candidate].hit() && alike(texels[candidate], texels[pixel])) return candidate;
    }
  return pixel;
}

bool PixelSampler::build_or_share(uint32_t pixel) {
  const uint32_t wanted = representative(pixel);
  if (wanted == built_for_) return built_;
  built_for_ = wanted;
  return built_ = build(frame_.gbuffer->texels[wanted]);
}

bool PixelSampler::is_narrow(const Brdf& brdf) const {
  return brdf.has_specular() && lobe_variance(brdf) * static_cast<float>(lights_.cut().size) < narrow_lobe;
}

float PixelSampler::brdf_share(const GBufferTexel& texel) const {
  const Brdf& brdf = texel.brdf;
  if (is_mirror(brdf)) return 1;
  if (!is_narrow(brdf)) return parameters_.brdf_share;
  const float specular = specular_probability(brdf, texel.basis(), texel.wo);
  return std::max(parameters_.brdf_share, std::min(parameters_.narrow_share, specular));
}

void PixelSampler::render(TracedWorker& worker, uint32_t pixel, int half, uint32_t count,
                          RandomStream& random) {
  const uint64_t start = ticks_now();
  if (parameters_.near > 0) groups_.next(pixel, [&](const Aabb& points) { begin_group(points); });
  const uint32_t tile = visibility_.tile_of(pixel);
  if (tile != tile_ && parameters_.visibility) {
    tile_ = tile;
    counts_ = visibility_.pending(tile);
    visibility_.factors(tile, factor_);
  }
  // Rays never meet punctual light.
  const float most_share = frame_.kinds.punctual ? most_share_beside_punctual : 1.0f;
  const float share = std::min(brdf_share(worker.texel()), most_share);
  const bool hits = frame_.kinds.environment || frame_.kinds.emitters || frame_.kinds.surfaces;
  const bool drawable = share < 1 && build_or_share(pixel);
  worker.distribution_ticks += ticks_now() - start;
  const Split split = split_of(!drawable ? 1 : hits ? share : 0, count, split_phase(frame_, pixel, round_));
  const DrawAllocation expected =
      DrawAllocation::of_rays_and_samples(split.expected_rays, split.expected_samples);
  if (split.samples > 0) draw_light(worker, half, split, random);
  if (hits && split.rays > 0)
    worker.draw_brdf(half, split.rays, expected, {&lights_, &cut_, drawable ? &distribution_ : nullptr},
                     random);
}

void PixelSampler::draw_light(TracedWorker& worker, int half, const Split& split, RandomStream& random) {
  draws_.resize(split.samples);
  distribution_.draw(cut_.cut(), random, draws_);
  for (const LightSample& draw : draws_) prefetch(&lights_.light(draw.light));
  for (const LightSample& draw : draws_) {
    const float rays = lights_.met_by_rays(draw.light) ? split.expected_rays : 0.0f;
    batch_.add(lights_.light(draw.light), *frame_.scene, worker.texel().position, draw.weight, draw.light,
               rays);
    if (batch_.size == ConnectionBatch::capacity) connect(worker, half, split);
  }
  if (batch_.size > 0) connect(worker, half, split);
}

void PixelSampler::connect(TracedWorker& worker, int half, const Split& split) {
  batch_.connect_beside_rays(worker.texel(), worker.basis(), GeometryTerm::exact, split.expected_samples);
  for (size_t i = 0; i < batch_.size; ++i) {
    if (!(batch_.matters[i] > 0)) continue;
    VisibilityCount* count = nullptr;
    if (parameters_.visibility) {
      count = &counts_[cut_.base_of_leaf(batch_.tag[i])];
      count = count->drawn < 0xffff ? count : nullptr;
      if (count) ++count->drawn;
    }
    worker.add_ray(shadow_ray(worker.origin(), batch_.wi(i), batch_.distance[i]), batch_.value(i), half,
                   count);
  }
  batch_.size = 0;
}

class Halflight final : public Technique {
 public:
  void prepare(const FrameView&) override { lights_.reset(); }

  PassStats run_pass(const FrameView& frame, const PassRequest& request, Film& film) override {
    const Parameters parameters(*frame.settings);
    PassStats stats;
    Stopwatch watch;
    prepare_round(frame, request, parameters, stats.rays);
    stats.lights_seconds = watch.seconds();

    const std::array<uint32_t, 2> split = split_samples(request);
    tbb::enumerable_thread_specific<PixelSampler> samplers(
        [&] { return PixelSampler(frame, parameters, *lights_, visibility_, request.pass); });
    stats += run_traced_tiles(
        frame, request,
        [&] { return TracedWorker(frame, request, film, lights_->sources(), TracedParameters{}, split); },
        [&](TracedWorker& worker, uint32_t pixel, RandomStream& random) {
          for (int half = 0; half < 2; ++half)
            if (split[half] > 0) samplers.local().render(worker, pixel, half, split[half], random);
        });
    return stats;
  }

 private:
  void prepare_round(const FrameView&, const PassRequest&, const Parameters&, RayCounters&);

  std::unique_ptr<LearnedLights> lights_;
  LearnedVisibility visibility_;
  uint32_t round_ = 0;
  bool has_set_ = false;
};

void Halflight::prepare_round(const FrameView& frame, const PassRequest& request,
                              const Parameters& parameters, RayCounters& counters) {
  const bool fresh = !lights_;
  if (fresh) {
    lights_ = std::make_unique<LearnedLights>(frame, parameters.pilot_rays, counters);
    has_set_ = false;
  }
  const bool begins_again = has_set_ && request.pass == round_ && request.offset == 0;
  const int width = frame.gbuffer->width, height = frame.gbuffer->height;
  const size_t clusters = lights_->cut().padded_size();
  if (!visibility_.fits(width, height, clusters))
    visibility_ = LearnedVisibility(width, height, clusters);
  else if (fresh || request.pass < round_ || begins_again)
    visibility_.forget();  // rounds repeat their numbers: what they taught before belongs to these very sets
  else if (request.pass > round_)
    visibility_.publish();
  if (has_set_ && request.pass == round_ && !begins_again) return;
  round_ = request.pass;
  has_set_ = true;
  uint32_t rays = parameters.light_rays;
  if (rays == 0) {
    const double round_rays = static_cast<double>(frame.gbuffer->pixel_count()) * request.samples;
    const double points = std::max(1u, lights_->point_count());
    rays = static_cast<uint32_t>(std::clamp(round_rays / 8 / points, 1.0, 16.0));
  }
  lights_->draw_set(frame, request.pass, rays, counters);
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
  return info;
}

}  // namespace halflight
