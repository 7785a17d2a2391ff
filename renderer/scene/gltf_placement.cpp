// Cameras, lights and the environment of the shown scene, in world space.
#include "scene/gltf_instances.h"
#include "scene/image_files.h"

namespace halflight {

namespace {

/// A node's frame without its scale: origin and orthonormal axes. False where the axes have no direction.
struct Frame {
  Vec3 position, x, y, z;
};
bool rigid_frame(const glm::dmat4& m, Frame& frame) {
  const glm::dvec3 z(m[2]), y(m[1]);
  const double z_length = glm::length(z);
  const glm::dvec3 back = z / z_length, aside = glm::cross(y, back);
  const double aside_length = glm::length(aside);
  frame.position = Vec3(m[3]);
  if (!(z_length > 0) || !(aside_length > 0) || !is_finite(frame.position)) return false;
  frame.z = Vec3(back);
  frame.x = Vec3(aside / aside_length);
  frame.y = Vec3(glm::cross(back, aside / aside_length));
  return is_finite(frame.x) && is_finite(frame.y) && is_finite(frame.z);
}

/// A projector's slide. Index into Scene::pictures, -1 where it cannot be read.
int32_t read_picture(const GltfSource& source, const std::string& uri, const std::string& place, Scene& scene,
                     Messages& messages) {
  const auto path = resolve_uri(source, uri, place);
  try {
    scene.pictures.push_back(read_image(path, source.options->limits));
  } catch (const Error& error) {
    messages.placeholder(source.name, place, fmt::format("{}; the light projects no picture", error.what()));
    return -1;
  }
  return static_cast<int32_t>(scene.pictures.size()) - 1;
}

}  // namespace

void import_cameras(GltfSource& source, const GltfDocument& document, const GltfPose& pose, Scene& scene) {
  for (const uint32_t index : pose.shown) {
    const GltfNode& node = document.nodes[index];
    if (node.camera < 0) continue;
    Frame frame;
    if (!rigid_frame(pose.world[index], frame)) {
      source.warn(fmt::format("nodes[{}]", index), "NODE_MATRIX_SINGULAR", "its camera is skipped");
      continue;
    }
    Camera camera = document.cameras[node.camera];
    camera.position = frame.position;
    camera.right = frame.x, camera.up = frame.y, camera.back = frame.z;
    // A camera and its node usually bear the same name; the node's tells apart two uses of one camera.
    if (!node.name.empty()) camera.name = node.name;
    scene.cameras.push_back(std::move(camera));
  }
}

void import_lights(GltfSource& source, const GltfDocument& document, const GltfPose& pose, Scene& scene,
                   Messages& messages) {
  std::vector<int32_t> picture(document.lights.size(), -1);
  std::vector<bool> tried(document.lights.size(), false);
  for (const uint32_t index : pose.shown) {
    const int32_t which = document.nodes[index].light;
    if (which < 0 || !document.lights[which].known_type) continue;
    const GltfLight& description = document.lights[which];
    Frame frame;
    if (!rigid_frame(pose.world[index], frame)) {
      if (description.light.kind != PunctualKind::point || !is_finite(Vec3(pose.world[index][3]))) {
        source.warn(fmt::format("nodes[{}]", index), "NODE_MATRIX_SINGULAR", "its light is skipped");
        continue;
      }
      frame = {Vec3(pose.world[index][3]), {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    }
    if (!description.picture.empty() && !tried[which]) {
      tried[which] = true;
      const std::string place =
          fmt::format("extensions.KHR_lights_punctual.lights[{}].extras.halflight.picture", which);
      picture[which] = read_picture(source, description.picture, place, scene, messages);
    }
    PunctualLight light = description.light;
    light.position = frame.position;
    light.direction = -frame.z;
    light.up = frame.y;
    light.picture = picture[which];
    if (light.name.empty()) light.name = document.nodes[index].name;
    scene.lights.push_back(std::move(light));
  }
}

void import_environment(const GltfSource& source, const GltfDocument& document, Scene& scene,
                        Messages& messages) {
  const GltfEnvironment& environment = document.environment;
  if (environment.file.empty()) return;
  constexpr std::string_view place = "scenes.extras.halflight.environment";
  const auto path = resolve_uri(source, environment.file, place);
  try {
    scene.environment = load_environment(path, source.options->limits, messages);
  } catch (const Error& error) {
    messages.placeholder(source.name, place, fmt::format("{}; there is no environment", error.what()));
    return;
  }
  scene.environment.rotation = environment.rotation;
  scene.environment.strength = environment.strength;
}

}  // namespace halflight
