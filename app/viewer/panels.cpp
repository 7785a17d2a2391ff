#include "viewer/panels.h"

#include <fmt/format.h>
#include <imgui.h>

#include <filesystem>

#include "film/tonemap.h"

namespace halflight {

namespace {

constexpr KeyHelp keys[] = {
    {"drag", "orbit"},
    {"right drag, shift drag", "pan"},
    {"wheel", "zoom"},
    {"R", "back to the scene's camera"},
    {"T", "next technique"},
    {"space", "pause"},
    {"[  ]", "exposure down, up by 1/2 EV"},
    {"S", "save a screenshot (PNG, and EXR of the radiance)"},
    {"Tab", "panels on, off"},
    {"H", "this help"},
    {"Esc", "close help, quit"},
    {"drop a file", ".glb or .gltf: open it; .hdr or .exr: light with it"},
};

template <class... Args>
void text(fmt::format_string<Args...> format, Args&&... args) {
  ImGui::TextUnformatted(fmt::format(format, std::forward<Args>(args)...).c_str());
}

/// A label on the left, a value on the right of a two-column table.
void row(const char* label, const std::string& value) {
  ImGui::TableNextRow();
  ImGui::TableNextColumn();
  ImGui::TextDisabled("%s", label);
  ImGui::TableNextColumn();
  ImGui::TextUnformatted(value.c_str());
}

bool begin_rows(const char* id) {
  if (!ImGui::BeginTable(id, 2)) return false;
  ImGui::TableSetupColumn("label", ImGuiTableColumnFlags_WidthFixed, ImGui::GetFontSize() * 7.5f);
  return true;
}

std::string count_text(double count) {
  if (count >= 1e6) return fmt::format("{:.2f} M", count / 1e6);
  if (count >= 1e4) return fmt::format("{:.1f} K", count / 1e3);
  return fmt::format("{:.0f}", count);
}

Changes technique_section(ViewerState& state) {
  Changes changes;
  if (!ImGui::CollapsingHeader("Technique", ImGuiTreeNodeFlags_DefaultOpen)) return changes;
  for (const TechniqueInfo& info : techniques()) {
    if (ImGui::RadioButton(std::string(info.id).c_str(), state.render.technique == info.id)) {
      state.render.technique = info.id;
      state.render.target.reset();
      changes.settings = true;
    }
    if (ImGui::IsItemHovered()) {
      const std::string tip =
          fmt::format("{}\n{}{}", info.title, info.source, info.bias == Bias::biased ? "\nbiased" : "");
      ImGui::SetTooltip("%s", tip.c_str());
    }
  }
  const TechniqueInfo& info = find_technique(state.render.technique);
  if (info.target == TargetSupport::both) {
    ImGui::Spacing();
    const Target target = choose_target(info, state.render.target);
    for (Target choice : {Target::discrete, Target::continuous}) {
      if (choice == Target::continuous) ImGui::SameLine();
      if (ImGui::RadioButton(std::string(target_name(choice)).c_str(), target == choice) &&
          target != choice) {
        state.render.target = choice;
        changes.settings = true;
      }
    }
  }
  ImGui::Spacing();
  int light = static_cast<int>(state.render.light);
  ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 5);
  if (ImGui::Combo("light", &light, "all\0direct\0indirect\0")) {
    state.render.light = static_cast<LightSelection>(light);
    changes.settings = true;
  }
  return changes;
}

/// One slider a setting of the technique in use.
Changes settings_section(ViewerState& state) {
  Changes changes;
  if (!ImGui::CollapsingHeader("Settings")) return changes;
  const auto slider = [&](const SettingInfo& info) {
    const std::string label(info.key.substr(info.key.find('.') + 1));
    ImGui::PushID(std::string(info.key).c_str());
    ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 8);
    const double value = state.render.values.get(info.key);
    std::string wanted;
    if (!info.choices.empty()) {
      const int index = static_cast<int>(value);
      if (ImGui::BeginCombo(label.c_str(), std::string(info.choices[index]).c_str())) {
        for (const auto& choice : info.choices)
          if (ImGui::Selectable(std::string(choice).c_str(), choice == info.choices[index])) wanted = choice;
        ImGui::EndCombo();
      }
    } else {
      double edited = value;
      const bool whole = std::floor(info.value) == info.value && info.high > 8;
      ImGui::InputDouble(label.c_str(), &edited, 0, 0, whole ? "%.0f" : "%.4g");
      if (ImGui::IsItemDeactivatedAfterEdit() && edited != value)
        wanted = fmt::format("{}", std::clamp(edited, info.low, info.high));
    }
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", std::string(info.help).c_str());
    if (!wanted.empty()) {
      state.render.values.set(info.key, wanted);
      changes.settings = true;
    }
    ImGui::PopID();
  };
  for (const SettingInfo& info : find_technique(state.render.technique).settings) slider(info);
  for (const SettingInfo& info : shared_settings()) slider(info);
  return changes;
}

/// Colour of brightness one beside a logarithmic intensity; returns whether either was edited.
bool edit_intensity(const char* id, Vec3& value, const char* unit) {
  ImGui::PushID(id);
  float level = max_component(value);
  Vec3 color = level > 0 ? value / level : Vec3(1);
  bool edited =
      ImGui::ColorEdit3("##color", &color.x, ImGuiColorEditFlags_NoInputs | ImGuiColorEditFlags_Float);
  ImGui::SameLine();
  ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 3);
  const std::string format = std::string("%.4g ") + unit;
  // The range follows the light: scenes come in any unit.
  const float reach = std::max(level, 1e-6f) * 4;
  edited |= ImGui::SliderFloat("##level", &level, 0, reach, format.c_str(), ImGuiSliderFlags_Logarithmic);
  if (edited) {
    const float brightest = max_component(color);
    value = brightest > 0 ? color * (std::max(level, 0.0f) / brightest) : Vec3(0);
  }
  ImGui::PopID();
  return edited;
}

Changes lights_section(ViewerState& state, const Snapshot& snapshot) {
  Changes changes;
  if (!ImGui::CollapsingHeader("Lights", ImGuiTreeNodeFlags_DefaultOpen)) return changes;
  for (size_t i = 0; i < state.lights.lights.size(); ++i) {
    PunctualLight& light = state.lights.lights[i];
    static constexpr const char* kind_names[] = {"point", "spot", "sun"};
    const char* kind = light.picture >= 0 ? "projector" : kind_names[static_cast<int>(light.kind)];
    text("{}", light.name.empty() ? fmt::format("{} {}", kind, i + 1) : light.name);
    changes.lights |= edit_intensity(fmt::format("light{}", i).c_str(), light.intensity,
                                     light.kind == PunctualKind::directional ? "lx" : "cd");
  }
  for (size_t i = 0; i < state.lights.emission.size(); ++i) {
    if (i >= snapshot.opened->lights.emission.size() ||
        max_component(snapshot.opened->lights.emission[i]) <= 0)
      continue;
    const std::string& name = snapshot.opened->material_names[i];
    text("{}", name.empty() ? fmt::format("emitter {}", i) : name);
    changes.lights |= edit_intensity(fmt::format("emission{}", i).c_str(), state.lights.emission[i], "nt");
  }
  if (!snapshot.opened->environment_name.empty()) {
    ImGui::Spacing();
    text("{}", std::filesystem::path(snapshot.opened->environment_name).filename().string());
    float degrees = glm::degrees(state.lights.environment_rotation);
    ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 5);
    if (ImGui::SliderFloat("rotation", &degrees, -180, 180, "%.0f deg")) {
      state.lights.environment_rotation = glm::radians(degrees);
      changes.lights = true;
    }
    ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 5);
    changes.lights |= ImGui::SliderFloat("strength", &state.lights.environment_strength, 0, 20, "%.3f",
                                         ImGuiSliderFlags_Logarithmic);
  }
  if (state.lights.lights.empty() && snapshot.opened->environment_name.empty())
    ImGui::TextDisabled("drop an .hdr or .exr to light the scene");
  return changes;
}

Changes display_section(ViewerState& state) {
  Changes changes;
  if (!ImGui::CollapsingHeader("Display", ImGuiTreeNodeFlags_DefaultOpen)) return changes;
  ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 5);
  changes.display |= ImGui::SliderFloat("exposure", &state.ev, -12, 12, "%+.1f EV");
  ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 5);
  if (ImGui::BeginCombo("tone map", std::string(find_tone_map(state.tonemap).title).c_str())) {
    for (const ToneMap& map : tone_maps()) {
      if (ImGui::Selectable(std::string(map.title).c_str(), map.id == state.tonemap)) {
        state.tonemap = map.id;
        changes.display = true;
      }
    }
    ImGui::EndCombo();
  }
  changes.screenshot |= ImGui::Button("Screenshot (S)");
  ImGui::SameLine();
  if (ImGui::Button(state.paused ? "Resume" : "Pause")) {
    state.paused = !state.paused;
    changes.paused = true;
  }
  return changes;
}

Changes camera_section(ViewerState& state, const Snapshot& snapshot) {
  Changes changes;
  if (!ImGui::CollapsingHeader("Camera")) return changes;
  for (size_t i = 0; i < snapshot.opened->cameras.size(); ++i) {
    const Camera& camera = snapshot.opened->cameras[i];
    const std::string name = camera.generated      ? "framed view"
                             : camera.name.empty() ? fmt::format("camera {}", i)
                                                   : camera.name;
    if (ImGui::Selectable(fmt::format("{}##{}", name, i).c_str())) {
      state.camera = camera;
      changes.camera = true;
    }
  }
  if (state.camera.projection == Projection::perspective) {
    float degrees = glm::degrees(state.camera.vertical_fov);
    ImGui::SetNextItemWidth(-ImGui::GetFontSize() * 7);
    if (ImGui::SliderFloat("field of view", &degrees, 5, 120, "%.0f deg")) {
      state.camera.vertical_fov = glm::radians(degrees);
      changes.camera = true;
    }
  }
  return changes;
}

void statistics_section(const Snapshot& snapshot) {
  if (!ImGui::CollapsingHeader("Statistics", ImGuiTreeNodeFlags_DefaultOpen)) return;
  if (begin_rows("statistics")) {
    row("samples", fmt::format("{:.1f} a pixel", snapshot.mean_samples));
    row("time", fmt::format("{:.1f} s", snapshot.seconds));
    row("est. relMSE",
        snapshot.estimated_relmse >= 0 ? fmt::format("{:.2e}", snapshot.estimated_relmse) : "not yet");
    row("target", std::string(target_name(snapshot.target)));
    row("lights, cut",
        fmt::format("{}, {}", count_text(snapshot.stats.light_count), snapshot.stats.cut_size));
    row("triangles", count_text(static_cast<double>(snapshot.opened->triangles)));
    const double tracing = snapshot.stats.seconds.sampling + snapshot.stats.seconds.visibility;
    if (tracing > 0)
      row("shadow rays",
          fmt::format("{}/s", count_text(static_cast<double>(snapshot.stats.rays.visibility) / tracing)));
    row("g-buffer", snapshot.opened->gl ? "OpenGL, " + snapshot.opened->gl->backend : "rays");
    if (snapshot.nan_samples > 0) row("NaN samples", std::to_string(snapshot.nan_samples));
    ImGui::EndTable();
  }
}

void plan_section(const Snapshot& snapshot) {
  if (!ImGui::CollapsingHeader("Plan")) return;
  for (const PlanStage& stage : snapshot.plan.stages) {
    if (stage.runs)
      text("{}", stage_name(stage.stage));
    else
      ImGui::TextDisabled("%s", std::string(stage_name(stage.stage)).c_str());
    ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyleColorVec4(ImGuiCol_TextDisabled));
    ImGui::Indent();
    ImGui::TextWrapped("%s", stage.why.c_str());
    ImGui::Unindent();
    ImGui::PopStyleColor();
  }
}

Changes side_panel(ViewerState& state, const Snapshot& snapshot) {
  const ImGuiViewport* viewport = ImGui::GetMainViewport();
  const float width = side_panel_width();
  ImGui::SetNextWindowPos({viewport->WorkPos.x + viewport->WorkSize.x - width, viewport->WorkPos.y});
  ImGui::SetNextWindowSize({width, viewport->WorkSize.y});
  Changes changes;
  if (ImGui::Begin("##panel", nullptr,
                   ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                       ImGuiWindowFlags_NoSavedSettings)) {
    text("{}", std::filesystem::path(snapshot.opened->name).filename().string());
    ImGui::Spacing();
    statistics_section(snapshot);
    changes |= technique_section(state);
    changes |= lights_section(state, snapshot);
    changes |= display_section(state);
    changes |= camera_section(state, snapshot);
    changes |= settings_section(state);
    plan_section(snapshot);
  }
  ImGui::End();
  return changes;
}

/// A borderless box of text centred at a fraction of the picture.
void overlay(const char* id, const std::string& message, float fraction_y) {
  const ImGuiViewport* viewport = ImGui::GetMainViewport();
  ImGui::SetNextWindowPos({viewport->WorkPos.x + viewport->WorkSize.x / 2,
                           viewport->WorkPos.y + viewport->WorkSize.y * fraction_y},
                          ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowBgAlpha(0.8f);
  if (ImGui::Begin(id, nullptr,
                   ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize |
                       ImGuiWindowFlags_NoInputs | ImGuiWindowFlags_NoSavedSettings |
                       ImGuiWindowFlags_NoFocusOnAppearing))
    ImGui::TextUnformatted(message.c_str());
  ImGui::End();
}

void help_overlay() {
  const ImGuiViewport* viewport = ImGui::GetMainViewport();
  ImGui::SetNextWindowPos({viewport->WorkPos.x + 24, viewport->WorkPos.y + 24});
  ImGui::SetNextWindowBgAlpha(0.9f);
  if (ImGui::Begin("##help", nullptr,
                   ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_AlwaysAutoResize |
                       ImGuiWindowFlags_NoSavedSettings)) {
    ImGui::TextUnformatted("Halflight: keys");
    ImGui::Separator();
    if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit)) {
      for (const KeyHelp& key : keys) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(key.key);
        ImGui::TableNextColumn();
        ImGui::TextDisabled("%s", key.action);
      }
      ImGui::EndTable();
    }
  }
  ImGui::End();
}

void error_dialog(ViewerState& state) {
  if (state.error_text.empty()) return;
  if (!ImGui::IsPopupOpen("Could not do that")) ImGui::OpenPopup("Could not do that");
  const ImGuiViewport* viewport = ImGui::GetMainViewport();
  ImGui::SetNextWindowPos(
      {viewport->WorkPos.x + viewport->WorkSize.x / 2, viewport->WorkPos.y + viewport->WorkSize.y / 2},
      ImGuiCond_Always, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({std::min(560.0f, viewport->WorkSize.x - 40), 0});
  if (ImGui::BeginPopupModal("Could not do that", nullptr,
                             ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoSavedSettings)) {
    ImGui::TextWrapped("%s", state.error_text.c_str());
    ImGui::Spacing();
    if (ImGui::Button("Close", {120, 0}) || ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Escape)) ||
        ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Enter))) {
      state.error_text.clear();
      ImGui::CloseCurrentPopup();
    }
    ImGui::EndPopup();
  }
}

void use_readable_font(float scale) {
  // Debian's fonts-dejavu-core; ImGui's own bitmap font where it is absent.
  static constexpr const char* path = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
  std::error_code ignored;
  ImGuiIO& io = ImGui::GetIO();
  if (std::filesystem::exists(path, ignored)) io.Fonts->AddFontFromFileTTF(path, std::round(15 * scale));
}

}  // namespace

std::span<const KeyHelp> key_help() { return keys; }

float side_panel_width() {
  // A small window still shows mostly picture.
  constexpr float most_of_window = 0.45f;
  return std::min(panel_width, most_of_window * ImGui::GetMainViewport()->WorkSize.x);
}

void set_panel_style(float scale) {
  ImGui::StyleColorsDark();
  ImGuiStyle& style = ImGui::GetStyle();
  style.WindowPadding = {16, 14};
  style.FramePadding = {8, 4};
  style.ItemSpacing = {8, 7};
  style.CellPadding = {4, 2};
  style.WindowRounding = style.PopupRounding = 6;
  style.FrameRounding = style.GrabRounding = 4;
  style.WindowBorderSize = style.FrameBorderSize = 0;
  style.ScrollbarSize = 12;
  const ImVec4 ground(0.085f, 0.088f, 0.095f, 1), raised(0.16f, 0.165f, 0.18f, 1),
      warm(0.93f, 0.62f, 0.28f, 1);
  const auto faded = [](ImVec4 color, float alpha) { return ImVec4(color.x, color.y, color.z, alpha); };
  ImVec4* colors = style.Colors;
  colors[ImGuiCol_Text] = {0.90f, 0.89f, 0.87f, 1};
  colors[ImGuiCol_TextDisabled] = {0.56f, 0.56f, 0.56f, 1};
  colors[ImGuiCol_WindowBg] = colors[ImGuiCol_PopupBg] = ground;
  colors[ImGuiCol_FrameBg] = colors[ImGuiCol_Button] = raised;
  colors[ImGuiCol_FrameBgHovered] = colors[ImGuiCol_ButtonHovered] = faded(warm, 0.30f);
  colors[ImGuiCol_FrameBgActive] = colors[ImGuiCol_ButtonActive] = faded(warm, 0.45f);
  colors[ImGuiCol_Header] = {0.13f, 0.135f, 0.145f, 1};
  colors[ImGuiCol_HeaderHovered] = faded(warm, 0.25f);
  colors[ImGuiCol_HeaderActive] = faded(warm, 0.40f);
  colors[ImGuiCol_TitleBgActive] = raised;
  colors[ImGuiCol_CheckMark] = colors[ImGuiCol_SliderGrab] = warm;
  colors[ImGuiCol_SliderGrabActive] = {1, 0.75f, 0.45f, 1};
  style.ScaleAllSizes(scale);
  use_readable_font(scale);
}

Changes draw_panels(ViewerState& state, const Snapshot* snapshot, bool loading, double now) {
  Changes changes;
  if (snapshot && state.show_panels) changes |= side_panel(state, *snapshot);
  if (state.show_help) help_overlay();
  if (loading)
    overlay("##loading", snapshot ? "Loading ..." : "Opening the scene ...", snapshot ? 0.08f : 0.5f);
  if (now < state.toast_until) overlay("##toast", state.toast, 0.95f);
  error_dialog(state);
  return changes;
}

}  // namespace halflight
