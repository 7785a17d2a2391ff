// load_gltf: the steps of an import, in order. Each has its own file.
#include "scene/gltf_images.h"
#include "scene/gltf_instances.h"

namespace halflight {

Scene load_gltf(const std::filesystem::path& path, const LoadOptions& options, Messages& messages) {
  GltfSource source = open_gltf(path, options, messages);
  GltfDocument document = parse_gltf(source);
  validate_gltf(source, document);

  Scene scene;
  scene.facts.source = source.name;
  scene.facts.extensions_used = document.extensions_used;
  scene.facts.ignored_extensions = document.ignored_extensions;
  scene.facts.animations = document.animations.size();
  scene.facts.at_seconds = options.at_seconds;
  GltfReader reader(source, document);
  const GltfPose pose = pose_nodes(source, document, reader, options.at_seconds);
  const std::vector<bool> used = import_meshes(source, document, reader, pose, scene);
  import_cameras(source, document, pose, scene);
  import_lights(source, document, pose, scene, messages);
  import_environment(source, document, scene, messages);
  import_textures(source, document, reader, used, scene, messages);
  source.report(messages);
  update_bounds(scene);
  return scene;
}

}  // namespace halflight
