// The renderer's face: open a scene, ask for the plan, run passes, read the film. The app sees nothing below
// this but scene, film and the technique registry. A session is used from the one thread that made it (its
// OpenGL context lives there); passes use all cores.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <vector>

#include "film/film.h"
#include "plan.h"
#include "raster/rasterizer.h"
#include "scene/camera.h"
#include "scene/load.h"
#include "techniques/technique.h"

namespace halflight {

struct RenderSettings {
  std::string technique{default_technique};
  std::optional<Target> target;  ///< the technique's own default
  LightSelection light = LightSelection::all;
  int width = 640, height = 480;
  uint64_t seed = 0;  ///< of samples only
  Backend backend = Backend::automatic;
  SettingValues values;
  bool pixel_centres = false;  ///< continuous target: the integral of light, seen as the discrete target sees
  StageSet forced;             ///< stages that run although nothing needs them; of benchmarks (PlanRequest)

  bool operator==(const RenderSettings&) const = default;
};

/// Of a picture that is there at once and stands in for the one asked for: fewer points, left where they were
/// drawn, a smaller cut, and a technique or settings that are quick (TechniqueInfo::draft_by, draft_values).
/// The same settings where a technique has no draft.
RenderSettings draft_settings(RenderSettings);

/// Wall-clock seconds of what has run since the last restart; `load` and `raster` include what the session
/// did first. `positions`: what pixels see beside the frame's G-buffer, found with each pass.
struct StageSeconds {
  double load = 0, raster = 0, lights = 0, positions = 0, distribution = 0, sampling = 0, visibility = 0,
         resolve = 0, total = 0;
  double gpu =
      0;  ///< of the GPU, within `sampling`: by timer queries, or by the clock where the driver has none
};

struct SessionStats {
  StageSeconds seconds;
  RayCounters rays;
  uint64_t useful_rays = 0;
  uint32_t passes = 0;
  uint32_t light_count = 0, cut_size = 0;
  /// Since the session began, or since the plan last took the stage in; restarts keep them, as they keep what
  /// the stages made.
  StageCounters stages;
};

/// What a user may change about the light while the geometry stands.
struct LightEdits {
  std::vector<PunctualLight> lights;
  std::vector<Vec3> emission;  ///< Material::emission, one a material
  float environment_rotation = 0, environment_strength = 1;
};

class Session {
 public:
  /// Takes a loaded scene; completes its lights. Throws Error (exit code 4) when the back end that was asked
  /// for cannot be had. `messages` must outlive the session.
  Session(Scene, const RenderSettings&, Messages&);
  ~Session();

  const Scene& scene() const;
  const RenderSettings& settings() const;
  const Camera& camera() const;
  const Plan& plan() const;
  const std::optional<GlDescription>& gl() const;  ///< nothing where the G-buffer comes from rays

  void set_camera(const Camera&);  ///< redraws the G-buffer
  /// Throws Error (exit code 4), and changes nothing, where the technique needs OpenGL and the back end is
  /// `none`.
  void set_settings(const RenderSettings&);  ///< redoes what the difference asks for
  void edit_lights(const LightEdits&);       ///< re-lights the points and re-cuts; geometry stays
  LightEdits light_edits() const;            ///< as they are now

  /// On: passes make the draft (`draft_settings`), where there is one; off: the picture. Clears the film;
  /// what either has made stays with it. `settings` and `plan` are the picture's all along. A draft is
  /// `scale` times as wide and high as the picture, and so are film and G-buffer then.
  void set_draft(bool, float scale = 1);
  bool has_draft() const;
  bool drafting() const;

  /// Samples a pixel for each round when `total` are wanted: many rounds where each redraws S and moves the
  /// pixel grid (continuous target), few where a round only adds samples to the same frame, one where a pass
  /// gives all there is (TechniqueInfo::exact).
  uint32_t round_samples(uint32_t total) const;

  /// Runs one pass over a subset of the pixels; see PassRequest. The first pass after a change prepares the
  /// frame.
  void run_pass(uint32_t samples, uint32_t stride, uint32_t offset, std::stop_token stop = {});
  /// How many passes of `run_subset` make the next round: 16, each over every fourth pixel each way, or over
  /// every fourth block of pixels where neighbours share what is made for them. Blocks show nothing of what
  /// lies between them: there a film's first round begins with one more pass, over every fourth pixel each
  /// way, and its blocks leave those out.
  uint32_t subset_count() const;
  /// Runs one of them, the last of a round last. Returns how many pixels it has.
  size_t run_subset(uint32_t samples, uint32_t subset, std::stop_token stop = {});
  /// A pass of `visits[pixel]` samples at each pixel of the picture, each a number up to `most`. Where
  /// nothing is redrawn between passes.
  void run_visits(uint32_t most, std::span<const uint16_t> visits, std::stop_token stop = {});

  const Film& film() const;
  /// What to show of the film so far: before its first round is whole, interpolated over like surfaces.
  ImageRgb preview() const;
  /// The film's own estimate of its relMSE; negative where it has none to give, as of a technique without
  /// noise that is biased all the same.
  double estimated_relmse() const;
  /// What the camera sees, as of the last pass; where the plan leaves it out, pixel centres by rays when
  /// first asked for.
  const GBuffer& gbuffer() const;
  const SessionStats& stats() const;
  void restart();  ///< clears the film
  /// As a new session of the same scene: the film is cleared, and the next pass makes S, tree, cut, shadow
  /// maps, G-buffer and technique again. Only Embree's tree and what OpenGL holds of the scene stay.
  void start_over();

  /// The frame as techniques see it, for tests and benchmarks; prepares it if needed.
  FrameView frame();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace halflight
