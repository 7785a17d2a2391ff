#include "session.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "core/parallel.h"
#include "core/random.h"
#include "core/stopwatch.h"
#include "core/timeline.h"
#include "core/vector_bytes.h"
#include "film/preview.h"
#include "trace/ray_gbuffer.h"

namespace halflight {

namespace {

/// Whether the machine shows a graphics device at all; without one OpenGL would be a software rasteriser.
bool has_graphics_device() {
  std::error_code ignored;
  return std::filesystem::exists("/dev/dri", ignored) || std::filesystem::exists("/dev/nvidia0", ignored) ||
         std::filesystem::exists("/dev/dxg", ignored);
}

bool needs_gl(const RenderSettings& settings) {
  return find_technique(settings.technique).device == Device::gpu;
}

/// Of the rays that light a surface point, as a divisor.
constexpr int draft_light_share = 16;

/// Throws Error (exit code 4) where the technique runs on OpenGL and there is to be none.
void check_backend(const RenderSettings& settings) {
  if (settings.backend != Backend::none || !needs_gl(settings)) return;
  throw Error(
      ExitCode::no_gl,
      fmt::format("technique '{}' runs on OpenGL, and the back end asked for is none", settings.technique));
}

bool group_changed(const SettingValues& a, const SettingValues& b, std::span<const SettingInfo> group) {
  return std::any_of(group.begin(), group.end(),
                     [&](const SettingInfo& info) { return a.get(info.key) != b.get(info.key); });
}

/// Position inside the pixel of round `pass`, relative to its centre (Roberts 2018, the R2 sequence), moved
/// by a shift that the seed gives: each position is uniform over seeds. Every other pair of rounds mirrors
/// the pair before it, so that the mean of a few rounds is the centre; pairs, for rounds go to the two halves
/// of the film in turn.
Vec2 pixel_jitter(uint32_t pass, uint64_t seed) {
  const Vec2 shift = RandomStream(0, 0, hash_combine(seed, 0x6a6974746572ull)).next2();
  const double n = pass / 4 * 2 + pass % 2 + 1;
  const float side = pass / 2 % 2 == 0 ? 1.0f : -1.0f;
  const auto place = [&](double x) {
    return std::min(side * static_cast<float>(x - std::floor(x) - 0.5), std::nextafter(0.5f, 0.0f));
  };
  return {place(n * 0.7548776662466927 + shift.x), place(n * 0.5698402909980532 + shift.y)};
}

}  // namespace

struct Session::Impl {
  Impl(Scene scene_in, const RenderSettings& settings_in, Messages& messages_in)
      : scene(std::move(scene_in)), settings(settings_in), messages(messages_in) {}

  // What must be redone before the next pass.
  struct Stale {
    bool raster = true;   ///< back end
    bool points = true;   ///< positions of S
    bool lights = true;   ///< radiances of S
    bool shadows = true;  ///< shadow maps
    bool gbuffer = true;
    bool technique = true;
  };

  Target target() const { return choose_target(find_technique(settings.technique), settings.target); }

  void open_backend();
  void make_rasterizer(Backend backend);
  void drop_rasterizer(const std::string& why);
  void replan();
  void prepare();
  void prepare_lights();
  void leave_lights_out();
  void prepare_gbuffer();
  void light_gbuffer(uint32_t alpha_seed);
  void draw_shadow_maps();
  void drop_what_is_left_out();
  void count_call(Stage, double seconds = 0);
  void count_held(const PassStats&);
  std::vector<Vec3> irradiance(const std::vector<BouncePoint>& points, uint64_t seed);
  FrameView view() const;
  void run_pass(PassRequest, bool ends_round);

  Scene scene;
  RenderSettings settings;
  Messages& messages;
  std::unique_ptr<RayScene> rays;
  std::unique_ptr<GlContext> context;
  std::unique_ptr<Rasterizer> rasterizer;  ///< kept, once made, for the next technique that needs it
  Backend opened_backend = Backend::none;  ///< what `rasterizer` was made for
  std::optional<GlDescription> gl;         ///< while `rasterizer` draws the G-buffer
  std::string why_backend;
  Camera camera;
  Plan plan;
  LightStage lights;
  GBuffer gbuffer;
  std::vector<Vec3> base;
  std::unique_ptr<Technique> technique;
  Film film;
  SessionStats stats;
  Stale stale;
  uint32_t round = 0;  ///< of this film; each has its own draws
  LightQuality light_quality = LightQuality::full;
  bool lights_are_made = false;  ///< `lights` holds S
  bool frame_is_drawn = false;   ///< continuous target: S and pixel grid of `drawn_round` are in place
  uint32_t drawn_round = 0;
  uint64_t alpha_tests_known = 0;  ///< of `stats.rays`, those that the stage's counter has
};

RenderSettings opening_settings(RenderSettings settings) {
  for (const auto& [key, most] : {std::pair("lights.count", 4096), std::pair("lights.repulsion", 0),
                                  std::pair("cut.most", 256), std::pair("cut.least", 64)})
    if (settings.values.get(key) > most) settings.values.set(key, std::to_string(most));
  return settings;
}

Session::Session(Scene scene, const RenderSettings& settings, Messages& messages) {
  Stopwatch watch;
  impl_ = std::make_unique<Impl>(std::move(scene), settings, messages);
  HALFLIGHT_CHECK(!impl_->scene.cameras.empty());
  find_technique(settings.technique);
  {
    const TimelineScope scope("ray tree");
    impl_->rays = std::make_unique<RayScene>(impl_->scene, settings.forced.has(Stage::alpha_filter));
  }
  complete_lights(impl_->scene, *impl_->rays, messages);
  impl_->camera = impl_->scene.cameras.front();
  impl_->film = Film(settings.width, settings.height);
  impl_->open_backend();
  impl_->replan();
  impl_->stats.stages[Stage::animation].calls = impl_->scene.facts.animations;
  impl_->stats.seconds.load = watch.seconds();
}

Session::~Session() = default;

void Session::Impl::open_backend() {
  gl.reset();
  if (settings.backend != opened_backend) rasterizer.reset(), context.reset();
  opened_backend = settings.backend;
  check_backend(settings);
  if (settings.backend == Backend::none)
    why_backend = "asked for";
  else if (settings.backend == Backend::automatic && !needs_gl(settings) && !has_graphics_device())
    why_backend = "this machine shows no graphics device, and rays beat a software rasteriser";
  else
    make_rasterizer(settings.backend);
  stale.raster = false;
  stale.gbuffer = stale.shadows = stale.lights = stale.technique = true;
}

void Session::Impl::make_rasterizer(Backend backend) {
  const bool needed = needs_gl(settings);
  try {
    if (!context) context = GlContext::make_headless(backend);
    if (backend == Backend::automatic && context->description().software && !needed) {
      why_backend =
          fmt::format("{} is a software rasteriser, and rays beat it", context->description().renderer);
      if (!rasterizer) context.reset();
      return;
    }
    if (!rasterizer) rasterizer = std::make_unique<Rasterizer>(*context, scene, RasterSettings{}, messages);
    gl = context->description();
    why_backend = backend != Backend::automatic ? "asked for"
                  : needed                      ? fmt::format("{} runs on OpenGL", settings.technique)
                                                : "a graphics device is there";
  } catch (const Error& error) {
    rasterizer.reset(), context.reset();
    if (needed && backend == Backend::automatic)
      throw Error(error.code(),
                  fmt::format("technique '{}' runs on OpenGL: {}", settings.technique, error.what()));
    if (backend != Backend::automatic) throw;
    why_backend = fmt::format("no OpenGL ({})", error.what());
  }
}

void Session::Impl::drop_rasterizer(const std::string& why) {
  messages.warn(fmt::format("OpenGL failed ({}); the picture goes on by rays", why));
  rasterizer.reset(), context.reset(), gl.reset();
  why_backend = "OpenGL failed";
  stale.gbuffer = stale.lights = true;
  replan();
}

void Session::Impl::replan() {
  const std::string raster =
      gl ? fmt::format("OpenGL {} ({}, {})", gl->version, gl->backend, gl->renderer) : "";
  plan = make_plan(scene_needs(scene),
                   {find_technique(settings.technique), target(), settings.light, settings.values, raster,
                    why_backend, settings.forced, settings.pixel_centres});
  drop_what_is_left_out();
}

/// A stage that is out holds nothing; when it comes back, it begins anew.
void Session::Impl::drop_what_is_left_out() {
  if (!plan.gbuffer) gbuffer = GBuffer(), base = std::vector<Vec3>(), stale.gbuffer = true;
  if (rasterizer && !plan.shadow_maps) rasterizer->drop_shadow_maps(), stale.shadows = true;
  if (rasterizer && !plan.runs.has(Stage::gpu_environment)) rasterizer->drop_filtered();
  for (size_t i = 0; i < stage_count; ++i)
    if (const Stage stage = static_cast<Stage>(i); !plan.runs.has(stage)) stats.stages[stage] = {};
}

void Session::Impl::count_call(Stage stage, double seconds) {
  ++stats.stages[stage].calls;
  stats.stages[stage].seconds += seconds;
}

/// Takes stock: bytes are those of now, whoever holds them.
void Session::Impl::count_held(const PassStats& pass) {
  StageCounters held;
  if (lights_are_made) held += lights.counters();
  if (plan.gbuffer) held[Stage::gbuffer].bytes = vector_bytes(gbuffer.texels, base);
  held[Stage::alpha_filter].bytes = rays->alpha_bytes();
  if (rasterizer) held[Stage::shadow_maps].bytes = rasterizer->shadow_map_bytes();
  if (rasterizer) held[Stage::gpu_environment].bytes = rasterizer->filtered_bytes();
  if (technique) technique->count_held(view(), held);
  for (size_t i = 0; i < stage_count; ++i) {
    const auto stage = static_cast<Stage>(i);
    StageCounter& counter = stats.stages[stage];
    counter.calls += pass.stages[stage].calls;
    counter.bytes = held[stage].bytes + pass.stages[stage].bytes;
  }
  stats.stages[Stage::alpha_filter].calls += stats.rays.alpha_tests - alpha_tests_known;
  alpha_tests_known = stats.rays.alpha_tests;
}

std::vector<Vec3> Session::Impl::irradiance(const std::vector<BouncePoint>& points, uint64_t seed) {
  PointLighting lighting;
  lighting.punctual = !plan.shadow_maps;
  lighting.samples = lighting_samples(static_cast<int>(settings.values.get("lights.samples")), points.size());
  if (light_quality == LightQuality::draft)
    lighting.samples = std::max(1, lighting.samples / draft_light_share);
  lighting.seed = seed;
  std::vector<Vec3> result = irradiance_by_rays(*rays, points, lighting, stats.rays);
  if (plan.shadow_maps) {
    draw_shadow_maps();
    const std::vector<Vec3> punctual = rasterizer->light_points(points);
    for (size_t i = 0; i < result.size(); ++i) result[i] += punctual[i];
  }
  // Points that are there by force send nothing: the picture must stay what it is.
  if (!plan.kinds.surfaces) result.assign(result.size(), Vec3(0));
  return result;
}

void Session::Impl::draw_shadow_maps() {
  if (!stale.shadows) return;
  Stopwatch watch;
  rasterizer->update_shadow_maps();
  stale.shadows = false;
  count_call(Stage::shadow_maps, watch.seconds());
}

void Session::Impl::prepare_lights() {
  if (!plan.light_set) return leave_lights_out();
  const bool redraw = plan.redraws && !frame_is_drawn;
  if (!stale.points && !stale.lights && !redraw) return;
  const TimelineScope scope("lights");
  Stopwatch watch;
  const uint64_t pass_seed = plan.redraws ? hash_combine(settings.seed, round + 1) : 0;
  const uint64_t lighting_seed =
      plan.redraws ? pass_seed : static_cast<uint64_t>(settings.values.get("lights.seed"));
  const LightPointsFunction light_points = [&](const std::vector<BouncePoint>& points) {
    return irradiance(points, lighting_seed);
  };
  if (stale.points || redraw)
    lights.build(scene, plan.set_kinds, settings.values, plan.cut, pass_seed, light_points);
  else
    lights.relight(scene, settings.values, plan.cut, light_points);
  for (size_t i = 0; i < stage_count; ++i) {
    const auto stage = static_cast<Stage>(i);
    stats.stages[stage].calls += lights.counters()[stage].calls;
    stats.stages[stage].seconds += lights.counters()[stage].seconds;
  }
  stale.points = stale.lights = false;
  stale.technique = lights_are_made = true;
  stats.light_count = static_cast<uint32_t>(lights.tree().lights.size());
  stats.cut_size = lights.cut().size;
  stats.seconds.lights += watch.seconds();
}

void Session::Impl::leave_lights_out() {
  if (lights_are_made) lights = LightStage();
  lights_are_made = false;
  stale.technique |= stale.points || stale.lights;
  stale.points = stale.lights = false;
  stats.light_count = stats.cut_size = 0;
}

void Session::Impl::prepare_gbuffer() {
  const bool again = plan.runs.has(Stage::antialiasing) && !frame_is_drawn;
  if (!plan.gbuffer || (!stale.gbuffer && !again)) return;
  const TimelineScope scope("raster");
  Stopwatch watch;
  gbuffer.resize(settings.width, settings.height);
  const Vec2 jitter = plan.antialiased ? pixel_jitter(round, settings.seed) : Vec2(0);
  const uint32_t alpha_seed = plan.antialiased ? round + 1 : 0;
  if (gl)
    rasterizer->draw_gbuffer(camera, jitter, alpha_seed, gbuffer);
  else
    trace_gbuffer(*rays, camera, jitter, alpha_seed, gbuffer, stats.rays);
  count_call(Stage::gbuffer, watch.seconds());
  if (plan.runs.has(Stage::antialiasing)) count_call(Stage::antialiasing);

  base.assign(gbuffer.pixel_count(), Vec3(0));
  if (plan.show_emission)
    for (size_t i = 0; i < base.size(); ++i)
      base[i] = gbuffer.texels[i].emission * gbuffer.texels[i].throughput;
  if (plan.direct_punctual) light_gbuffer(alpha_seed);
  stale.gbuffer = false;
  stats.seconds.raster += watch.seconds();
}

void Session::Impl::light_gbuffer(uint32_t alpha_seed) {
  if (plan.shadow_maps) draw_shadow_maps();
  Stopwatch watch;
  if (plan.shadow_maps)
    rasterizer->add_punctual(gbuffer, base);
  else
    add_punctual_by_rays(*rays, gbuffer, alpha_seed, base, stats.rays);
  count_call(Stage::direct_punctual, watch.seconds());
}

void Session::Impl::prepare() {
  if (stale.raster) {
    open_backend();
    replan();
  }
  try {
    prepare_lights();
    prepare_gbuffer();
  } catch (const Error& error) {
    if (error.code() != ExitCode::no_gl || !gl || needs_gl(settings)) throw;
    drop_rasterizer(error.what());
    prepare_lights();
    prepare_gbuffer();
  }
  frame_is_drawn = true;
  drawn_round = round;
  if (!technique) technique = find_technique(settings.technique).make();
  if (stale.technique) {
    const TimelineScope scope("distribution");
    Stopwatch watch;
    technique->prepare(view());
    stats.seconds.distribution += watch.seconds();
  }
  stale.technique = false;
}

FrameView Session::Impl::view() const {
  FrameView frame;
  frame.scene = &scene;
  frame.camera = &camera;
  frame.rays = rays.get();
  frame.raster = gl ? rasterizer.get() : nullptr;
  frame.gbuffer = plan.gbuffer ? &gbuffer : nullptr;
  frame.tree = &lights.tree();
  frame.cut = &lights.cut();
  frame.settings = &settings.values;
  frame.base = plan.gbuffer ? &base : nullptr;
  frame.base_has_emission = plan.show_emission;
  frame.base_has_punctual = plan.direct_punctual;
  frame.target = target();
  frame.kinds = plan.kinds;
  frame.light = settings.light;
  frame.seed = settings.seed;
  frame.alpha_seed = plan.antialiased ? round + 1 : 0;
  frame.stages = plan.runs, frame.forced = settings.forced;
  return frame;
}

uint32_t Session::round_samples(uint32_t total) const {
  const TechniqueInfo& technique = find_technique(impl_->settings.technique);
  if (technique.exact) return std::max(1u, total);
  constexpr uint32_t rounds_for_edges = 8, fewest_rounds = 4, most_in_a_round = 256;
  const uint32_t wanted = impl_->plan.redraws
                              ? std::max((total + rounds_for_edges - 1) / rounds_for_edges,
                                         std::min(total / fewest_rounds, technique.samples_a_round))
                              : total;
  return std::clamp(wanted, 1u, most_in_a_round);
}

void Session::run_pass(uint32_t samples, uint32_t stride, uint32_t offset, std::stop_token stop) {
  PassRequest request;
  request.samples = samples;
  request.stride = stride;
  request.offset = offset;
  request.begins_round = offset == 0;
  request.stop = std::move(stop);
  impl_->run_pass(std::move(request), offset + 1 == stride * stride);
}

void Session::run_pass(uint32_t samples, const PassPart& part, std::stop_token stop) {
  PassRequest request;
  request.samples = samples;
  request.chosen = part.chosen;
  request.begins_round = part.first;
  request.stop = std::move(stop);
  impl_->run_pass(std::move(request), part.last);
}

/// The rest of the request is the round's.
void Session::Impl::run_pass(PassRequest request, bool ends_round) {
  const TimelineScope scope("pass");
  if (drawn_round != round) frame_is_drawn = false;
  prepare();
  request.pass = round;
  if (plan.redraws) request.half = static_cast<int>(round & 1);
  PassStats pass;
  {
    const TimelineScope tracing("sampling");
    pass = technique->run_pass(view(), request, film);
  }

  const double threads = thread_count();
  stats.seconds.lights += pass.lights_seconds;
  stats.seconds.raster += pass.gbuffer_seconds / threads;
  stats.seconds.distribution += pass.distribution_seconds / threads;
  stats.seconds.sampling += pass.sampling_seconds / threads;
  stats.seconds.visibility += pass.visibility_seconds / threads;
  stats.seconds.resolve += pass.resolve_seconds / threads;
  stats.seconds.gpu += pass.gpu_seconds;
  stats.rays += pass.rays;
  stats.useful_rays += pass.useful_rays;
  count_held(pass);
  ++stats.passes;
  if (ends_round) ++round;
}

void Session::restart() {
  impl_->film = Film(impl_->settings.width, impl_->settings.height);
  impl_->round = 0;
  impl_->frame_is_drawn = false;
  const double load = impl_->stats.seconds.load;
  const SessionStats before = impl_->stats;
  impl_->stats = {};
  impl_->stats.seconds.load = load;
  impl_->stats.light_count = before.light_count;
  impl_->stats.cut_size = before.cut_size;
  impl_->stats.stages = before.stages;
  impl_->alpha_tests_known = 0;
}

void Session::start_over() {
  Impl& s = *impl_;
  s.technique.reset();
  s.stale.points = s.stale.lights = s.stale.shadows = s.stale.gbuffer = s.stale.technique = true;
  restart();
}

void Session::set_camera(const Camera& camera) {
  impl_->camera = camera;
  impl_->stale.gbuffer = true;
  restart();
}

void Session::set_settings(const RenderSettings& wanted) {
  Impl& s = *impl_;
  if (wanted == s.settings) return;
  check_backend(wanted);
  const RenderSettings before = std::exchange(s.settings, wanted);
  if (wanted.technique != before.technique) s.technique.reset();
  if (wanted.forced.has(Stage::alpha_filter) != before.forced.has(Stage::alpha_filter))
    s.rays = std::make_unique<RayScene>(s.scene, wanted.forced.has(Stage::alpha_filter));
  s.stale.technique = true;
  s.stale.raster |= wanted.backend != before.backend || needs_gl(wanted) != needs_gl(before);
  s.stale.gbuffer |=
      wanted.width != before.width || wanted.height != before.height || wanted.light != before.light;
  s.stale.points |= group_changed(wanted.values, before.values, shared_settings());

  const Plan plan = s.plan;
  s.replan();
  s.stale.gbuffer |= plan.gbuffer != s.plan.gbuffer || plan.direct_punctual != s.plan.direct_punctual ||
                     plan.shadow_maps != s.plan.shadow_maps || plan.antialiased != s.plan.antialiased;
  s.stale.points |= !(plan.set_kinds == s.plan.set_kinds) || plan.light_set != s.plan.light_set ||
                    plan.cut != s.plan.cut || plan.redraws != s.plan.redraws;
  restart();
}

void Session::edit_lights(const LightEdits& edits, LightQuality quality) {
  Impl& s = *impl_;
  s.light_quality = quality;
  HALFLIGHT_CHECK(edits.emission.size() == s.scene.materials.size());
  const LightEdits before = light_edits();
  s.scene.lights = edits.lights;
  s.scene.environment.rotation = edits.environment_rotation;
  s.scene.environment.strength = edits.environment_strength;
  for (size_t i = 0; i < edits.emission.size(); ++i) s.scene.materials[i].emission = edits.emission[i];

  const bool emission_changed = edits.emission != before.emission;
  if (emission_changed && s.rasterizer) s.rasterizer->update_materials();
  s.stale.shadows = s.stale.lights = s.stale.gbuffer = true;
  const LightKinds kinds = s.plan.set_kinds;
  s.replan();
  // Points on surfaces stay; all other members of S are placed anew with every re-lighting.
  s.stale.points |= !(kinds == s.plan.set_kinds);
  restart();
}

LightEdits Session::light_edits() const {
  const Scene& scene = impl_->scene;
  LightEdits edits{scene.lights, {}, scene.environment.rotation, scene.environment.strength};
  for (const Material& material : scene.materials) edits.emission.push_back(material.emission);
  return edits;
}

FrameView Session::frame() {
  impl_->prepare();
  return impl_->view();
}

const Scene& Session::scene() const { return impl_->scene; }
const RenderSettings& Session::settings() const { return impl_->settings; }
const Camera& Session::camera() const { return impl_->camera; }
const Plan& Session::plan() const { return impl_->plan; }
const std::optional<GlDescription>& Session::gl() const { return impl_->gl; }
const Film& Session::film() const { return impl_->film; }
ImageRgb Session::preview() const {
  const Impl& s = *impl_;
  return s.plan.gbuffer ? preview_picture(s.film, s.gbuffer, s.base) : s.film.preview();
}
double Session::estimated_relmse() const {
  const TechniqueInfo& technique = find_technique(impl_->settings.technique);
  return technique.exact && technique.bias == Bias::biased ? -1 : impl_->film.estimated_relmse();
}
const GBuffer& Session::gbuffer() const {
  Impl& s = *impl_;
  if (!s.plan.gbuffer && s.stale.gbuffer) {
    s.gbuffer.resize(s.settings.width, s.settings.height);
    trace_gbuffer(*s.rays, s.camera, Vec2(0), 0, s.gbuffer, s.stats.rays);
    s.stale.gbuffer = false;
  }
  return s.gbuffer;
}
const SessionStats& Session::stats() const { return impl_->stats; }

}  // namespace halflight
