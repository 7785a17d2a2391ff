// A glTF document being written: its JSON and its binary chunk. Shared by the parts of the writer.
#pragma once

#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "scene/load.h"

namespace halflight {

using Json = nlohmann::ordered_json;

struct GlbDocument {
  Json json;   ///< the lists; `make_glb` adds what stands around them
  Json scene;  ///< the one scene, its nodes apart
  std::string binary;
  std::vector<size_t> nodes;
  std::set<std::string> extensions;

  /// Appends to a list of the document, `materials` for one; returns its index there. The value comes
  /// complete: adding to the document moves its members about.
  size_t add(const char* list, Json value);
  /// Appends bytes as a buffer view (target 0: none); returns its index.
  size_t add_view(const void* data, size_t size, int target);
  /// Appends a node to the scene.
  void add_node(Json node);
};

void add_images(GlbDocument&, const Scene&);
void add_materials(GlbDocument&, const Scene&);
void add_lights(GlbDocument&, const Scene&, const std::string& stem, std::vector<SidePicture>&);
void add_cameras(GlbDocument&, const Scene&);
void add_environment(GlbDocument&, const Scene&, const std::string& stem, std::vector<SidePicture>&);

}  // namespace halflight
