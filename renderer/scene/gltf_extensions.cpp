// Which extensions are read, which can be left out, and which stop the import.
#include <algorithm>

#include "scene/gltf_document.h"
#include "scene/gltf_json.h"

namespace halflight {

namespace {

constexpr std::string_view read_extensions[] = {
    "KHR_lights_punctual",        "KHR_materials_emissive_strength", "KHR_texture_transform",
    "KHR_materials_ior",          "KHR_materials_specular",          "KHR_materials_unlit",
    "KHR_mesh_quantization",      "KHR_materials_anisotropy",
#ifdef HALFLIGHT_HAVE_DRACO
    "KHR_draco_mesh_compression",
#endif
#ifdef HALFLIGHT_HAVE_MESHOPT
    "EXT_meshopt_compression",
#endif
#ifdef HALFLIGHT_HAVE_WEBP
    "EXT_texture_webp",
#endif
};

/// Nothing of the picture is lost without these, so that they are not worth a warning.
constexpr std::string_view silent_extensions[] = {"KHR_materials_variants", "KHR_xmp", "KHR_xmp_json_ld"};

template <size_t n>
bool contains(const std::string_view (&list)[n], std::string_view name) {
  return std::find(std::begin(list), std::end(list), name) != std::end(list);
}

}  // namespace

void parse_extensions(GltfSource& source, GltfDocument& document) {
  const JsonObject root(source);
  document.extensions_used = root.strings("extensionsUsed");
  const auto required = root.strings("extensionsRequired");
  for (const std::string& name : required) {
    if (!contains(read_extensions, name)) {
      root.fail("extensionsRequired", "UNSUPPORTED_EXTENSION",
                fmt::format("the file requires {}, which this build cannot read", printable(name)));
    }
    if (std::find(document.extensions_used.begin(), document.extensions_used.end(), name) ==
        document.extensions_used.end()) {
      document.extensions_used.push_back(name);
    }
  }
  std::vector<std::string> lost;
  for (const std::string& name : document.extensions_used) {
    if (name == "KHR_mesh_quantization") document.quantized = true;
    if (contains(read_extensions, name)) continue;
    document.ignored_extensions.push_back(name);
    if (!contains(silent_extensions, name)) lost.push_back(printable(name));
  }
  if (!lost.empty()) {
    root.warn("extensionsUsed", "UNSUPPORTED_EXTENSION", fmt::format("ignored: {}", fmt::join(lost, ", ")));
  }
}

}  // namespace halflight
