#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/stopwatch.h"
#include "core/timeline.h"
#include "film/preview.h"
#include "session_impl.h"
#include "trace/ray_gbuffer.h"

namespace halflight {

namespace {

bool group_changed(const SettingValues& a, const SettingValues& b, std::span<const SettingInfo> group) {
  return std::any_of(group.begin(), group.end(),
                     [&](const SettingInfo& info) { return a.get(info.key) != b.get(info.key); });
}

/// Whether what the camera sees, or the light found with it, must be made again.
bool another_frame(const Plan& a, const Plan& b) {
  return a.gbuffer != b.gbuffer || a.direct_punctual != b.direct_punctual || a.shadow_maps != b.shadow_maps ||
         a.antialiased != b.antialiased;
}

constexpr uint32_t subset_stride = 4, interleaved_subsets = subset_stride * subset_stride;

/// Of the places 0 … extent - 1 in runs of `side`, those of each fourth run, from run `first` on.
std::vector<uint32_t> every_fourth(uint32_t extent, uint32_t side, uint32_t first) {
  std::vector<uint32_t> places;
  for (uint32_t i = 0; i < extent; ++i)
    if (i / side % subset_stride == first) places.push_back(i);
  return places;
}

}  // namespace

void check_backend(const RenderSettings& settings) {
  if (settings.backend != Backend::none || find_technique(settings.technique).device != Device::gpu) return;
  throw Error(
      ExitCode::no_gl,
      fmt::format("technique '{}' runs on OpenGL, and the back end asked for is none", settings.technique));
}

void Rendition::take(const RenderSettings& wanted) {
  if (wanted == settings) return;
  if (wanted.technique != settings.technique) technique.reset();
  stale_technique = true;
  stale_points |= group_changed(wanted.values, settings.values, shared_settings());
  settings = wanted;
}

void Rendition::compare_set(const Plan& before) {
  stale_points |= !(before.set_kinds == plan.set_kinds) || before.light_set != plan.light_set ||
                  before.cut != plan.cut || before.redraws != plan.redraws;
}

RenderSettings draft_settings(RenderSettings settings) {
  const TechniqueInfo& info = find_technique(settings.technique);
  if (info.exact || info.traces_from_camera || info.device == Device::gpu) return settings;
  const TechniqueInfo& draft = info.draft_by.empty() ? info : find_technique(info.draft_by);
  settings.technique = draft.id;
  for (const auto& [key, value] : draft.draft_values) settings.values.set(key, value);
  if (draft.target == TargetSupport::both || draft.target == TargetSupport::discrete)
    settings.target = Target::discrete;
  for (const auto& [key, most] : {std::pair("lights.count", 4096), std::pair("lights.repulsion", 0),
                                  std::pair("cut.most", 256), std::pair("cut.least", 64)})
    if (settings.values.get(key) > most) settings.values.set(key, std::to_string(most));
  return settings;
}

Session::Impl::Impl(Scene scene_in, const RenderSettings& settings, Messages& messages_in)
    : scene(std::move(scene_in)), messages(messages_in) {
  picture.settings = settings;
  draft.settings = draft_settings(settings);
}

Session::Session(Scene scene, const RenderSettings& settings, Messages& messages) {
  Stopwatch watch;
  impl_ = std::make_unique<Impl>(std::move(scene), settings, messages);
  HALFLIGHT_CHECK(!impl_->scene.cameras.empty());
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

uint32_t Session::round_samples(uint32_t total) const {
  const TechniqueInfo& technique = impl_->picture.info();
  if (technique.exact) return std::max(1u, total);
  constexpr uint32_t rounds_for_edges = 8, fewest_rounds = 2, most_in_a_round = 256;
  const uint32_t wanted = impl_->picture.plan.redraws
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
  request.stop = std::move(stop);
  impl_->run_pass(std::move(request), offset + 1 == stride * stride);
}

/// Whether pixels side by side cost less than as many that lie apart.
bool Session::Impl::neighbours_share() const { return now->info().neighbours_share && !now->plan.redraws; }

uint32_t Session::subset_count() const {
  const bool begins_with_lattice = impl_->neighbours_share() && impl_->round == 0;
  return interleaved_subsets + (begins_with_lattice ? 1 : 0);
}

size_t Session::run_subset(uint32_t samples, uint32_t subset, std::stop_token stop) {
  const uint32_t count = subset_count();
  HALFLIGHT_CHECK(subset < count);
  const auto width = static_cast<uint32_t>(impl_->film.width()),
             height = static_cast<uint32_t>(impl_->film.height());
  if (!impl_->neighbours_share()) {
    run_pass(samples, subset_stride, subset, std::move(stop));
    return every_fourth(width, 1, subset % subset_stride).size() *
           every_fourth(height, 1, subset / subset_stride).size();
  }
  PassRequest request;
  request.samples = std::min<uint32_t>(samples, std::numeric_limits<uint16_t>::max());
  const bool has_lattice = count > interleaved_subsets;
  size_t pixels = 0;
  impl_->subset_visits.assign(size_t{width} * height, 0);
  const auto visit = [&](uint32_t side, uint32_t index, bool all) {
    for (const uint32_t y : every_fourth(height, side, index / subset_stride))
      for (const uint32_t x : every_fourth(width, side, index % subset_stride)) {
        if (!all && x % subset_stride == 0 && y % subset_stride == 0) continue;
        impl_->subset_visits[size_t{y} * width + x] = static_cast<uint16_t>(request.samples);
        ++pixels;
      }
  };
  // Blocks that techniques make things for, or parts of those where the picture has few.
  const uint32_t side = std::min(width, height) >= 64 ? 16 : 4;
  if (has_lattice && subset == 0)
    visit(1, 0, true);
  else
    visit(side, has_lattice ? subset - 1 : subset, !has_lattice);
  request.visits = impl_->subset_visits;
  request.stop = std::move(stop);
  impl_->run_pass(std::move(request), subset + 1 == count);
  return pixels;
}

void Session::run_visits(uint32_t most, std::span<const uint16_t> visits, std::stop_token stop) {
  HALFLIGHT_CHECK(!impl_->now->plan.redraws);
  PassRequest request;
  request.samples = most;
  request.visits = visits;
  request.stop = std::move(stop);
  impl_->run_pass(std::move(request), true);
}

void Session::restart() {
  Film& film = impl_->film;
  const RenderSettings& settings = impl_->now->settings;
  if (film.width() == settings.width && film.height() == settings.height)
    film.clear();  // new memory would have to be faulted in page by page
  else
    film = Film(settings.width, settings.height);
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
  for (Rendition* rendition : {&s.picture, &s.draft}) {
    rendition->technique.reset();
    rendition->stale_points = rendition->stale_lights = rendition->stale_technique = true;
  }
  s.shadows_are_stale = s.gbuffer_is_stale = true;
  restart();
}

void Session::set_draft(bool draft, float scale) {
  Impl& s = *impl_;
  Rendition& wanted = draft && has_draft() ? s.draft : s.picture;
  const bool resized = &wanted == &s.draft && s.resize_draft(scale);
  if (s.now == &wanted && !resized) return;
  s.drafts |= draft;
  s.gbuffer_is_stale |= another_frame(s.now->plan, wanted.plan) || resized ||
                        s.now->settings.width != wanted.settings.width ||
                        s.now->settings.height != wanted.settings.height;
  s.now = &wanted;
  s.drop_what_is_left_out();
  restart();
}

/// Whether that changes its size.
bool Session::Impl::resize_draft(float scale) {
  RenderSettings settings = draft.settings;
  const auto scaled = [&](int size) {
    return std::max(1, static_cast<int>(std::lround(std::min(scale, 1.0f) * static_cast<float>(size))));
  };
  settings.width = scaled(picture.settings.width), settings.height = scaled(picture.settings.height);
  if (settings == draft.settings) return false;
  draft.take(settings);
  return true;
}

bool Session::has_draft() const {
  return !(draft_settings(impl_->picture.settings) == impl_->picture.settings);
}
bool Session::drafting() const { return impl_->now == &impl_->draft; }

void Session::set_camera(const Camera& camera) {
  impl_->camera = camera;
  impl_->gbuffer_is_stale = true;
  restart();
}

void Session::set_settings(const RenderSettings& wanted) {
  Impl& s = *impl_;
  if (wanted == s.picture.settings) return;
  check_backend(wanted);
  const RenderSettings before = s.picture.settings;
  const RenderSettings draft = draft_settings(wanted);
  const Plan plan = s.now->plan, picture_plan = s.picture.plan, draft_plan = s.draft.plan;
  const bool needed_gl = s.picture.needs_gl();
  s.picture.take(wanted);
  s.draft.take(draft);
  if (!has_draft()) s.now = &s.picture;
  if (wanted.forced.has(Stage::alpha_filter) != before.forced.has(Stage::alpha_filter))
    s.rays = std::make_unique<RayScene>(s.scene, wanted.forced.has(Stage::alpha_filter));
  s.raster_is_stale |= wanted.backend != before.backend || s.picture.needs_gl() != needed_gl;
  s.replan();
  s.picture.compare_set(picture_plan);
  s.draft.compare_set(draft_plan);
  s.gbuffer_is_stale |= wanted.width != before.width || wanted.height != before.height ||
                        wanted.light != before.light || another_frame(plan, s.now->plan);
  restart();
}

void Session::edit_lights(const LightEdits& edits) {
  Impl& s = *impl_;
  HALFLIGHT_CHECK(edits.emission.size() == s.scene.materials.size());
  const LightEdits before = light_edits();
  s.scene.lights = edits.lights;
  s.scene.environment.rotation = edits.environment_rotation;
  s.scene.environment.strength = edits.environment_strength;
  for (size_t i = 0; i < edits.emission.size(); ++i) s.scene.materials[i].emission = edits.emission[i];

  const bool emission_changed = edits.emission != before.emission;
  if (emission_changed && s.rasterizer) s.rasterizer->update_materials();
  // Lamps are not seen: what the camera sees of light is emission and the environment.
  s.gbuffer_is_stale |= emission_changed || (s.scene.environment.present() &&
                                             (edits.environment_rotation != before.environment_rotation ||
                                              edits.environment_strength != before.environment_strength));
  s.base_is_stale = s.shadows_are_stale = true;
  const LightKinds kinds = s.picture.plan.set_kinds, draft_kinds = s.draft.plan.set_kinds;
  s.replan();
  // Points on surfaces stay; all other members of S are placed anew with every re-lighting.
  s.picture.stale_lights = s.draft.stale_lights = true;
  s.picture.stale_points |= !(kinds == s.picture.plan.set_kinds);
  s.draft.stale_points |= !(draft_kinds == s.draft.plan.set_kinds);
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
const RenderSettings& Session::settings() const { return impl_->picture.settings; }
const Camera& Session::camera() const { return impl_->camera; }
const Plan& Session::plan() const { return impl_->picture.plan; }
const std::optional<GlDescription>& Session::gl() const { return impl_->gl; }
const Film& Session::film() const { return impl_->film; }
ImageRgb Session::preview() const {
  const Impl& s = *impl_;
  return s.now->plan.gbuffer ? preview_picture(s.film, s.gbuffer, s.base) : s.film.preview();
}
double Session::estimated_relmse() const {
  const TechniqueInfo& technique = impl_->now->info();
  return technique.exact && technique.bias == Bias::biased ? -1 : impl_->film.estimated_relmse();
}
const GBuffer& Session::gbuffer() const {
  Impl& s = *impl_;
  if (!s.now->plan.gbuffer && s.gbuffer_is_stale) {
    s.gbuffer.resize(s.now->settings.width, s.now->settings.height);
    trace_gbuffer(*s.rays, s.camera, Vec2(0), 0, s.gbuffer, s.stats.rays);
    s.gbuffer_is_stale = false;
  }
  return s.gbuffer;
}
const SessionStats& Session::stats() const { return impl_->stats; }

}  // namespace halflight
