// Instant global illumination: Pharr's note on Wald et al. 2002, after Keller 1997 (instant radiosity). A few
// paths from the lights leave virtual lights wherever they meet a surface; all pixels share them.
//
// Estimate at a pixel: direct light by BRDF rays and light samples under the balance heuristic, plus, for
// each sample, the sum over all virtual lights of one set, Σ s(d²) f cos θ cos θ' Φ V/d², the set chosen by a
// stratified number. s is smoothstep(0.8 m², 1.2 m², d²) of the minimum distance m. Contributions below a
// threshold are traced one time in ten and count ten times then.
//
// Biased: light within the minimum distance is lost, and surfaces that return light count as Lambertian. All
// bounces are in its picture, where the other techniques have one: its target is its own. Otherwise unbiased
// over sets; with instant.sets = kept, as published, the sets are the picture's for good, and more samples do
// not make them more.
// - The note divides a set's sum by the number of its virtual lights. Dividing by the number of its paths is
// what its
//   own derivation asks for and what makes the mean right; that is done here.
// - A virtual light shines on the side that was met only: the note's |cos θ'| leaks through walls.
// - Paths go on with the luminance of what is reflected as probability, as printed. Where a colour is so
// saturated
//   that a channel's albedo squared exceeds that luminance, the variance of that channel has no bound.
// - The note follows perfect mirrors from the eye. No material here has one (GGX has α ≥ 1e-4).
#include "core/warp.h"
#include "techniques/connection_batch.h"
#include "techniques/light_paths.h"
#include "techniques/mis_traced.h"

namespace halflight {

namespace {

constexpr std::array<std::string_view, 2> unit_names{"scene", "absolute"};
constexpr std::array<std::string_view, 2> set_names{"kept", "redrawn"};

constexpr std::array settings{
    SettingInfo{"instant.light-paths", 64, 1, 1048576, "paths of one set; rounded up to a power of two"},
    SettingInfo{"instant.light-sets", 4, 1, 4096, "sets; rounded up to a power of two"},
    SettingInfo{"instant.min-distance", 0.03, 0, 1e30, "virtual lights nearer than this fade away; 0: none"},
    SettingInfo{"instant.distance-unit", 0, 0, 1, "of the minimum distance: the scene's diagonal or 1",
                unit_names},
    SettingInfo{"instant.roulette-threshold", 0.1, 0, 1e6,
                "weaker lights are traced one time in ten; in units of a virtual light's mean"},
    SettingInfo{"instant.direct-samples", 4, 1, 4096,
                "light samples and BRDF rays for direct light, a sample"},
    SettingInfo{"instant.sets", 0, 0, 1,
                "redrawn: new ones each round, and the mean over sets is what remains", set_names},
};

constexpr float survival_of_the_weak = 0.1f;

uint32_t round_up_to_power(double value) { return std::bit_ceil(static_cast<uint32_t>(value)); }

struct Parameters {
  LightPathSettings paths;
  float least_distance2 = 0;  ///< square of the minimum distance
  float threshold = 0;
  uint32_t direct_samples = 4;
  bool redrawn = false;

  Parameters() = default;
  Parameters(const SettingValues& values, float scene_size) {
    paths.paths = round_up_to_power(values.get("instant.light-paths"));
    paths.sets = round_up_to_power(values.get("instant.light-sets"));
    const bool absolute = values.get("instant.distance-unit") == 1;
    least_distance2 =
        square(static_cast<float>(values.get("instant.min-distance")) * (absolute ? 1 : scene_size));
    threshold = static_cast<float>(values.get("instant.roulette-threshold"));
    direct_samples = static_cast<uint32_t>(values.get("instant.direct-samples"));
    redrawn = values.get("instant.sets") == 1;
  }
};

/// van der Corput's sequence in base 2: any 2ᵏ of it that start at a multiple of 2ᵏ are evenly spread.
float radical_inverse(uint32_t index) {
  uint32_t reversed = 0;
  for (int bit = 0; bit < 32; ++bit) reversed |= (index >> bit & 1u) << (31 - bit);
  return to_unit_float(reversed);
}

/// The note's smoothstep over squared distances.
float distance_fade(float distance2, float least_distance2) {
  return least_distance2 > 0 ? glm::smoothstep(0.8f * least_distance2, 1.2f * least_distance2, distance2)
                             : 1.0f;
}

/// The sets of a frame and what choosing among them takes.
class VirtualLightSets {
 public:
  /// `area`: of the surfaces that return light.
  void assign(std::vector<std::vector<VirtualLight>> sets, double area) {
    sets_ = std::move(sets);
    double total = 0, count = 0;
    for (const auto& set : sets_)
      for (const VirtualLight& light : set) total += luminance(light.radiance), count += 1;
    // Mean radiance that one light gives a white surface: it sends π times its radiance over the whole area.
    mean_contribution_ = count > 0 && area > 0 ? static_cast<float>(total / (count * area)) : 0.0f;
  }

  size_t size() const { return sets_.size(); }
  const std::vector<VirtualLight>& operator[](size_t i) const { return sets_[i]; }
  float mean_contribution() const { return mean_contribution_; }

  /// The set of a half's sample `index`: each half has its own, so that their difference shows what sets
  /// cost. One set is everyone's.
  size_t choose(int half, uint32_t index, float shift) const {
    const size_t count = std::max<size_t>(sets_.size() / 2, 1);
    const float u = radical_inverse(index) + shift;
    const size_t within =
        std::min(static_cast<size_t>((u < 1 ? u : u - 1) * static_cast<float>(count)), count - 1);
    return sets_.size() > 1 ? static_cast<size_t>(half) * count + within : 0;
  }

 private:
  std::vector<std::vector<VirtualLight>> sets_;
  float mean_contribution_ = 0;
};

/// One thread's pixel: adds the light of the chosen sets.
class IndirectGatherer {
 public:
  IndirectGatherer(const FrameView& frame, const PassRequest& request, const VirtualLightSets& sets,
                   const Parameters& parameters)
      : frame_(&frame), request_(&request), sets_(&sets), parameters_(&parameters) {
    const auto split = split_samples(request);
    chosen_.reserve(std::max(split[0], split[1]));
  }

  void gather(TracedWorker& worker, uint32_t pixel, int half, uint32_t samples, RandomStream& random) {
    if (sets_->size() == 0) return;
    // The shift is the pixel's own in all passes: together their samples go round the sets.
    const float shift = RandomStream(pixel, 0x73657473, frame_->seed).next();
    const uint32_t first = request_->half ? request_->pass / 2 * samples : request_->pass * samples;
    chosen_.clear();
    for (uint32_t j = 0; j < samples; ++j)
      chosen_.push_back(static_cast<uint32_t>(sets_->choose(half, first + j, shift)));
    std::sort(chosen_.begin(), chosen_.end());
    // A set that several samples chose is summed once.
    for (size_t i = 0; i < chosen_.size();) {
      const size_t begin = i;
      while (i < chosen_.size() && chosen_[i] == chosen_[begin]) ++i;
      add_set(worker, (*sets_)[chosen_[begin]], static_cast<float>(i - begin) / static_cast<float>(samples),
              half, random);
    }
  }

 private:
  void add_set(TracedWorker& worker, const std::vector<VirtualLight>& set, float weight, int half,
               RandomStream& random) {
    for (const VirtualLight& light : set) {
      batch_.add({&light, 1});
      if (batch_.full()) add_batch(worker, weight, half, random);
    }
    if (batch_.size > 0) add_batch(worker, weight, half, random);
  }

  void add_batch(TracedWorker& worker, float weight, int half, RandomStream& random) {
    batch_.connect(*frame_->scene, worker.texel(), worker.basis(), GeometryTerm::exact);
    const float weak = parameters_->threshold * sets_->mean_contribution();
    for (size_t i = 0; i < batch_.size; ++i) {
      if (!(batch_.matters[i] > 0)) continue;
      const float fade = distance_fade(square(batch_.distance[i]), parameters_->least_distance2);
      if (!(fade > 0)) continue;
      Vec3 value = batch_.value(i) * fade;
      if (luminance(value) < weak) {
        if (random.next() >= survival_of_the_weak) continue;
        value /= survival_of_the_weak;
      }
      worker.add_ray(shadow_ray(worker.origin(), batch_.wi(i), batch_.distance[i]), value * weight, half);
    }
    batch_.size = 0;
  }

  const FrameView* frame_;
  const PassRequest* request_;
  const VirtualLightSets* sets_;
  const Parameters* parameters_;
  std::vector<uint32_t> chosen_;
  ConnectionBatch batch_;
};

StageSet own_stages(const SettingValues&, Target, const LightKinds& kinds) {
  return StageSet().add(Stage::traced_brdf_rays, kinds.environment || kinds.emitters);
}

class Instant final : public Technique {
 public:
  void prepare(const FrameView& frame) override {
    lights_ = std::make_unique<LightSources>(*frame.scene, frame.kinds);
    parameters_ = Parameters(*frame.settings, frame.scene->bounds.diagonal());
    prepared_ = RayCounters();
    if (!parameters_.redrawn) draw_sets(frame, 0, prepared_);
    drawn_for_.reset();
  }

  PassStats run_pass(const FrameView& frame, const PassRequest& request, Film& film) override {
    PassStats stats;
    stats.rays += std::exchange(prepared_, RayCounters());
    if (parameters_.redrawn && drawn_for_ != request.pass) {
      Stopwatch watch;
      draw_sets(frame, request.pass + 1, stats.rays);
      drawn_for_ = request.pass;
      stats.distribution_seconds += watch.seconds() * thread_count();
    }
    // Direct light is the worker's; light that surfaces return is the virtual lights'.
    FrameView direct = frame;
    direct.kinds.surfaces = false;
    TracedParameters traced;
    traced.shares = mis_shares(direct.kinds, MisStrategy::both, 0.5);
    const auto split = split_samples(request);
    const std::array<uint32_t, 2> draws{split[0] * parameters_.direct_samples,
                                        split[1] * parameters_.direct_samples};
    tbb::enumerable_thread_specific<IndirectGatherer> gatherers(
        [&] { return IndirectGatherer(frame, request, sets_, parameters_); });
    stats += run_traced_pixels(
        direct, request, [&] { return TracedWorker(direct, request, film, *lights_, traced, draws); },
        [&](TracedWorker& worker, uint32_t pixel, RandomStream& random) {
          for (int half = 0; half < 2; ++half) {
            if (split[half] == 0) continue;
            worker.draw(half, random);
            gatherers.local().gather(worker, pixel, half, split[half], random);
          }
        });
    return stats;
  }

 private:
  void draw_sets(const FrameView& frame, uint32_t round, RayCounters& counters) {
    LightPathSettings paths = parameters_.paths;
    paths.seed = hash_combine(frame.seed, round);
    paths.alpha_seed = frame.alpha_seed;
    sets_.assign(frame.kinds.surfaces ? trace_light_paths(*lights_, *frame.rays, paths, counters)
                                      : std::vector<std::vector<VirtualLight>>(),
                 lights_->surfaces.area());
  }

  std::unique_ptr<LightSources> lights_;
  Parameters parameters_;
  VirtualLightSets sets_;
  RayCounters prepared_;  ///< rays since the last pass
  std::optional<uint32_t> drawn_for_;
};

}  // namespace

TechniqueInfo instant_technique() {
  return {"instant",
          "Virtual lights from light paths",
          "Pharr; Wald et al. 2002",
          TargetSupport::own,
          Bias::biased,
          settings,
          []() -> std::unique_ptr<Technique> { return std::make_unique<Instant>(); },
          "biased: near light is faded out, surfaces return light as Lambertian ones; all bounces",
          own_stages};
}

}  // namespace halflight
