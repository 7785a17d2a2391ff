#include "scene/load.h"

#include <fstream>

#include "core/errors.h"
#include "scene/built_in_environments.h"

namespace halflight {

namespace {

namespace fs = std::filesystem;

bool starts_with(std::string_view head, std::string_view magic) {
  return head.compare(0, magic.size(), magic) == 0;
}

/// First bytes of a file; throws where it cannot be read.
std::string file_head(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  std::string head(64, '\0');
  stream.read(head.data(), static_cast<std::streamsize>(head.size()));
  if (stream.bad() || (!stream && stream.gcount() == 0 && !stream.eof()))
    throw input_error(path.string(), "", "cannot be read");
  head.resize(static_cast<size_t>(stream.gcount()));
  return head;
}

/// What a file that is no scene seems to be, by its first bytes, and what to do with it instead.
std::string_view other_kind(const std::string& head) {
  constexpr std::string_view environment =
      "is an environment picture, not a scene; give it as --environment FILE";
  constexpr std::string_view picture = "is a picture, not a scene";
  if (starts_with(head, "#?")) return environment;
  if (starts_with(head, "\x76\x2f\x31\x01")) return environment;
  if (starts_with(head, "\x89PNG") || starts_with(head, "\xff\xd8\xff") || starts_with(head, "RIFF"))
    return picture;
  if (head.empty()) return "is empty";
  return "is neither a .gltf nor a .glb file";
}

/// Whether the file is glTF by content: the binary's magic number, or JSON.
bool looks_like_gltf(const std::string& head) {
  if (starts_with(head, "glTF")) return true;
  const size_t start = starts_with(head, "\xef\xbb\xbf") ? 3 : 0;
  const size_t first = head.find_first_not_of(" \t\r\n", start);
  return first != std::string::npos && head[first] == '{';
}

Scene load_file(const fs::path& path, const LoadOptions& options, Messages& messages) {
  if (fs::is_directory(path)) throw input_error(path.string(), "", "is a folder, not a scene");
  if (!fs::is_regular_file(path)) throw input_error(path.string(), "", "is not a regular file");
  const std::string head = file_head(path);
  const std::string ending = path.extension().string();
  // A damaged file that is named as glTF gets the importer's more exact words.
  const bool named_gltf = ending == ".gltf" || ending == ".glb";
  if (!looks_like_gltf(head) && !(named_gltf && starts_with(other_kind(head), "is neither")))
    throw input_error(path.string(), "", other_kind(head));
  return load_gltf(path, options, messages);
}

}  // namespace

Environment open_environment(const std::string& name_or_path, const LoadLimits& limits, Messages& messages) {
  const fs::path path(name_or_path);
  std::error_code fault;
  const bool named_as_file = path.has_extension() || path.has_parent_path() || name_or_path.empty();
  if (named_as_file || fs::exists(path, fault)) return load_environment(path, limits, messages);
  return make_built_in_environment(name_or_path);
}

Scene load_scene(const std::string& name_or_path, const LoadOptions& options, Messages& messages) {
  std::vector<std::string> names;
  for (const BuiltInScene& built_in : built_in_scenes()) {
    names.emplace_back(built_in.name);
    if (built_in.name != name_or_path) continue;
    Scene scene = built_in.make();
    complete_camera(scene, messages);
    return scene;
  }
  const fs::path path(name_or_path);
  std::error_code fault;
  if (!fs::exists(path, fault)) {
    if (path.has_extension() || path.has_parent_path())
      throw input_error(name_or_path, "", "no such file");
    throw unknown_name("scene", name_or_path, names);
  }
  Scene scene = load_file(path, options, messages);
  complete_camera(scene, messages);
  return scene;
}

}  // namespace halflight
