// What a session is made of. Private to session.cpp, which holds its face, and session_frame.cpp, which makes
// what a pass needs.
#pragma once

#include "session.h"

namespace halflight {

/// What is made for one set of settings: its plan, S and technique, and what of them must be made again
/// before the next pass.
struct Rendition {
  RenderSettings settings;
  Plan plan;
  LightStage lights;
  std::unique_ptr<Technique> technique;
  bool lights_are_made = false;  ///< `lights` holds S
  bool stale_points = true;      ///< positions of S
  bool stale_lights = true;      ///< radiances of S
  bool stale_technique = true;

  /// Takes other settings over, and with `compare_set`, once the plan is theirs, what they make stale.
  void take(const RenderSettings&);
  void compare_set(const Plan& before);

  const TechniqueInfo& info() const { return find_technique(settings.technique); }
  Target target() const { return choose_target(info(), settings.target); }
  bool needs_gl() const { return info().device == Device::gpu; }
};

struct Session::Impl {
  Impl(Scene, const RenderSettings&, Messages&);

  bool resize_draft(float scale);
  void open_backend();
  void make_rasterizer(Backend backend);
  void drop_rasterizer(const std::string& why);
  void replan();
  void replan(Rendition&);
  void prepare();
  void prepare_lights();
  void leave_lights_out();
  void prepare_gbuffer();
  void draw_gbuffer(uint32_t alpha_seed);
  void light_gbuffer(uint32_t alpha_seed);
  void draw_shadow_maps();
  void drop_what_is_left_out();
  void count_call(Stage, double seconds = 0);
  void count_held(const PassStats&);
  std::vector<Vec3> irradiance(const std::vector<BouncePoint>& points, uint64_t seed);
  FrameView view() const;
  bool neighbours_share() const;
  void run_pass(PassRequest, bool ends_round);

  Scene scene;
  Messages& messages;
  Rendition picture, draft;
  Rendition* now = &picture;  ///< the one that passes work on
  bool drafts = false;        ///< there has been a draft: what it made is kept for the next
  std::unique_ptr<RayScene> rays;
  std::unique_ptr<GlContext> context;
  std::unique_ptr<Rasterizer> rasterizer;  ///< kept, once made, for the next technique that needs it
  Backend opened_backend = Backend::none;  ///< what `rasterizer` was made for
  std::optional<GlDescription> gl;         ///< while `rasterizer` draws the G-buffer
  std::string why_backend;
  Camera camera;
  GBuffer gbuffer;
  std::vector<Vec3> base;
  Film film;
  SessionStats stats;
  bool raster_is_stale = true;  ///< back end
  bool shadows_are_stale = true;
  bool gbuffer_is_stale = true;
  bool base_is_stale = true;    ///< light found with the G-buffer, outside of S
  uint32_t round = 0;           ///< of this film; each has its own draws
  bool frame_is_drawn = false;  ///< continuous target: S and pixel grid of `drawn_round` are in place
  uint32_t drawn_round = 0;
  std::vector<uint16_t> subset_visits;  ///< PassRequest::visits of the subset in hand; keeps its memory
  uint64_t alpha_tests_known = 0;       ///< of `stats.rays`, those that the stage's counter has
};

/// Throws Error (exit code 4) where the technique runs on OpenGL and there is to be none.
void check_backend(const RenderSettings&);

}  // namespace halflight
