// Cameras and KHR_lights_punctual as the file describes them, in their own frames.
#include "scene/gltf_document.h"
#include "scene/gltf_json.h"

namespace halflight {

namespace {

Camera read_perspective(const JsonObject& object) {
  object.require("yfov");
  object.require("znear");
  Camera camera;
  const double fov = object.number("yfov", 0);
  if (!(fov > 0)) object.fail("yfov", "VALUE_NOT_IN_RANGE", fmt::format("{} is out of range", fov));
  constexpr double widest = 3.1;
  if (fov > widest) object.warn("yfov", "VALUE_NOT_IN_RANGE", fmt::format("{}; taken as {}", fov, widest));
  camera.vertical_fov = static_cast<float>(std::min(fov, widest));
  object.number("aspectRatio", 1);
  const double near_plane = object.number("znear", 0), far_plane = object.number("zfar", JsonObject::highest);
  if (far_plane <= near_plane)
    object.warn("", "CAMERA_ZFAR_LEQUAL_ZNEAR", "zfar is not greater than znear; neither is used");
  return camera;
}

Camera read_orthographic(const JsonObject& object) {
  for (const char* key : {"xmag", "ymag", "zfar", "znear"}) object.require(key);
  Camera camera;
  camera.projection = Projection::orthographic;
  object.number("xmag", 1);
  const double magnification = object.number("ymag", 1, -1e30, 1e30);
  if (magnification == 0) object.fail("ymag", "VALUE_NOT_IN_RANGE", "0 is out of range");
  camera.half_height = static_cast<float>(std::abs(magnification));
  if (object.number("zfar", 1) <= object.number("znear", 0)) {
    object.warn("", "CAMERA_ZFAR_LEQUAL_ZNEAR", "zfar is not greater than znear; neither is used");
  }
  return camera;
}

/// Angles from the axis. The fall-off needs inner < outer ≤ π/2.
void read_cone(const JsonObject& object, PunctualLight& light) {
  constexpr double quarter = 0.78539816339744831, half = 1.57079632679489662;
  double inner = object.number("innerConeAngle", 0), outer = object.number("outerConeAngle", quarter);
  if (!(outer > 0))
    object.fail("outerConeAngle", "VALUE_NOT_IN_RANGE", fmt::format("{} is out of range", outer));
  if (inner < 0)
    object.fail("innerConeAngle", "VALUE_NOT_IN_RANGE", fmt::format("{} is out of range", inner));
  if (outer > half + 1e-6) {
    object.warn("outerConeAngle", "VALUE_NOT_IN_RANGE", fmt::format("{} is above π/2; taken as π/2", outer));
  }
  outer = std::min(outer, half);
  if (inner >= outer) {
    object.warn("", "KHR_LIGHTS_PUNCTUAL_LIGHT_SPOT_ANGLES",
                fmt::format("innerConeAngle {} is not below outerConeAngle {}; the cone gets a hard edge",
                            inner, outer));
  }
  light.outer_cone = static_cast<float>(outer);
  light.inner_cone = std::min(static_cast<float>(inner), std::nextafter(light.outer_cone, 0.0f));
}

GltfLight read_light(const JsonObject& object) {
  object.require("type");
  GltfLight result;
  PunctualLight& light = result.light;
  light.name = object.string("name");
  const std::string type = object.string("type");
  if (type == "point")
    light.kind = PunctualKind::point;
  else if (type == "spot")
    light.kind = PunctualKind::spot;
  else if (type == "directional")
    light.kind = PunctualKind::directional;
  else {
    object.warn("type", "VALUE_NOT_IN_LIST",
                fmt::format("'{}' is unknown; the light is skipped", printable(type)));
    result.known_type = false;
  }
  const double intensity = object.number("intensity", 1, 0, std::numeric_limits<float>::max());
  light.intensity = glm::min(object.vec3("color", Vec3(1), 0) * static_cast<float>(intensity),
                             Vec3(std::numeric_limits<float>::max()));
  const double range = object.number("range", infinity);
  if (range <= 0)
    object.warn("range", "VALUE_NOT_IN_RANGE", fmt::format("{} is not above 0; taken as no range", range));
  light.range = range > 0 ? static_cast<float>(range) : infinity;
  if (light.kind == PunctualKind::spot && result.known_type) {
    object.require("spot");
    read_cone(*object.object("spot"), light);
  }
  if (const auto ours = object.extra("halflight")) {
    result.picture = ours->string("picture");
    if (!result.picture.empty() && light.kind != PunctualKind::spot) {
      ours->warn("picture", "UNEXPECTED_PROPERTY", "only a spot light projects a picture");
      result.picture.clear();
    }
  }
  return result;
}

}  // namespace

void parse_cameras(GltfSource& source, GltfDocument& document) {
  JsonObject(source).for_each("cameras", [&](const JsonObject& object) {
    object.require("type");
    const std::string type = object.string("type");
    if (type != "perspective" && type != "orthographic") {
      object.fail("type", "VALUE_NOT_IN_LIST", fmt::format("'{}' is no camera type", printable(type)));
    }
    object.require(type);
    const JsonObject projection = *object.object(type);
    Camera camera = type == "perspective" ? read_perspective(projection) : read_orthographic(projection);
    camera.name = object.string("name");
    document.cameras.push_back(std::move(camera));
  });
}

void parse_lights(GltfSource& source, GltfDocument& document) {
  const JsonObject root(source);
  if (const auto extension = root.extension("KHR_lights_punctual")) {
    extension->require("lights");
    extension->for_each("lights",
                        [&](const JsonObject& object) { document.lights.push_back(read_light(object)); });
  }
  size_t i = 0;
  root.for_each("nodes", [&](const JsonObject& object) {
    GltfNode& node = document.nodes[i++];
    const auto extension = object.extension("KHR_lights_punctual");
    if (!extension) return;
    extension->require("light");
    const uint64_t light = extension->integer("light", 0);
    if (light >= document.lights.size()) {
      extension->fail("light", "UNRESOLVED_REFERENCE",
                      fmt::format("light {}, there are {}", light, document.lights.size()));
    }
    node.light = static_cast<int32_t>(light);
  });
}

}  // namespace halflight
