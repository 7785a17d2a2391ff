#include "viewer/viewer.h"

#include <fmt/format.h>
#include <imgui.h>

#include <filesystem>
#include <utility>

#include "film/image_writers.h"
#include "film/tonemap.h"
#include "viewer/camera_controls.h"

namespace halflight {

namespace {

/// The part of the window the panel leaves to the picture.
struct ViewArea {
  Vec2 origin, size;
};

ViewArea view_area(const ViewerState& state) {
  const ImGuiViewport* viewport = ImGui::GetMainViewport();
  const float panel = state.show_panels ? side_panel_width() : 0;
  return {{viewport->WorkPos.x, viewport->WorkPos.y},
          {std::max(viewport->WorkSize.x - panel, 16.0f), std::max(viewport->WorkSize.y, 16.0f)}};
}

/// First name of the form halflight-001.png that is free.
std::filesystem::path free_screenshot_name() {
  for (int i = 1;; ++i) {
    const std::filesystem::path path = fmt::format("halflight-{:03}.png", i);
    if (!std::filesystem::exists(path)) return path;
  }
}

bool ends_with_any(const std::string& path, std::initializer_list<const char*> endings) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return std::find(endings.begin(), endings.end(), ending) != endings.end();
}

}  // namespace

Viewer::Viewer(ViewerStart start, UiPainter& painter)
    : start_(std::move(start)),
      painter_(painter),
      render_(start_.loader, start_.render, start_.display, start_.sample_limit) {
  state_.render = start_.render;
  state_.ev = start_.display.ev;
  state_.tonemap = start_.display.tonemap;
}

void Viewer::frame(double now) {
  render_.rethrow_if_nothing_opened();
  take_notices(now);
  take_snapshot(now);
  draw_picture();
  Changes changes = std::exchange(from_keys_, {});
  changes |= move_camera();
  changes |= draw_panels(state_, snapshot_.get(), render_.busy_loading(), now);
  act(changes, now);
  if (!start_.fixed_size) follow_window(now);
}

void Viewer::take_notices(double now) {
  while (auto notice = render_.next_notice()) {
    if (notice->error)
      state_.error_text = notice->text;
    else
      toast(notice->text, now);
  }
}

void Viewer::take_snapshot(double now) {
  auto latest = render_.latest();
  if (!latest || latest == snapshot_) return;
  if (latest->scene_number != scene_number_) {
    scene_number_ = latest->scene_number;
    state_.camera = latest->opened->cameras.front();
    state_.lights = latest->opened->lights;
    state_.ev = latest->opened->display.ev;
    state_.tonemap = latest->opened->display.tonemap;
    resized_at_ = now;
  }
  snapshot_ = std::move(latest);
  picture_is_stale_ = true;
}

void Viewer::draw_picture() {
  if (!snapshot_) return;
  const ImageRgb& picture = snapshot_->picture;
  if (std::exchange(picture_is_stale_, false))
    painter_.set_picture(display_image(picture, state_.ev, find_tone_map(state_.tonemap)));
  const ViewArea area = view_area(state_);
  const float scale = std::min(area.size.x / picture.width, area.size.y / picture.height);
  const Vec2 size = Vec2(picture.width, picture.height) * scale;
  const Vec2 low = area.origin + 0.5f * (area.size - size), high = low + size;
  ImGui::GetBackgroundDrawList()->AddImage(painter_.picture(), {low.x, low.y}, {high.x, high.y});
}

Changes Viewer::move_camera() {
  Changes changes;
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantCaptureMouse || !snapshot_) return changes;
  const int height = static_cast<int>(view_area(state_).size.y);
  const Vec2 moved(io.MouseDelta.x, io.MouseDelta.y);
  const bool pan = ImGui::IsMouseDown(1) || ImGui::IsMouseDown(2) || (ImGui::IsMouseDown(0) && io.KeyShift);
  const Vec3 pivot = snapshot_->pivot;
  if ((moved.x != 0 || moved.y != 0) && (pan || ImGui::IsMouseDown(0))) {
    state_.camera = pan ? pan_by_drag(state_.camera, pivot, moved, height)
                        : orbit_by_drag(state_.camera, pivot, moved, height);
    changes.camera = true;
  }
  if (io.MouseWheel != 0) {
    state_.camera = zoom_by_wheel(state_.camera, pivot, io.MouseWheel);
    changes.camera = true;
  }
  return changes;
}

void Viewer::key(char key) {
  switch (key) {
    case 'H':
      state_.show_help = !state_.show_help;
      break;
    case '\t':
      state_.show_panels = !state_.show_panels;
      break;
    case 'S':
      from_keys_.screenshot = true;
      break;
    case 'T':
      from_keys_.next_technique = true;
      break;
    case 'R':
      from_keys_.reset_camera = true;
      break;
    case '[':
      state_.ev -= 0.5f, from_keys_.display = true;
      break;
    case ']':
      state_.ev += 0.5f, from_keys_.display = true;
      break;
    case ' ':
      state_.paused = !state_.paused, from_keys_.paused = true;
      break;
    case '\x1b':
      if (!state_.error_text.empty()) break;  // the dialog takes it
      if (state_.show_help)
        state_.show_help = false;
      else
        from_keys_.quit = true;
      break;
    default:
      break;
  }
}

void Viewer::drop(const std::string& path) {
  if (ends_with_any(path, {".hdr", ".exr", ".pic"})) {
    render_.open_environment(path, start_.load.limits);
  } else {
    render_.open([path, load = start_.load](Messages& messages, DisplaySettings&) {
      return load_scene(path, load, messages);
    });
  }
}

void Viewer::act(const Changes& changes, double now) {
  if (changes.next_technique) {
    const auto all = techniques();
    const auto current = std::find_if(all.begin(), all.end(), [&](const TechniqueInfo& info) {
      return info.id == state_.render.technique;
    });
    const size_t next = (static_cast<size_t>(current - all.begin()) + 1) % all.size();
    state_.render.technique = all[next].id;
    state_.render.target.reset();
    toast(fmt::format("{}: {}", all[next].id, all[next].title), now);
  }
  if (changes.reset_camera && snapshot_) state_.camera = snapshot_->opened->cameras.front();
  if (changes.settings || changes.next_technique) render_.set_settings(state_.render);
  if (changes.camera || changes.reset_camera) render_.set_camera(state_.camera);
  if (changes.lights) render_.edit_lights(state_.lights);
  if (changes.paused) render_.set_paused(state_.paused);
  picture_is_stale_ |= changes.display;
  if (changes.screenshot) save_screenshot(now);
  closing_ |= changes.quit;
}

void Viewer::follow_window(double now) {
  const ViewArea area = view_area(state_);
  const int width = static_cast<int>(area.size.x), height = static_cast<int>(area.size.y);
  if (width == state_.render.width && height == state_.render.height) {
    resized_at_ = now;
    return;
  }
  // A window being dragged to a new size changes every frame; the picture starts again when it rests.
  constexpr double rest_seconds = 0.2;
  if (now - resized_at_ < rest_seconds) return;
  state_.render.width = width, state_.render.height = height;
  render_.set_settings(state_.render);
}

bool Viewer::picture_fits() const {
  if (!snapshot_) return false;
  if (snapshot_->picture.width != state_.render.width || snapshot_->picture.height != state_.render.height)
    return false;
  const ViewArea area = view_area(state_);
  return start_.fixed_size || (static_cast<int>(area.size.x) == state_.render.width &&
                               static_cast<int>(area.size.y) == state_.render.height);
}

void Viewer::save_screenshot(double now) {
  if (!snapshot_) return;
  try {
    std::filesystem::path path = free_screenshot_name();
    ImageMetadata metadata;
    metadata.text["scene"] = snapshot_->opened->name;
    metadata.text["technique"] = snapshot_->technique;
    metadata.numbers["spp"] = snapshot_->mean_samples;
    write_image(path, snapshot_->picture, {state_.ev, state_.tonemap}, metadata);
    const std::string name = path.string();
    write_image(path.replace_extension(".exr"), snapshot_->picture, {}, metadata);
    toast(fmt::format("saved {} and .exr", name), now);
  } catch (const Error& error) {
    state_.error_text = error.what();
  }
}

void Viewer::toast(const std::string& text, double now) {
  state_.toast = text;
  state_.toast_until = now + 4;
}

std::string Viewer::title() const {
  if (!snapshot_) return "Halflight";
  std::string text =
      fmt::format("{} | {} | {:.0f} spp", std::filesystem::path(snapshot_->opened->name).filename().string(),
                  snapshot_->technique, snapshot_->mean_samples);
  if (snapshot_->estimated_relmse >= 0) text += fmt::format(" | relMSE {:.1e}", snapshot_->estimated_relmse);
  return text + " | Halflight";
}

}  // namespace halflight
