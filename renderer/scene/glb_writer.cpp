// Scenes as binary glTF 2.0 files (Khronos, "glTF 2.0 Specification", chapters 3 to 5). Materials and the
// document around the geometry are in glb_materials.cpp.
#include <array>
#include <cstring>

#include "scene/glb_document.h"
#include "scene/load.h"

namespace halflight {

namespace {

constexpr int component_u8 = 5121, component_u32 = 5125, component_f32 = 5126;

/// Vertices and indices of one material, vertices renumbered in the order of their first use.
struct Primitive {
  std::vector<uint32_t> vertices;  ///< into Scene::vertices
  std::vector<uint32_t> indices;   ///< into `vertices`
};

std::vector<Primitive> group_by_material(const Scene& scene) {
  constexpr uint32_t unseen = 0xffffffffu;
  std::vector<std::vector<uint32_t>> triangles(scene.materials.size());
  for (uint32_t t = 0; t < scene.triangles.size(); ++t) triangles[scene.triangle_material[t]].push_back(t);
  std::vector<uint32_t> renumbered(scene.vertices.size(), unseen);
  std::vector<Primitive> primitives(scene.materials.size());
  for (size_t m = 0; m < primitives.size(); ++m) {
    Primitive& primitive = primitives[m];
    for (const uint32_t t : triangles[m])
      for (int k = 0; k < 3; ++k) {
        uint32_t& index = renumbered[scene.triangles[t][k]];
        if (index == unseen) {
          index = static_cast<uint32_t>(primitive.vertices.size());
          primitive.vertices.push_back(scene.triangles[t][k]);
        }
        primitive.indices.push_back(index);
      }
    for (const uint32_t v : primitive.vertices) renumbered[v] = unseen;
  }
  return primitives;
}

/// Adds an accessor over a new buffer view; returns its index.
template <class T>
size_t add_accessor(GlbDocument& document, const std::vector<T>& values, int component, const char* type,
                    int target, Json bounds = Json::object()) {
  const size_t view = document.add_view(values.data(), values.size() * sizeof(T), target);
  Json accessor{{"bufferView", view}, {"componentType", component}, {"count", values.size()}, {"type", type}};
  if (component == component_u8) accessor["normalized"] = true;
  accessor.update(bounds);
  return document.add("accessors", std::move(accessor));
}

constexpr int vertex_target = 34962, index_target = 34963;

/// One attribute of the primitive's vertices, `read(vertex)` each; `bounds` holds the accessor's min and max.
template <class Read>
size_t add_attribute(GlbDocument& document, const Scene& scene, const Primitive& primitive, const char* type,
                     Read read, Json bounds = Json::object()) {
  using Value = decltype(read(scene.vertices[0]));
  std::vector<Value> values;
  values.reserve(primitive.vertices.size());
  for (const uint32_t v : primitive.vertices) values.push_back(read(scene.vertices[v]));
  const int component = std::is_same_v<Value, uint32_t> ? component_u8 : component_f32;
  return add_accessor(document, values, component, type, vertex_target, std::move(bounds));
}

bool uses_second_uv(const Material& m) {
  for (const TextureUse* use :
       {&m.base_color_texture, &m.metallic_roughness_texture, &m.normal_texture, &m.emission_texture,
        &m.specular_texture, &m.specular_color_texture, &m.anisotropy_texture})
    if (use->used() && use->uv_set == 1) return true;
  return false;
}

Json primitive_json(GlbDocument& document, const Scene& scene, const Primitive& primitive,
                    uint32_t material) {
  bool tangents = true, colors = false;
  Aabb bounds;
  for (const uint32_t v : primitive.vertices) {
    const Vertex& vertex = scene.vertices[v];
    tangents &= vertex.tangent.w != 0;
    colors |= vertex.color != 0xffffffffu;
    bounds.extend(vertex.position);
  }
  const auto attribute = [&](const char* type, auto read, Json more = Json::object()) {
    return add_attribute(document, scene, primitive, type, read, std::move(more));
  };
  const Json extent{{"min", {bounds.low.x, bounds.low.y, bounds.low.z}},
                    {"max", {bounds.high.x, bounds.high.y, bounds.high.z}}};
  Json attributes;
  attributes["POSITION"] = attribute(
      "VEC3", [](const Vertex& v) { return v.position; }, extent);
  attributes["NORMAL"] = attribute("VEC3", [](const Vertex& v) { return v.normal; });
  if (tangents) attributes["TANGENT"] = attribute("VEC4", [](const Vertex& v) { return v.tangent; });
  attributes["TEXCOORD_0"] = attribute("VEC2", [](const Vertex& v) { return v.uv[0]; });
  if (uses_second_uv(scene.materials[material]))
    attributes["TEXCOORD_1"] = attribute("VEC2", [](const Vertex& v) { return v.uv[1]; });
  if (colors) attributes["COLOR_0"] = attribute("VEC4", [](const Vertex& v) { return v.color; });
  const size_t indices = add_accessor(document, primitive.indices, component_u32, "SCALAR", index_target);
  return {{"attributes", attributes}, {"indices", indices}, {"material", material}};
}

void add_geometry(GlbDocument& document, const Scene& scene) {
  const std::vector<Primitive> primitives = group_by_material(scene);
  Json list = Json::array();
  for (uint32_t m = 0; m < primitives.size(); ++m)
    if (!primitives[m].indices.empty()) list.push_back(primitive_json(document, scene, primitives[m], m));
  if (list.empty()) return;
  const size_t mesh = document.add("meshes", {{"primitives", std::move(list)}});
  document.add_node({{"mesh", mesh}});
}

void append_u32(std::string& bytes, uint64_t value) {
  for (int k = 0; k < 4; ++k) bytes.push_back(static_cast<char>(value >> (8 * k) & 0xff));
}

/// Header and chunks (specification, chapter 4.4).
std::string pack(const Json& json, std::string binary) {
  std::string text = json.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  const uint64_t total = 12 + 8 + text.size() + (binary.empty() ? 0 : 8 + binary.size());
  if (total > 0xffffffffull) throw Error(ExitCode::failure, "the scene exceeds the 4 GiB of a .glb file");
  std::string bytes = "glTF";
  append_u32(bytes, 2);
  append_u32(bytes, total);
  append_u32(bytes, text.size());
  bytes += "JSON" + text;
  if (binary.empty()) return bytes;
  append_u32(bytes, binary.size());
  bytes += std::string("BIN\0", 4) + binary;
  return bytes;
}

}  // namespace

size_t GlbDocument::add(const char* list, Json value) {
  Json& values = json[list];
  values.push_back(std::move(value));
  return values.size() - 1;
}

size_t GlbDocument::add_view(const void* data, size_t size, int target) {
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  Json view{{"buffer", 0}, {"byteOffset", binary.size()}, {"byteLength", size}};
  if (target != 0) view["target"] = target;
  binary.append(static_cast<const char*>(data), size);
  return add("bufferViews", std::move(view));
}

void GlbDocument::add_node(Json node) { nodes.push_back(add("nodes", std::move(node))); }

GlbFile make_glb(const Scene& scene, const std::string& stem) {
  GlbDocument document;
  GlbFile file;
  document.json["asset"] = {{"version", "2.0"}, {"generator", "halflight"}};
  document.scene["name"] = stem;
  add_geometry(document, scene);
  add_images(document, scene);
  add_materials(document, scene);
  add_lights(document, scene, stem, file.pictures);
  add_cameras(document, scene);
  add_environment(document, scene, stem, file.pictures);
  if (!document.nodes.empty()) document.scene["nodes"] = document.nodes;
  document.json["scene"] = document.add("scenes", document.scene);
  if (!document.extensions.empty()) document.json["extensionsUsed"] = document.extensions;
  if (!document.binary.empty())
    document.add("buffers", {{"byteLength", (document.binary.size() + 3) / 4 * 4}});
  file.bytes = pack(document.json, std::move(document.binary));
  return file;
}

}  // namespace halflight
