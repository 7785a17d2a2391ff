#include "scene/view_file.h"

#include <initializer_list>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "scene/camera.h"
#include "scene/image_files.h"

namespace halflight {

namespace {

using Json = nlohmann::json;
namespace fs = std::filesystem;

constexpr uint64_t largest_view = 64 << 20;  // bytes

/// A JSON value with where it stands, for messages.
struct Node {
  const Json* json;
  std::string file, place;

  [[noreturn]] void fail(std::string_view reason) const { throw input_error(file, place, reason); }

  Node at(const std::string& key) const {
    return {&json->at(key), file, place.empty() ? key : fmt::format("{}.{}", place, key)};
  }
  Node at(size_t index) const { return {&json->at(index), file, fmt::format("{}[{}]", place, index)}; }
  bool has(const char* key) const { return json->contains(key); }

  /// An object with no keys but these.
  void expect_keys(std::initializer_list<const char*> keys) const {
    if (!json->is_object()) fail("must be an object");
    const std::vector<std::string> valid(keys.begin(), keys.end());
    for (const auto& [key, value] : json->items())
      if (std::find(valid.begin(), valid.end(), key) == valid.end())
        fail(unknown_name("key", key, valid).what());
  }

  float number() const {
    if (!json->is_number()) fail("must be a number");
    const auto value = static_cast<float>(json->get<double>());
    if (!std::isfinite(value)) fail("is too large");
    return value;
  }
  float number_in(float low, float high) const {
    const float value = number();
    if (value < low || value > high) fail(fmt::format("must lie between {} and {}", low, high));
    return value;
  }
  Vec3 vector() const {
    if (!json->is_array() || json->size() != 3) fail("must be an array of three numbers");
    return {at(size_t{0}).number(), at(size_t{1}).number(), at(size_t{2}).number()};
  }
  Vec3 unit_vector() const {
    const Vec3 v = vector();
    const float largest = max_component(glm::abs(v));
    if (largest <= 0) fail("must not be zero");
    return glm::normalize(v / largest);
  }
  std::string text() const {
    if (!json->is_string()) fail("must be a string");
    return json->get<std::string>();
  }
  fs::path path() const {
    const std::string name = text();
    if (name.empty()) fail("must not be empty");
    if (name.find("://") != std::string::npos) fail("must be a path, not an address");
    return fs::path(file).parent_path() / name;
  }
};

Camera read_camera(const Node& node) {
  node.expect_keys({"position", "target", "up", "fov"});
  for (const char* key : {"position", "target"})
    if (!node.has(key)) node.fail(fmt::format("needs '{}'", key));
  const Vec3 position = node.at("position").vector(), target = node.at("target").vector();
  if (position == target) node.fail("'position' and 'target' are the same point");
  const Vec3 up = node.has("up") ? node.at("up").unit_vector() : Vec3(0, 1, 0);
  const float degrees = node.has("fov") ? node.at("fov").number_in(0.1f, 179) : 45;
  Camera camera = look_at(position, target, up, glm::radians(degrees));
  camera.name = "view";
  return camera;
}

PunctualKind read_kind(const Node& node) {
  if (!node.has("type")) node.fail("needs 'type'");
  const std::string type = node.at("type").text();
  if (type == "point") return PunctualKind::point;
  if (type == "spot") return PunctualKind::spot;
  if (type == "directional") return PunctualKind::directional;
  node.at("type").fail(unknown_name("type", type, {"point", "spot", "directional"}).what());
}

/// Direction and the picture's top of a spot or directional light.
void read_orientation(const Node& node, PunctualLight& light) {
  if (node.has("direction") == node.has("target")) node.fail("needs either 'direction' or 'target'");
  if (node.has("direction")) {
    light.direction = node.at("direction").unit_vector();
  } else {
    const Vec3 way = node.at("target").vector() - light.position;
    if (way == Vec3(0)) node.at("target").fail("is where the light stands");
    light.direction = glm::normalize(way / max_component(glm::abs(way)));
  }
  const Vec3 up = node.has("up") ? node.at("up").unit_vector() : Vec3(0, 1, 0);
  light.up = basis_along(-light.direction, up).tangent;
}

void read_cone(const Node& node, PunctualLight& light) {
  light.outer_cone = glm::radians(node.has("outer") ? node.at("outer").number_in(0.01f, 90) : 45);
  light.inner_cone = glm::radians(node.has("inner") ? node.at("inner").number_in(0, 90) : 0);
  if (light.inner_cone >= light.outer_cone) node.fail("'inner' must be less than 'outer'");
}

PunctualLight read_light(const Node& node, std::vector<fs::path>& slides) {
  node.expect_keys({"type", "name", "position", "direction", "target", "up", "color", "intensity", "range",
                    "inner", "outer", "picture"});
  PunctualLight light;
  light.kind = read_kind(node);
  const bool directional = light.kind == PunctualKind::directional, spot = light.kind == PunctualKind::spot;
  light.name = node.has("name") ? node.at("name").text() : node.place;
  if (node.has("position"))
    light.position = node.at("position").vector();
  else if (!directional)
    node.fail("needs 'position'");
  if (light.kind != PunctualKind::point) read_orientation(node, light);
  if (spot) read_cone(node, light);

  const Vec3 color = node.has("color") ? node.at("color").vector() : Vec3(1);
  if (glm::any(glm::lessThan(color, Vec3(0)))) node.at("color").fail("must not be negative");
  light.intensity = color * (node.has("intensity") ? node.at("intensity").number_in(0, 1e30f) : 1.0f);
  if (!is_finite(light.intensity)) node.fail("'color' times 'intensity' is too large");
  if (node.has("range")) {
    light.range = node.at("range").number();
    if (light.range <= 0) node.at("range").fail("must be greater than 0");
  }
  if (node.has("picture")) {
    if (!spot) node.at("picture").fail("only a spot can project a picture");
    light.picture = static_cast<int32_t>(slides.size());
    slides.push_back(node.at("picture").path());
  }
  return light;
}

ViewEnvironment read_environment(const Node& node) {
  node.expect_keys({"file", "rotation", "strength"});
  ViewEnvironment environment;
  if (node.has("file")) environment.file = node.at("file").path();
  if (node.has("rotation")) environment.rotation = glm::radians(node.at("rotation").number());
  if (node.has("strength")) environment.strength = node.at("strength").number_in(0, 1e30f);
  return environment;
}

View read_entry(const Node& node) {
  node.expect_keys({"scene", "camera", "lights", "environment", "ev"});
  View view;
  if (node.has("scene")) view.scene = node.at("scene").path();
  if (node.has("camera")) view.camera = read_camera(node.at("camera"));
  if (node.has("lights")) {
    const Node lights = node.at("lights");
    if (!lights.json->is_array()) lights.fail("must be an array");
    for (size_t i = 0; i < lights.json->size(); ++i)
      view.lights.push_back(read_light(lights.at(i), view.slides));
  }
  if (node.has("environment")) view.environment = read_environment(node.at("environment"));
  if (node.has("ev")) view.ev = node.at("ev").number_in(-60, 60);
  return view;
}

Json parse(const fs::path& path, const LoadLimits& limits) {
  const std::vector<uint8_t> bytes = read_file(path, largest_view);
  const auto guard = [&](int depth, Json::parse_event_t, Json&) {
    if (depth > static_cast<int>(limits.json_depth))
      throw input_error(path.string(), "", "JSON is nested too deeply");
    return true;
  };
  try {
    return Json::parse(bytes.begin(), bytes.end(), guard);
  } catch (const Json::exception& fault) {
    throw input_error(path.string(), "", without_identifier(fault.what()));
  }
}

}  // namespace

View read_view(const fs::path& path, const std::string& name, const LoadLimits& limits) {
  const Json json = parse(path, limits);
  const Node root{&json, path.string(), ""};
  if (!json.is_object()) root.fail("must be an object");
  if (!json.contains("views")) {
    if (!name.empty())
      throw usage_error(fmt::format("{} holds one view, none named '{}'", path.string(), name));
    return read_entry(root);
  }
  root.expect_keys({"views"});
  const Node views = root.at("views");
  if (!views.json->is_object()) views.fail("must be an object");
  std::vector<std::string> names;
  for (const auto& [key, value] : views.json->items()) names.push_back(key);
  if (name.empty() && names.size() == 1) return read_entry(views.at(names[0]));
  if (name.empty())
    throw usage_error(
        fmt::format("{} holds several views; add #NAME (valid: {})", path.string(), fmt::join(names, ", ")));
  if (!views.has(name.c_str())) throw unknown_name("view", name, names);
  return read_entry(views.at(name));
}

View read_view(const std::string& file_and_name, const LoadLimits& limits) {
  const size_t mark = file_and_name.rfind('#');
  std::error_code fault;
  if (mark == std::string::npos || fs::exists(file_and_name, fault))
    return read_view(fs::path(file_and_name), "", limits);
  return read_view(fs::path(file_and_name.substr(0, mark)), file_and_name.substr(mark + 1), limits);
}

void apply_view(Scene& scene, const View& view, const LoadLimits& limits, Messages& messages) {
  if (view.camera) scene.cameras.insert(scene.cameras.begin(), *view.camera);
  const auto first_slide = static_cast<int32_t>(scene.pictures.size());
  for (const fs::path& slide : view.slides) scene.pictures.push_back(read_image(slide, limits));
  for (PunctualLight light : view.lights) {
    if (light.picture >= 0) light.picture += first_slide;
    scene.lights.push_back(std::move(light));
  }
  if (!view.environment) return;
  const ViewEnvironment& environment = *view.environment;
  if (environment.file) scene.environment = load_environment(*environment.file, limits, messages);
  if (environment.rotation) scene.environment.rotation = *environment.rotation;
  if (environment.strength) scene.environment.strength = *environment.strength;
}

}  // namespace halflight
