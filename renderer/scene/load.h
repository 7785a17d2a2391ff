// From a name on the command line to a complete scene.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/errors.h"
#include "scene/scene.h"

namespace halflight {

/// Bounds on what a file may ask for; each has an option `--limit-NAME`.
struct LoadLimits {
  uint64_t image_pixels = 256ull << 20;    ///< of one image
  uint64_t total_pixels = 1ull << 30;      ///< of all images of a scene
  uint64_t triangles = 200'000'000;
  uint64_t buffer_bytes = 8ull << 30;
  uint32_t nodes = 10'000'000;
  uint32_t json_depth = 256;
};

struct LoadOptions {
  double at_seconds = 0;        ///< time of animations, skins and morphs
  bool allow_external = false;  ///< paths may leave the asset's folder
  LoadLimits limits;
};

/// A .gltf or .glb file. Throws Error (exit code 3) naming file, place and reason; warnings go to `messages`.
Scene load_gltf(const std::filesystem::path&, const LoadOptions&, Messages&);

/// Radiance .hdr or .exr, by content rather than ending.
Environment load_environment(const std::filesystem::path&, const LoadLimits&, Messages&);

/// Built-in scenes: name and one line of description.
struct BuiltInScene {
  std::string_view name, description;
  Scene (*make)();
};
const std::vector<BuiltInScene>& built_in_scenes();

/// A built-in name or a path. An unknown name that is no file: exit code 2; a file of another kind: exit code 3.
/// The result is complete (`complete_scene`).
Scene load_scene(const std::string& name_or_path, const LoadOptions&, Messages&);

/// Adds what a scene must have to be seen: a camera that frames it (from inside, where it is a room). Light is added
/// by `complete_lights` (trace/completion.h), which needs rays to know whether the camera stands enclosed.
void complete_camera(Scene&, Messages&);

/// Writes a scene as .glb (and its environment as .hdr beside it), so that it can be opened elsewhere.
void write_glb(const Scene&, const std::filesystem::path&);

}  // namespace halflight
