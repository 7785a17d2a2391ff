#include "viewer/render_thread.h"

#include <array>
#include <cmath>
#include <utility>

#include "core/timeline.h"
#include "film/preview.h"

namespace halflight {

namespace {

// A pass covers one of 16 subsets of the picture with all its samples: about 100 ms on two cores. Their order
// where they are interleaved: after 1, 4 and 16 of them every 4th, every 2nd and every pixel in x and y has
// samples. Blocks, the picture's other subsets, may come in any.
constexpr std::array<uint32_t, 16> subset_order{0, 10, 2, 8, 5, 7, 13, 1, 3, 4, 6, 9, 11, 12, 14, 15};
constexpr uint32_t first_round_samples = 4, most_round_samples = 16;
// Seconds that a draft is shown without another move before the picture follows.
constexpr double rest = 0.15;
// A draft is made as large as lets its first picture be there in this time, points and tree aside: more than
// eight a second while the camera moves on. In steps, so that it does not change with every picture.
constexpr double draft_seconds = 0.09;
constexpr float draft_step = 0.125f, least_draft_scale = 0.25f;
constexpr uint32_t only_round_samples = 40;  ///< where a pass gives all there is

Vec3 look_at_point(const Session& session) {
  const GBuffer& gbuffer = session.gbuffer();
  const Camera& camera = session.camera();
  if (gbuffer.pixel_count() > 0) {
    const GBufferTexel& texel =
        gbuffer.texels[static_cast<size_t>(gbuffer.height / 2) * gbuffer.width + gbuffer.width / 2];
    if (texel.hit()) return texel.position;
  }
  const Aabb& bounds = session.scene().bounds;
  if (bounds.empty()) return camera.position - camera.back;
  const float depth =
      std::max(glm::dot(camera.position - bounds.centre(), camera.back), 0.1f * bounds.diagonal());
  return camera.position - camera.back * depth;
}

std::shared_ptr<const SceneSummary> describe(const Session& session, const DisplaySettings& display) {
  const Scene& scene = session.scene();
  auto opened = std::make_shared<SceneSummary>();
  opened->name = scene.facts.source;
  opened->cameras = scene.cameras;
  for (const Material& material : scene.materials) opened->material_names.push_back(material.name);
  opened->lights = session.light_edits();
  opened->environment_name = scene.environment.present() ? scene.environment.name : "";
  opened->gl = session.gl();
  opened->triangles = scene.triangles.size();
  opened->display = display;
  return opened;
}

}  // namespace

float next_draft_scale(double seconds, float drawn, float before) {
  const auto fits = [&](float scale) { return seconds * square(scale / drawn) <= draft_seconds; };
  float scale = 1;
  while (scale > least_draft_scale && !fits(scale)) scale -= draft_step;
  // Back up only where that holds with some room.
  while (scale > before && !fits(1.1f * scale)) scale -= draft_step;
  return scale;
}

RenderThread::RenderThread(SceneLoader loader, const RenderSettings& settings, const DisplaySettings& display,
                           uint32_t sample_limit)
    : settings_(settings), display_(display), sample_limit_(sample_limit) {
  wishes_.open = std::move(loader);
  thread_ = std::thread([this] { loop(); });
}

RenderThread::~RenderThread() {
  {
    std::lock_guard lock(mutex_);
    quit_ = true;
    pass_stop_.request_stop();
  }
  changed_.notify_all();
  thread_.join();
}

void RenderThread::wish(const std::function<void(Wishes&)>& change) {
  {
    std::lock_guard lock(mutex_);
    change(wishes_);
    if (drops_pass()) pass_stop_.request_stop();
  }
  changed_.notify_all();
}

/// Whether what is wished for leaves no use for the pass in flight.
bool RenderThread::drops_pass() const { return quit_ || (wishes_.any() && (shown_ || !wishes_.moves())); }

void RenderThread::open(SceneLoader loader) {
  wish([&](Wishes& w) { w.open = std::move(loader); });
}

void RenderThread::open_environment(const std::string& path, const LoadLimits& limits) {
  // Runs on the render thread, where the session may be read.
  open([this, path, limits](Messages& messages, DisplaySettings&) {
    Environment environment = load_environment(path, limits, messages);
    Scene scene = session_ ? session_->scene() : Scene{};
    scene.environment = std::move(environment);
    if (session_) scene.cameras.insert(scene.cameras.begin(), session_->camera());
    return scene;
  });
}

void RenderThread::set_camera(const Camera& camera) {
  wish([&](Wishes& w) { w.camera = camera; });
}
void RenderThread::set_settings(const RenderSettings& settings) {
  wish([&](Wishes& w) { w.settings = settings; });
}
void RenderThread::edit_lights(const LightEdits& lights) {
  wish([&](Wishes& w) { w.lights = lights; });
}

void RenderThread::set_paused(bool paused) {
  {
    std::lock_guard lock(mutex_);
    paused_ = paused;
  }
  changed_.notify_all();
}

std::shared_ptr<const Snapshot> RenderThread::latest() const {
  std::lock_guard lock(mutex_);
  return latest_;
}

bool RenderThread::busy_loading() const {
  std::lock_guard lock(mutex_);
  return loading_ || wishes_.open.has_value();
}

void RenderThread::rethrow_if_nothing_opened() const {
  std::lock_guard lock(mutex_);
  if (nothing_opened_) std::rethrow_exception(nothing_opened_);
}

std::optional<RenderThread::Notice> RenderThread::next_notice() {
  std::lock_guard lock(mutex_);
  if (notices_.empty()) return {};
  Notice notice = std::move(notices_.front());
  notices_.pop_front();
  return notice;
}

void RenderThread::report(const std::string& text, bool error) {
  std::lock_guard lock(mutex_);
  notices_.push_back({text, error});
}

void RenderThread::loop() {
  for (;;) {
    Wishes wishes;
    bool run = false;
    {
      std::unique_lock lock(mutex_);
      const auto unfinished = [&] { return session_ && !paused_ && !done_; };
      changed_.wait(lock, [&] { return quit_ || wishes_.any() || unfinished(); });
      if (quit_) break;
      wishes = std::exchange(wishes_, {});
      loading_ = wishes.open.has_value();
      run = !paused_ || wishes.any();
      pass_stop_ = {};
      if (wishes.any()) shown_ = false;
    }
    try {
      if (wishes.any()) apply(std::move(wishes));
    } catch (const std::exception& error) {
      report(error.what(), true);
      std::lock_guard lock(mutex_);
      if (!session_) nothing_opened_ = std::current_exception();
    }
    {
      std::lock_guard lock(mutex_);
      loading_ = false;
    }
    try {
      if (session_ && run) run_one_pass();
    } catch (const std::exception& error) {
      report(error.what(), true);
      set_paused(true);  // what failed once would fail again at once
    }
  }
  session_.reset();
}

void RenderThread::apply(Wishes wishes) {
  if (wishes.open) open_scene(*wishes.open);
  if (!session_) return;
  if (wishes.settings) {
    session_->set_settings(*wishes.settings);
    settings_ = *wishes.settings;
  }
  if (wishes.lights && wishes.lights->emission.size() == session_->scene().materials.size())
    session_->edit_lights(*wishes.lights);
  if (wishes.camera) session_->set_camera(*wishes.camera);
  // Lights alone leave the G-buffer, and with it the draft's size.
  session_->set_draft(!wishes.settings,
                      wishes.camera || !session_->drafting() ? draft_scale_ : drawn_scale());
  moving_ = wishes.moves();
  begin_picture();
}

void RenderThread::begin_picture() {
  subset_ = rounds_ = 0;
  has_pass_ = done_ = false;
  since_restart_.lap();
}

void RenderThread::open_scene(const SceneLoader& loader) {
  Messages messages;
  // Built in full before the old one goes: a bad file leaves the old scene on screen.
  auto session = std::make_unique<Session>(loader(messages, display_), settings_, messages_);
  session_ = std::move(session);
  opened_ = describe(*session_, display_);
  ++scene_number_;
  for (const std::string& warning : messages.warnings) report(warning, false);
  for (const std::string& warning : std::exchange(messages_.warnings, {})) report(warning, false);
}

void RenderThread::run_one_pass() {
  std::stop_token stop;
  {
    std::lock_guard lock(mutex_);
    stop = pass_stop_.get_token();
    if (drops_pass()) return;
  }
  if (session_->drafting() && draft_is_done()) {
    session_->set_draft(false);
    begin_picture();
  }
  if (subset_ == 0) round_samples_ = next_round_samples();
  // A round's first pass may be one more, before those that have an order.
  const auto count = session_->subset_count(), before = count - static_cast<uint32_t>(subset_order.size());
  session_->run_subset(round_samples_, subset_ < before ? subset_ : before + subset_order[subset_ - before],
                       stop);
  if (stop.stop_requested()) return;
  if (++subset_ == count) subset_ = 0, ++rounds_;
  if (session_->drafting() && !has_pass_) learn_draft_scale();
  has_pass_ = true, done_ = converged();
  publish();
}

/// No more than there are already: while a round is under way its pixels have twice as many as the others at
/// most. The last gives what is left to the limit.
uint32_t RenderThread::next_round_samples() const {
  if (find_technique(session_->settings().technique).exact)
    return std::min(only_round_samples, sample_limit_);
  const auto given = static_cast<uint32_t>(std::lround(session_->film().mean_samples()));
  const uint32_t wanted = std::clamp(given, first_round_samples, most_round_samples);
  return std::clamp(sample_limit_ - std::min(given, sample_limit_), 1u, wanted);
}

/// A draft has been seen, and nothing moves any more.
bool RenderThread::draft_is_done() const { return has_pass_ && (!moving_ || since_shown_.seconds() >= rest); }

/// From what the first picture of a draft cost.
void RenderThread::learn_draft_scale() {
  const StageSeconds& seconds = session_->stats().seconds;
  if (!(seconds.raster > 0)) return;  // it had its G-buffer already
  const double spent =
      seconds.raster + seconds.distribution + seconds.sampling + seconds.visibility + seconds.resolve;
  draft_scale_ = next_draft_scale(spent, drawn_scale(), draft_scale_);
}

/// Of the film, over the picture's width.
float RenderThread::drawn_scale() const {
  return static_cast<float>(session_->film().width()) / static_cast<float>(session_->settings().width);
}

bool RenderThread::converged() const {
  // In the middle of a round some pixels have its samples and others do not.
  if (session_->drafting() || subset_ != 0) return false;
  return session_->film().mean_samples() >= sample_limit_ ||
         (rounds_ > 0 && find_technique(session_->settings().technique).exact);
}

void RenderThread::publish() {
  const TimelineScope scope("publish");
  auto snapshot = std::make_shared<Snapshot>();
  const Film& film = session_->film();
  snapshot->scene_number = scene_number_;
  snapshot->opened = opened_;
  snapshot->picture = session_->preview();
  snapshot->drawn_width = snapshot->picture.width, snapshot->drawn_height = snapshot->picture.height;
  const int width = session_->settings().width, height = session_->settings().height;
  if (snapshot->drawn_width != width || snapshot->drawn_height != height)
    snapshot->picture = resized(snapshot->picture, width, height);
  snapshot->camera = session_->camera();
  snapshot->lights = session_->light_edits();
  snapshot->stats = session_->stats();
  snapshot->plan = session_->plan();
  snapshot->technique = session_->settings().technique;
  snapshot->target = choose_target(find_technique(snapshot->technique), session_->settings().target);
  snapshot->mean_samples = film.mean_samples();
  snapshot->estimated_relmse = rounds_ > 0 && !session_->drafting() ? session_->estimated_relmse() : -1;
  snapshot->seconds = since_restart_.seconds();
  snapshot->nan_samples = film.nan_samples();
  snapshot->pivot = look_at_point(*session_);
  snapshot->converged = done_;
  std::lock_guard lock(mutex_);
  latest_ = std::move(snapshot);
  if (!std::exchange(shown_, true)) since_shown_.lap();
}

}  // namespace halflight
