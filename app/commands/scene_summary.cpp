#include "commands/scene_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "text_table.h"

namespace halflight {

namespace {

constexpr std::array<std::string_view, 4> model_names{"none", "ggx", "phong", "ashikhmin-shirley"};
constexpr std::array<std::string_view, 3> light_names{"point", "spot", "directional"};
constexpr std::array<std::string_view, 2> projection_names{"perspective", "orthographic"};

template <class Enum, size_t n>
std::string_view name_of(const std::array<std::string_view, n>& names, Enum value) {
  return names[static_cast<size_t>(value)];
}

double degrees(double radians) { return radians * 180 / 3.14159265358979323846; }

std::string vector_text(Vec3 v) { return fmt::format("({:.4g}, {:.4g}, {:.4g})", v.x, v.y, v.z); }
Json vector_json(Vec3 v) { return {finite_or_null(v.x), finite_or_null(v.y), finite_or_null(v.z)}; }

/// Counts that text and JSON share.
struct Census {
  std::array<size_t, 4> models{};
  size_t emissive = 0, transparent = 0, unlit = 0, emissive_triangles = 0, pixels = 0;
};

Census take_census(const Scene& scene) {
  Census census;
  for (const Material& material : scene.materials) {
    ++census.models[static_cast<size_t>(material.model)];
    census.emissive += material.emissive();
    census.transparent += material.alpha_mode != AlphaMode::opaque;
    census.unlit += material.unlit;
  }
  for (const uint32_t material : scene.triangle_material)
    census.emissive_triangles += scene.materials[material].emissive();
  for (const ImageRgba8& image : scene.images) census.pixels += image.bytes.size() / 4;
  return census;
}

std::string materials_text(const Scene& scene, const Census& census) {
  std::vector<std::string> parts;
  for (size_t i = 0; i < census.models.size(); ++i)
    if (census.models[i] > 0)
      parts.push_back(fmt::format("{} {}", grouped(census.models[i]), model_names[i]));
  if (census.emissive > 0)
    parts.push_back(fmt::format("{} emissive on {}", grouped(census.emissive),
                                counted(census.emissive_triangles, "triangle", "triangles")));
  if (census.transparent > 0)
    parts.push_back(fmt::format("{} masked or blended", grouped(census.transparent)));
  if (census.unlit > 0) parts.push_back(fmt::format("{} unlit", grouped(census.unlit)));
  return grouped(scene.materials.size()) + (parts.empty() ? "" : fmt::format(": {}", fmt::join(parts, ", ")));
}

std::string light_strength(const PunctualLight& light) {
  return fmt::format("{:.4g} {}", max_component(light.intensity),
                     light.kind == PunctualKind::directional ? "lux" : "candela");
}

std::vector<std::string> light_row(const PunctualLight& light, size_t index) {
  const float peak = max_component(light.intensity);
  std::vector<std::string> row{std::to_string(index), std::string(name_of(light_names, light.kind)),
                               light.name.empty() ? "-" : light.name, light_strength(light),
                               "colour " + vector_text(peak > 0 ? light.intensity / peak : light.intensity)};
  row.push_back(light.kind == PunctualKind::directional ? "along " + vector_text(light.direction)
                                                        : "at " + vector_text(light.position));
  std::string rest;
  if (light.kind == PunctualKind::spot)
    rest = fmt::format("cone {:.3g} to {:.3g} degrees", degrees(light.inner_cone), degrees(light.outer_cone));
  if (light.picture >= 0) rest += ", projects a picture";
  if (std::isfinite(light.range))
    rest += fmt::format("{}range {:.4g}", rest.empty() ? "" : ", ", light.range);
  row.push_back(rest);
  return row;
}

std::vector<std::string> camera_row(const Camera& camera, size_t index) {
  const std::string lens = camera.projection == Projection::perspective
                               ? fmt::format("{:.3g} degrees high", degrees(camera.vertical_fov))
                               : fmt::format("{:.4g} high", 2 * camera.half_height);
  return {std::to_string(index),
          std::string(name_of(projection_names, camera.projection)),
          camera.name.empty() ? "-" : camera.name,
          lens,
          "at " + vector_text(camera.position),
          camera.generated ? "made to frame the scene" : ""};
}

std::string environment_text(const Environment& environment) {
  if (!environment.present()) return "none";
  std::string text =
      fmt::format("{}, {}x{}, turned {:.4g} degrees, strength {:.4g}",
                  environment.name.empty() ? "unnamed" : environment.name, environment.map.width,
                  environment.map.height, degrees(environment.rotation), environment.strength);
  if (environment.bad_texels > 0)
    text += fmt::format(", {} set to 0", counted(environment.bad_texels, "bad texel", "bad texels"));
  return text;
}

std::vector<std::string> added(const SceneFacts& facts) {
  std::vector<std::string> things;
  if (facts.added_camera) things.emplace_back("camera");
  if (facts.added_sky) things.emplace_back("sky");
  if (facts.added_lamp) things.emplace_back("lamp");
  return things;
}

template <class Items, class Row>
std::string listing(const std::string& heading, const Items& items, Row row) {
  constexpr size_t longest = 40;
  std::vector<std::vector<std::string>> rows;
  for (size_t i = 0; i < items.size() && i < longest; ++i) rows.push_back(row(items[i], i));
  std::string text = fmt::format("\n{}\n", heading) + text_table(rows, "  ");
  if (items.size() > longest) text += fmt::format("  … and {} more\n", grouped(items.size() - longest));
  return items.empty() ? "" : text;
}

}  // namespace

std::string scene_text(const Scene& scene) {
  const Census census = take_census(scene);
  const SceneFacts& facts = scene.facts;
  std::vector<std::vector<std::string>> rows{
      {"Scene", facts.source},
      {"Geometry", fmt::format("{}, {}", counted(scene.triangles.size(), "triangle", "triangles"),
                               counted(scene.vertices.size(), "vertex", "vertices"))},
      {"Bounds", scene.bounds.empty()
                     ? "empty"
                     : fmt::format("{} to {}, size {}", vector_text(scene.bounds.low),
                                   vector_text(scene.bounds.high), vector_text(scene.bounds.extent()))},
      {"Materials", materials_text(scene, census)},
      {"Textures", scene.textures.empty()
                       ? "none"
                       : fmt::format("{} from {}, {:.3g} Mpixel", grouped(scene.textures.size()),
                                     counted(scene.images.size(), "image", "images"),
                                     static_cast<double>(census.pixels) / 1e6)},
      {"Environment", environment_text(scene.environment)},
      {"Lights",
       scene.lights.empty() ? "none" : counted(scene.lights.size(), "punctual light", "punctual lights")}};
  if (!facts.extensions_used.empty())
    rows.push_back({"Extensions", fmt::format("{}", fmt::join(facts.extensions_used, ", "))});
  if (!facts.ignored_extensions.empty())
    rows.push_back({"Ignored", fmt::format("{}", fmt::join(facts.ignored_extensions, ", "))});
  if (facts.skipped_primitives + facts.skipped_triangles > 0)
    rows.push_back(
        {"Skipped", fmt::format("{}, {}", counted(facts.skipped_primitives, "primitive", "primitives"),
                                counted(facts.skipped_triangles, "triangle", "triangles"))});
  if (const auto things = added(facts); !things.empty())
    rows.push_back({"Added", fmt::format("{}", fmt::join(things, ", "))});
  return text_table(rows) + listing("Punctual lights", scene.lights, light_row) +
         listing("Cameras", scene.cameras, camera_row);
}

Json scene_json(const Scene& scene) {
  const Census census = take_census(scene);
  const SceneFacts& facts = scene.facts;
  Json models = Json::object();
  for (size_t i = 0; i < census.models.size(); ++i) models[std::string(model_names[i])] = census.models[i];
  Json lights = Json::array();
  for (const PunctualLight& light : scene.lights)
    lights.push_back({{"name", light.name},
                      {"kind", name_of(light_names, light.kind)},
                      {"intensity", vector_json(light.intensity)},
                      {"position", vector_json(light.position)},
                      {"direction", vector_json(light.direction)},
                      {"range", finite_or_null(light.range)},
                      {"inner_cone", light.inner_cone},
                      {"outer_cone", light.outer_cone},
                      {"projects", light.picture >= 0}});
  Json cameras = Json::array();
  for (const Camera& camera : scene.cameras)
    cameras.push_back({{"name", camera.name},
                       {"projection", name_of(projection_names, camera.projection)},
                       {"position", vector_json(camera.position)},
                       {"direction", vector_json(-camera.back)},
                       {"vertical_fov", camera.vertical_fov},
                       {"generated", camera.generated}});
  Json environment = nullptr;
  if (scene.environment.present())
    environment = {{"name", scene.environment.name},         {"width", scene.environment.map.width},
                   {"height", scene.environment.map.height}, {"rotation", scene.environment.rotation},
                   {"strength", scene.environment.strength}, {"bad_texels", scene.environment.bad_texels}};
  return {{"scene", facts.source},
          {"triangles", scene.triangles.size()},
          {"vertices", scene.vertices.size()},
          {"bounds", scene.bounds.empty() ? Json(nullptr)
                                          : Json{{"low", vector_json(scene.bounds.low)},
                                                 {"high", vector_json(scene.bounds.high)}}},
          {"materials",
           {{"count", scene.materials.size()},
            {"models", models},
            {"emissive", census.emissive},
            {"transparent", census.transparent},
            {"unlit", census.unlit}}},
          {"emissive_triangles", census.emissive_triangles},
          {"textures", scene.textures.size()},
          {"images", scene.images.size()},
          {"image_pixels", census.pixels},
          {"environment", environment},
          {"lights", lights},
          {"cameras", cameras},
          {"extensions", {{"used", facts.extensions_used}, {"ignored", facts.ignored_extensions}}},
          {"skipped", {{"primitives", facts.skipped_primitives}, {"triangles", facts.skipped_triangles}}},
          {"added", added(facts)}};
}

}  // namespace halflight
