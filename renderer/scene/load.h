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
  uint32_t nodes = 1'000'000;
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

/// A file, or where there is none of that name a built-in environment (scene/built_in_environments.h). A name without
/// ending or folder that is neither: exit code 2.
Environment open_environment(const std::string& name_or_path, const LoadLimits&, Messages&);

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

/// A picture that goes beside a .glb under `name`: the environment, a projector's slide.
struct SidePicture {
  std::string name;
  ImageRgb image;
};

/// A scene as a glTF 2.0 binary file, with the pictures that it names.
struct GlbFile {
  std::string bytes;
  std::vector<SidePicture> pictures;
};

/// The scene as `stem`.glb, so that it can be opened elsewhere; the environment is `stem`.hdr, slides are
/// `stem`-slide-N.hdr. Triangles come grouped by material. Throws Error (exit code 1) where it exceeds the 4 GiB of the
/// format. The caller writes the files (film/image_writers.h writes them whole or not at all).
GlbFile make_glb(const Scene&, const std::string& stem);

}  // namespace halflight
