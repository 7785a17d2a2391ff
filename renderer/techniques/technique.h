// A technique: how the light of S (or of the scene itself) is sampled at a pixel. Virtual per pass, never per
// sample.
//
// To add one: a file in this folder with its citation, estimator and target; a line in registry.cpp. It then
// appears in the window, the command line and the reports, and inherits the tests.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string_view>
#include <utility>
#include <vector>

#include "film/film.h"
#include "lights/cut_distribution.h"
#include "lights/light_tree.h"
#include "scene/camera.h"
#include "scene/gbuffer.h"
#include "techniques/settings.h"
#include "techniques/stages.h"
#include "trace/ray_scene.h"

namespace halflight {

class Rasterizer;

/// What a picture converges to: the sum over one frozen S seen through pixel centres, or the integral,
/// antialiased.
enum class Target { discrete, continuous };
enum class TargetSupport { discrete, continuous, both, own };
enum class Bias { unbiased, biased };
enum class LightSelection { all, direct, indirect };
/// Where a technique runs: `gpu` ones need OpenGL.
enum class Device { cpu, gpu };

std::string_view target_name(Target);

/// Kinds of light at a pixel.
struct LightKinds {
  bool environment = false, emitters = false, surfaces = false, punctual = false;

  bool any() const { return environment || emitters || surfaces || punctual; }
  bool met_by_rays() const { return environment || emitters || surfaces; }
  /// At a distance from a pixel's point that may be small beside their size.
  bool near() const { return emitters || surfaces; }
  bool operator==(const LightKinds&) const = default;
};

/// Everything a technique may read while a pass runs; nothing in it changes during the pass.
struct FrameView {
  const Scene* scene = nullptr;
  const Camera* camera = nullptr;  ///< for techniques that send their own rays through the film's pixels
  const RayScene* rays = nullptr;
  Rasterizer* raster = nullptr;      ///< drew the G-buffer and still holds it; null where rays made it
  const GBuffer* gbuffer = nullptr;  ///< null, as `base`, for techniques that trace from the camera
  const LightTree* tree = nullptr;
  const Cut* cut = nullptr;
  const SettingValues* settings = nullptr;
  const std::vector<Vec3>* base = nullptr;  ///< per pixel: emission seen + direct light found by other stages
  /// What `base` holds, for techniques that look through a pixel at positions of their own; its punctual
  /// light is by rays in the continuous target.
  bool base_has_emission = false, base_has_punctual = false;
  Target target = Target::discrete;
  /// What a technique that follows rays itself must find, each once: D_environment, D_emitter, I (`surfaces`)
  /// and D_punctual; the rest is in `base` or was not asked for. S holds these very kinds.
  LightKinds kinds;
  LightSelection light = LightSelection::all;  ///< what of the picture is asked for
  uint64_t seed = 0;
  uint32_t alpha_seed = 0;
  StageSet stages = StageSet::all();  ///< what the plan has left in
  StageSet forced;                    ///< of them, what the scene does not need (benchmarks)

  bool runs(Stage stage) const { return stages.has(stage); }
  /// Whose a cut's bytes are: one of the leaves themselves goes with the tree.
  Stage cut_stage() const { return runs(Stage::cut) ? Stage::cut : Stage::light_tree; }

  GeometryTerm geometry_term() const {
    return target == Target::discrete ? GeometryTerm::bounded : GeometryTerm::exact;
  }
};

/// One pass: `samples` a pixel over every `stride`-th pixel in x and y, or some of those. Discrete target:
/// half of them go to each half of the film. Continuous target: S is redrawn between passes, so that halves
/// are independent only when a pass fills one.
struct PassRequest {
  uint32_t pass = 0;
  uint32_t samples = 32;
  std::optional<int> half;  ///< 0 or 1: all samples to that half; none: split
  uint32_t stride = 1;      ///< 1, 2 or 4
  uint32_t offset = 0;      ///< which of the stride² interleaved subsets
  /// Where not empty, how many samples each pixel of the picture gets: `samples` or fewer, or none. Not where
  /// S or the pixel grid is redrawn.
  std::span<const uint16_t> visits{};
  std::stop_token stop{};
  /// Benchmarks: sees each batch of visibility rays before it is traced, from any thread.
  std::function<void(std::span<const ShadowRay>)> watch_rays{};

  uint32_t samples_at(uint32_t pixel) const { return visits.empty() ? samples : visits[pixel]; }
  bool samples_pixel(uint32_t pixel) const { return visits.empty() || visits[pixel] > 0; }
};

struct PassStats {
  double lights_seconds = 0;  ///< wall time of making its own lights
  double distribution_seconds = 0, sampling_seconds = 0, visibility_seconds = 0,
         resolve_seconds = 0;  ///< thread seconds
  double gbuffer_seconds = 0;  ///< thread seconds of finding what positions beside the frame's see
  double gpu_seconds = 0;      ///< of the GPU, within `sampling_seconds`
  RayCounters rays;
  uint64_t useful_rays = 0;  ///< visibility rays that could carry light (f · L > 0)
  uint64_t pixels = 0;
  /// Of lights that are the technique's own.
  uint32_t light_count = 0, cut_size = 0;
  bool finished = true;  ///< false when stopped early
  StageCounters stages;  ///< of stages that are the technique's own

  PassStats& operator+=(const PassStats&);
};

/// What a technique that draws from S does at one pixel, for tests. Lights are in the tree's order.
struct PixelInspection {
  std::vector<double> probability;  ///< P(i)
  std::vector<float> weight;        ///< what a draw of i is weighed with; 0 where P(i) = 0
  std::vector<LightSample> draws;   ///< `samples` of the request, from one stratified set
};

class Technique {
 public:
  virtual ~Technique() = default;
  /// Called when lights, cut or settings changed, before the next pass.
  virtual void prepare(const FrameView&) {}
  virtual PassStats run_pass(const FrameView&, const PassRequest&, Film&) = 0;
  /// Adds the bytes that it holds for stages between passes.
  virtual void count_held(const FrameView&, StageCounters&) const {}
  /// Nothing where the technique has no probabilities to tell.
  virtual std::optional<PixelInspection> inspect(const FrameView&, const PassRequest&, uint32_t) {
    return std::nullopt;
  }
};

struct TechniqueInfo {
  std::string_view id, title, source;
  TargetSupport target;
  Bias bias;
  std::span<const SettingInfo> settings;
  std::unique_ptr<Technique> (*make)();
  std::string_view note{};  ///< one line: what it is unbiased for, or what biases it
  /// Stages that are the technique's own (the cut, if it reads it, among them) with these settings and kinds
  /// of light to find; the plan leaves out what the scene does not need. Null: none.
  StageSet (*stages)(const SettingValues&, Target, const LightKinds&) = nullptr;
  /// In the continuous target it follows rays into the scene itself: its mean is no sum over the frame's S.
  bool leaves_s_when_continuous = false;
  /// It finds the whole picture by its own rays from the camera: no G-buffer and no `base` are made for it.
  bool traces_from_camera = false;
  bool exact = false;  ///< one pass holds all the technique has to give; more passes repeat it
  Device device = Device::cpu;
  bool hidden = false;          ///< found by its id, listed nowhere
  bool has_own_lights = false;  ///< instead of S, tree and cut of the frame it makes its own
  /// Continuous target: samples a pixel that one round uses well, being spread over the pixel. 1: all of a
  /// round's look through the one position of its G-buffer, and more rounds are worth more than larger ones.
  uint32_t samples_a_round = 1;
  /// Its light samples know cosines, and BRDF rays are worth their cost only on specular lobes and near
  /// light.
  bool spares_brdf_rays = false;
  /// Discrete target: pixels side by side share what is made for them, and cost less than as many that lie
  /// apart.
  bool neighbours_share = false;
  /// What stands in for it where a picture is wanted at once: another technique, or else itself.
  std::string_view draft_by{};
  std::span<const std::pair<std::string_view, std::string_view>> draft_values{};  ///< of itself as a draft
};

/// `TechniqueInfo::stages` of those that read the cut and have no stages of their own.
StageSet reads_cut(const SettingValues&, Target, const LightKinds&);

/// Whether S, its tree and the cut are made for the technique in this target. Those with a target of their
/// own have their own lights.
bool uses_light_set(const TechniqueInfo&, Target);

/// What runs where no technique is asked for, and where the discrete target is.
inline constexpr std::string_view default_technique = "halflight",
                                  default_discrete_technique = "bidirectional";

/// The registry; CLI, window, reports and tests all read this.
std::span<const TechniqueInfo> techniques();
/// Throws Error (exit code 2) listing the valid ids.
const TechniqueInfo& find_technique(std::string_view id);
/// The target a technique runs in when none is asked for. Throws Error (exit code 2) when `wanted` is not
/// supported.
Target choose_target(const TechniqueInfo&, std::optional<Target> wanted);

}  // namespace halflight
