// What a pass needs, made when it is stale: back end, plan, S, G-buffer, technique; and the pass itself.
#include <algorithm>
#include <filesystem>

#include "core/parallel.h"
#include "core/random.h"
#include "core/stopwatch.h"
#include "core/timeline.h"
#include "core/vector_bytes.h"
#include "session_impl.h"
#include "trace/ray_gbuffer.h"

namespace halflight {

namespace {

/// Whether the machine shows a graphics device at all; without one OpenGL would be a software rasteriser.
bool has_graphics_device() {
  std::error_code ignored;
  return std::filesystem::exists("/dev/dri", ignored) || std::filesystem::exists("/dev/nvidia0", ignored) ||
         std::filesystem::exists("/dev/dxg", ignored);
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

void Session::Impl::open_backend() {
  gl.reset();
  if (now->settings.backend != opened_backend) rasterizer.reset(), context.reset();
  opened_backend = now->settings.backend;
  check_backend(now->settings);
  if (now->settings.backend == Backend::none)
    why_backend = "asked for";
  else if (now->settings.backend == Backend::automatic && !now->needs_gl() && !has_graphics_device())
    why_backend = "this machine shows no graphics device, and rays beat a software rasteriser";
  else
    make_rasterizer(now->settings.backend);
  raster_is_stale = false;
  gbuffer_is_stale = shadows_are_stale = true;
  for (Rendition* rendition : {&picture, &draft}) rendition->stale_lights = rendition->stale_technique = true;
}

void Session::Impl::make_rasterizer(Backend backend) {
  const bool needed = now->needs_gl();
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
                  : needed                      ? fmt::format("{} runs on OpenGL", now->settings.technique)
                                                : "a graphics device is there";
  } catch (const Error& error) {
    rasterizer.reset(), context.reset();
    if (needed && backend == Backend::automatic)
      throw Error(error.code(),
                  fmt::format("technique '{}' runs on OpenGL: {}", now->settings.technique, error.what()));
    if (backend != Backend::automatic) throw;
    why_backend = fmt::format("no OpenGL ({})", error.what());
  }
}

void Session::Impl::drop_rasterizer(const std::string& why) {
  messages.warn(fmt::format("OpenGL failed ({}); the picture goes on by rays", why));
  rasterizer.reset(), context.reset(), gl.reset();
  why_backend = "OpenGL failed";
  gbuffer_is_stale = picture.stale_lights = draft.stale_lights = true;
  replan();
}

void Session::Impl::replan() {
  replan(picture);
  replan(draft);
  drop_what_is_left_out();
}

void Session::Impl::replan(Rendition& of) {
  const std::string by = gl ? fmt::format("OpenGL {} ({}, {})", gl->version, gl->backend, gl->renderer) : "";
  of.plan = make_plan(scene_needs(scene), {of.info(), of.target(), of.settings.light, of.settings.values, by,
                                           why_backend, of.settings.forced, of.settings.pixel_centres});
}

/// A stage that is out holds nothing; when it comes back, it begins anew.
void Session::Impl::drop_what_is_left_out() {
  if (!now->plan.gbuffer) gbuffer = GBuffer(), base = std::vector<Vec3>(), gbuffer_is_stale = true;
  if (rasterizer && !now->plan.shadow_maps && !(drafts && draft.plan.shadow_maps))
    rasterizer->drop_shadow_maps(), shadows_are_stale = true;
  if (rasterizer && !now->plan.runs.has(Stage::gpu_environment)) rasterizer->drop_filtered();
  for (size_t i = 0; i < stage_count; ++i)
    if (const Stage stage = static_cast<Stage>(i); !now->plan.runs.has(stage)) stats.stages[stage] = {};
}

void Session::Impl::count_call(Stage stage, double seconds) {
  ++stats.stages[stage].calls;
  stats.stages[stage].seconds += seconds;
}

/// Takes stock: bytes are those of now, whoever holds them.
void Session::Impl::count_held(const PassStats& pass) {
  StageCounters held;
  if (now->lights_are_made) held += now->lights.counters();
  if (now->plan.gbuffer) held[Stage::gbuffer].bytes = vector_bytes(gbuffer.texels, base);
  held[Stage::alpha_filter].bytes = rays->alpha_bytes();
  if (rasterizer) held[Stage::shadow_maps].bytes = rasterizer->shadow_map_bytes();
  if (rasterizer) held[Stage::gpu_environment].bytes = rasterizer->filtered_bytes();
  if (now->technique) now->technique->count_held(view(), held);
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
  lighting.punctual = !now->plan.shadow_maps;
  lighting.samples =
      lighting_samples(static_cast<int>(now->settings.values.get("lights.samples")), points.size());
  lighting.seed = seed;
  std::vector<Vec3> result = irradiance_by_rays(*rays, points, lighting, stats.rays);
  if (now->plan.shadow_maps) {
    draw_shadow_maps();
    const std::vector<Vec3> punctual = rasterizer->light_points(points);
    for (size_t i = 0; i < result.size(); ++i) result[i] += punctual[i];
  }
  // Points that are there by force send nothing: the picture must stay what it is.
  if (!now->plan.kinds.surfaces) result.assign(result.size(), Vec3(0));
  return result;
}

void Session::Impl::draw_shadow_maps() {
  if (!shadows_are_stale) return;
  Stopwatch watch;
  rasterizer->update_shadow_maps();
  shadows_are_stale = false;
  count_call(Stage::shadow_maps, watch.seconds());
}

void Session::Impl::prepare_lights() {
  if (!now->plan.light_set) return leave_lights_out();
  const bool redraw = now->plan.redraws && !frame_is_drawn;
  if (!now->stale_points && !now->stale_lights && !redraw) return;
  const TimelineScope scope("lights");
  Stopwatch watch;
  const uint64_t pass_seed = now->plan.redraws ? hash_combine(now->settings.seed, round + 1) : 0;
  const uint64_t lighting_seed =
      now->plan.redraws ? pass_seed : static_cast<uint64_t>(now->settings.values.get("lights.seed"));
  const LightPointsFunction light_points = [&](const std::vector<BouncePoint>& points) {
    return irradiance(points, lighting_seed);
  };
  if (now->stale_points || redraw)
    now->lights.build(scene, now->plan.set_kinds, now->settings.values, now->plan.cut, pass_seed,
                      light_points);
  else
    now->lights.relight(scene, now->settings.values, now->plan.cut, light_points);
  for (size_t i = 0; i < stage_count; ++i) {
    const auto stage = static_cast<Stage>(i);
    stats.stages[stage].calls += now->lights.counters()[stage].calls;
    stats.stages[stage].seconds += now->lights.counters()[stage].seconds;
  }
  now->stale_points = now->stale_lights = false;
  now->stale_technique = now->lights_are_made = true;
  stats.light_count = static_cast<uint32_t>(now->lights.tree().lights.size());
  stats.cut_size = now->lights.cut().size;
  stats.seconds.lights += watch.seconds();
}

void Session::Impl::leave_lights_out() {
  if (now->lights_are_made) now->lights = LightStage();
  now->lights_are_made = false;
  now->stale_technique |= now->stale_points || now->stale_lights;
  now->stale_points = now->stale_lights = false;
  stats.light_count = stats.cut_size = 0;
}

void Session::Impl::prepare_gbuffer() {
  const bool again = now->plan.runs.has(Stage::antialiasing) && !frame_is_drawn;
  // A draft's has its own size, and may be left behind by one that never was drawn.
  const bool has_size = gbuffer.width == now->settings.width && gbuffer.height == now->settings.height;
  const bool draws = gbuffer_is_stale || again || !has_size;
  if (!now->plan.gbuffer || (!draws && !base_is_stale)) return;
  const TimelineScope scope("raster");
  Stopwatch watch;
  const uint32_t alpha_seed = now->plan.antialiased ? round + 1 : 0;
  if (draws) draw_gbuffer(alpha_seed);
  base.resize(gbuffer.pixel_count());
  parallel_for(0, base.size(), 4096, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i)
      base[i] = now->plan.show_emission ? gbuffer.texels[i].emission * gbuffer.texels[i].throughput : Vec3(0);
  });
  if (now->plan.direct_punctual) light_gbuffer(alpha_seed);
  gbuffer_is_stale = base_is_stale = false;
  stats.seconds.raster += watch.seconds();
}

void Session::Impl::draw_gbuffer(uint32_t alpha_seed) {
  Stopwatch watch;
  gbuffer.resize(now->settings.width, now->settings.height);
  const Vec2 jitter = now->plan.antialiased ? pixel_jitter(round, now->settings.seed) : Vec2(0);
  if (gl)
    rasterizer->draw_gbuffer(camera, jitter, alpha_seed, gbuffer);
  else
    trace_gbuffer(*rays, camera, jitter, alpha_seed, gbuffer, stats.rays);
  count_call(Stage::gbuffer, watch.seconds());
  if (now->plan.runs.has(Stage::antialiasing)) count_call(Stage::antialiasing);
}

void Session::Impl::light_gbuffer(uint32_t alpha_seed) {
  if (now->plan.shadow_maps) draw_shadow_maps();
  Stopwatch watch;
  if (now->plan.shadow_maps)
    rasterizer->add_punctual(gbuffer, base);
  else
    add_punctual_by_rays(*rays, gbuffer, alpha_seed, base, stats.rays);
  count_call(Stage::direct_punctual, watch.seconds());
}

void Session::Impl::prepare() {
  if (raster_is_stale) {
    open_backend();
    replan();
  }
  try {
    prepare_lights();
    prepare_gbuffer();
  } catch (const Error& error) {
    if (error.code() != ExitCode::no_gl || !gl || now->needs_gl()) throw;
    drop_rasterizer(error.what());
    prepare_lights();
    prepare_gbuffer();
  }
  frame_is_drawn = true;
  drawn_round = round;
  if (!now->technique) now->technique = now->info().make();
  if (now->stale_technique) {
    const TimelineScope scope("distribution");
    Stopwatch watch;
    now->technique->prepare(view());
    stats.seconds.distribution += watch.seconds();
  }
  now->stale_technique = false;
}

FrameView Session::Impl::view() const {
  FrameView frame;
  frame.scene = &scene;
  frame.camera = &camera;
  frame.rays = rays.get();
  frame.raster = gl ? rasterizer.get() : nullptr;
  frame.gbuffer = now->plan.gbuffer ? &gbuffer : nullptr;
  frame.tree = &now->lights.tree();
  frame.cut = &now->lights.cut();
  frame.settings = &now->settings.values;
  frame.base = now->plan.gbuffer ? &base : nullptr;
  frame.base_has_emission = now->plan.show_emission;
  frame.base_has_punctual = now->plan.direct_punctual;
  frame.target = now->target();
  frame.kinds = now->plan.kinds;
  frame.light = now->settings.light;
  frame.seed = now->settings.seed;
  frame.alpha_seed = now->plan.antialiased ? round + 1 : 0;
  frame.stages = now->plan.runs, frame.forced = now->settings.forced;
  return frame;
}

/// The rest of the request is the round's.
void Session::Impl::run_pass(PassRequest request, bool ends_round) {
  const TimelineScope scope("pass");
  if (drawn_round != round) frame_is_drawn = false;
  prepare();
  request.pass = round;
  if (now->plan.redraws) request.half = static_cast<int>(round & 1);
  PassStats pass;
  {
    const TimelineScope tracing("sampling");
    pass = now->technique->run_pass(view(), request, film);
  }

  const double threads = thread_count();
  stats.seconds.lights += pass.lights_seconds;
  stats.seconds.positions += pass.gbuffer_seconds / threads;
  stats.seconds.distribution += pass.distribution_seconds / threads;
  stats.seconds.sampling += pass.sampling_seconds / threads;
  stats.seconds.visibility += pass.visibility_seconds / threads;
  stats.seconds.resolve += pass.resolve_seconds / threads;
  stats.seconds.gpu += pass.gpu_seconds;
  stats.rays += pass.rays;
  stats.useful_rays += pass.useful_rays;
  if (pass.light_count > 0) stats.light_count = pass.light_count, stats.cut_size = pass.cut_size;
  count_held(pass);
  ++stats.passes;
  if (ends_round) ++round;
}

}  // namespace halflight
