// Buffers, views, accessors, meshes, nodes, skins, scenes and animations as structs.
#include <algorithm>

#include "scene/gltf_document.h"
#include "scene/gltf_json.h"

namespace halflight {

namespace {

struct AccessorType {
  std::string_view name;
  uint32_t columns, rows;
};
constexpr AccessorType accessor_types[] = {{"SCALAR", 1, 1}, {"VEC2", 1, 2}, {"VEC3", 1, 3}, {"VEC4", 1, 4},
                                           {"MAT2", 2, 2},   {"MAT3", 3, 3}, {"MAT4", 4, 4}};

GltfComponent read_component(const JsonObject& object, std::string_view key) {
  object.require(key);
  const uint64_t code = object.integer(key, 0);
  switch (code) {
    case 5120:
    case 5121:
    case 5122:
    case 5123:
    case 5125:
    case 5126:
      return static_cast<GltfComponent>(code);
    default:
      object.fail(key, "VALUE_NOT_IN_LIST", fmt::format("{} is no component type", code));
  }
}

/// A name of a small list; an unknown one is noted and becomes the first.
template <class Enum, size_t n>
Enum read_name(const JsonObject& object, std::string_view key,
               const std::pair<std::string_view, Enum> (&list)[n]) {
  if (!object.has(key)) return list[0].second;
  const std::string name = object.string(key);
  for (const auto& [known, value] : list) {
    if (name == known) return value;
  }
  object.warn(key, "VALUE_NOT_IN_LIST",
              fmt::format("'{}' is unknown; taken as {}", printable(name), list[0].first));
  return list[0].second;
}

MeshoptView read_meshopt(const JsonObject& object, const GltfBufferView& view) {
  object.require("byteLength");
  object.require("byteStride");
  object.require("count");
  object.require("mode");
  MeshoptView meshopt;
  meshopt.buffer = static_cast<uint32_t>(object.required_index("buffer", "buffers"));
  meshopt.offset = object.integer("byteOffset", 0);
  meshopt.length = object.integer("byteLength", 0, 1);
  meshopt.stride = object.integer("byteStride", 0, 1, 256);
  meshopt.count = object.integer("count", 0, 1);
  const std::string mode = object.string("mode"), filter = object.string("filter", "NONE");
  if (mode == "ATTRIBUTES")
    meshopt.mode = MeshoptMode::attributes;
  else if (mode == "TRIANGLES")
    meshopt.mode = MeshoptMode::triangles;
  else if (mode == "INDICES")
    meshopt.mode = MeshoptMode::indices;
  else
    object.fail("mode", "VALUE_NOT_IN_LIST", fmt::format("'{}' is unknown", printable(mode)));
  if (filter == "NONE")
    meshopt.filter = MeshoptFilter::none;
  else if (filter == "OCTAHEDRAL")
    meshopt.filter = MeshoptFilter::octahedral;
  else if (filter == "QUATERNION")
    meshopt.filter = MeshoptFilter::quaternion;
  else if (filter == "EXPONENTIAL")
    meshopt.filter = MeshoptFilter::exponential;
  else
    object.fail("filter", "VALUE_NOT_IN_LIST", fmt::format("'{}' is unknown", printable(filter)));
  if (meshopt.count > view.length / meshopt.stride) {
    object.fail(
        "count", "BUFFER_VIEW_TOO_LONG",
        fmt::format("{} elements of {} bytes, the view has {}", meshopt.count, meshopt.stride, view.length));
  }
  return meshopt;
}

void parse_views(GltfSource& source, GltfDocument& document) {
  JsonObject(source).for_each("bufferViews", [&](const JsonObject& object) {
    object.require("byteLength");
    GltfBufferView view;
    view.buffer = static_cast<uint32_t>(object.required_index("buffer", "buffers"));
    view.offset = object.integer("byteOffset", 0);
    view.length = object.integer("byteLength", 0, 1);
    view.stride = object.integer("byteStride", 0, 4, 252);
    if (view.stride % 4 != 0) {
      object.warn("byteStride", "VALUE_MULTIPLE_OF", fmt::format("{} is not a multiple of 4", view.stride));
    }
    if (const auto meshopt = object.extension("EXT_meshopt_compression"))
      view.meshopt = read_meshopt(*meshopt, view);
    document.views.push_back(view);
  });
}

GltfSparse read_sparse(const JsonObject& object) {
  object.require("count");
  object.require("indices");
  object.require("values");
  const JsonObject indices = *object.object("indices"), values = *object.object("values");
  GltfSparse sparse;
  sparse.count = object.integer("count", 0, 1);
  sparse.index_view = static_cast<uint32_t>(indices.required_index("bufferView", "bufferViews"));
  sparse.index_offset = indices.integer("byteOffset", 0);
  sparse.index_component = read_component(indices, "componentType");
  if (sparse.index_component != GltfComponent::uint8 && sparse.index_component != GltfComponent::uint16 &&
      sparse.index_component != GltfComponent::uint32) {
    indices.fail("componentType", "VALUE_NOT_IN_LIST", "sparse indices are unsigned integers");
  }
  sparse.value_view = static_cast<uint32_t>(values.required_index("bufferView", "bufferViews"));
  sparse.value_offset = values.integer("byteOffset", 0);
  return sparse;
}

void parse_accessors(GltfSource& source, GltfDocument& document) {
  JsonObject(source).for_each("accessors", [&](const JsonObject& object) {
    object.require("count");
    object.require("type");
    GltfAccessor accessor;
    accessor.view = object.index("bufferView", "bufferViews");
    accessor.offset = object.integer("byteOffset", 0);
    accessor.count = object.integer("count", 0, 1);
    accessor.component = read_component(object, "componentType");
    accessor.normalized = object.boolean("normalized", false);
    const std::string type = object.string("type");
    const auto known = std::find_if(std::begin(accessor_types), std::end(accessor_types),
                                    [&](const AccessorType& entry) { return entry.name == type; });
    if (known == std::end(accessor_types)) {
      object.fail("type", "VALUE_NOT_IN_LIST", fmt::format("'{}' is no accessor type", printable(type)));
    }
    accessor.columns = known->columns;
    accessor.rows = known->rows;
    if (const auto sparse = object.object("sparse")) accessor.sparse = read_sparse(*sparse);
    object.numbers("min");
    object.numbers("max");
    document.accessors.push_back(accessor);
  });
}

GltfAttributes read_attributes(const JsonObject& object) {
  GltfAttributes attributes;
  object.for_each_index("accessors", [&](const std::string& name, uint32_t accessor) {
    attributes.push_back({name, accessor});
  });
  return attributes;
}

DracoPrimitive read_draco(const JsonObject& object) {
  object.require("attributes");
  DracoPrimitive draco;
  draco.view = static_cast<uint32_t>(object.required_index("bufferView", "bufferViews"));
  const JsonObject attributes = *object.object("attributes");
  for (const char* name :
       {"POSITION", "NORMAL", "TANGENT", "TEXCOORD_0", "TEXCOORD_1", "COLOR_0", "JOINTS_0", "WEIGHTS_0"}) {
    if (attributes.has(name)) {
      draco.attributes.push_back({name, static_cast<uint32_t>(attributes.integer(name, 0, 0, 0xffffffffu))});
    }
  }
  return draco;
}

GltfPrimitive read_primitive(const JsonObject& object) {
  object.require("attributes");
  GltfPrimitive primitive;
  primitive.attributes = read_attributes(*object.object("attributes"));
  object.for_each("targets",
                  [&](const JsonObject& target) { primitive.targets.push_back(read_attributes(target)); });
  primitive.indices = object.index("indices", "accessors");
  primitive.material = object.index("material", "materials");
  primitive.mode = static_cast<uint32_t>(object.integer("mode", 4, 0, 6));
  if (const auto draco = object.extension("KHR_draco_mesh_compression")) primitive.draco = read_draco(*draco);
  return primitive;
}

GltfNode read_node(const JsonObject& object) {
  GltfNode node;
  node.name = object.string("name");
  node.children = object.indices("children", "nodes");
  const auto matrix = object.numbers("matrix", 16), translation = object.numbers("translation", 3);
  const auto rotation = object.numbers("rotation", 4), scale = object.numbers("scale", 3);
  if (!matrix.empty()) {
    node.matrix.emplace();
    std::copy(matrix.begin(), matrix.end(), node.matrix->begin());
    if (!translation.empty() || !rotation.empty() || !scale.empty()) {
      object.warn("", "NODE_MATRIX_TRS",
                  "has a matrix as well as translation, rotation or scale; the matrix counts");
    }
  }
  if (!translation.empty()) node.translation = {translation[0], translation[1], translation[2]};
  if (!scale.empty()) node.scale = {scale[0], scale[1], scale[2]};
  if (!rotation.empty()) node.rotation = glm::dquat(rotation[3], rotation[0], rotation[1], rotation[2]);
  node.weights = object.numbers("weights");
  node.mesh = object.index("mesh", "meshes");
  node.skin = object.index("skin", "skins");
  node.camera = object.index("camera", "cameras");
  return node;
}

GltfEnvironment read_environment(const JsonObject& scene) {
  GltfEnvironment environment;
  const auto ours = scene.extra("halflight");
  const auto object = ours ? ours->object("environment") : std::nullopt;
  if (!object) return environment;
  object->require("file");
  environment.file = object->string("file");
  environment.rotation = glm::radians(static_cast<float>(object->number("rotation", 0, -1e6, 1e6)));
  environment.strength = static_cast<float>(object->number("strength", 1, 0, 1e30));
  return environment;
}

/// The default scene, else the first; a file without scenes shows all nodes that have no parent.
void parse_scenes(GltfSource& source, GltfDocument& document) {
  const JsonObject root(source);
  const size_t chosen = static_cast<size_t>(std::max(root.index("scene", "scenes"), 0));
  size_t count = 0;
  root.for_each("scenes", [&](const JsonObject& object) {
    auto nodes = object.indices("nodes", "nodes");
    if (count++ != chosen) return;
    document.roots = std::move(nodes);
    document.environment = read_environment(object);
  });
  if (count > 0) return;
  std::vector<bool> has_parent(document.nodes.size(), false);
  for (const GltfNode& node : document.nodes) {
    for (const uint32_t child : node.children) has_parent[child] = true;
  }
  for (uint32_t i = 0; i < document.nodes.size(); ++i) {
    if (!has_parent[i]) document.roots.push_back(i);
  }
  if (!document.nodes.empty()) root.warn("scenes", "UNDEFINED_PROPERTY", "no scene; all nodes are shown");
}

constexpr std::pair<std::string_view, GltfPath> paths[] = {
    {"other", GltfPath::other}, {"translation", GltfPath::translation}, {"rotation", GltfPath::rotation},
    {"scale", GltfPath::scale}, {"weights", GltfPath::weights},         {"pointer", GltfPath::other}};
constexpr std::pair<std::string_view, GltfInterpolation> interpolations[] = {
    {"LINEAR", GltfInterpolation::linear},
    {"STEP", GltfInterpolation::step},
    {"CUBICSPLINE", GltfInterpolation::cubic_spline}};

void check_version(GltfSource& source) {
  const JsonObject root(source);
  root.require("asset");
  const JsonObject asset = *root.object("asset");
  asset.require("version");
  const auto read = [&](std::string_view key) {
    const std::string text = asset.string(key, "2.0");
    const size_t point = text.find('.');
    const auto digits = [](std::string_view s) {
      return !s.empty() && s.size() < 6 && s.find_first_not_of("0123456789") == std::string_view::npos;
    };
    if (point == std::string::npos || !digits(text.substr(0, point)) || !digits(text.substr(point + 1))) {
      asset.fail(key, "PATTERN_MISMATCH", fmt::format("'{}' is no version", printable(text)));
    }
    return std::pair(std::stoi(text.substr(0, point)), std::stoi(text.substr(point + 1)));
  };
  const auto version = read("version"), least = read("minVersion");
  if (version.first != 2) {
    asset.fail("version", "UNKNOWN_ASSET_MAJOR_VERSION",
               fmt::format("glTF {}; only 2 is read", version.first));
  }
  if (least.first > 2) {
    asset.fail("minVersion", "UNKNOWN_ASSET_MAJOR_VERSION", fmt::format("needs glTF {}", least.first));
  }
  if (least.second > 0) {
    asset.warn("minVersion", "UNKNOWN_ASSET_MINOR_VERSION",
               fmt::format("asks for glTF 2.{}; read as 2.0", least.second));
  }
}

}  // namespace

size_t component_size(GltfComponent component) {
  switch (component) {
    case GltfComponent::int8:
    case GltfComponent::uint8:
      return 1;
    case GltfComponent::int16:
    case GltfComponent::uint16:
      return 2;
    case GltfComponent::uint32:
    case GltfComponent::float32:
      break;
  }
  return 4;
}

uint64_t GltfAccessor::element_size() const {
  const uint64_t column = rows * component_size(component);
  return columns == 1 ? column : columns * ((column + 3) / 4 * 4);
}

std::string GltfAccessor::format() const {
  std::string_view component_name;
  switch (component) {
    case GltfComponent::int8:
      component_name = "BYTE";
      break;
    case GltfComponent::uint8:
      component_name = "UNSIGNED_BYTE";
      break;
    case GltfComponent::int16:
      component_name = "SHORT";
      break;
    case GltfComponent::uint16:
      component_name = "UNSIGNED_SHORT";
      break;
    case GltfComponent::uint32:
      component_name = "UNSIGNED_INT";
      break;
    case GltfComponent::float32:
      component_name = "FLOAT";
      break;
  }
  for (const AccessorType& type : accessor_types) {
    if (type.columns == columns && type.rows == rows) {
      return fmt::format("{} of {}{}", type.name, normalized ? "normalized " : "", component_name);
    }
  }
  return std::string(component_name);
}

int32_t find_attribute(const GltfAttributes& attributes, std::string_view name) {
  for (const GltfAttribute& attribute : attributes) {
    if (attribute.name == name) return static_cast<int32_t>(attribute.accessor);
  }
  return -1;
}

void parse_data(GltfSource& source, GltfDocument& document) {
  parse_views(source, document);
  parse_accessors(source, document);
}

void parse_meshes(GltfSource& source, GltfDocument& document) {
  JsonObject(source).for_each("meshes", [&](const JsonObject& object) {
    GltfMesh mesh;
    mesh.name = object.string("name");
    object.require("primitives");
    object.for_each("primitives", [&](const JsonObject& o) { mesh.primitives.push_back(read_primitive(o)); });
    mesh.weights = object.numbers("weights");
    document.meshes.push_back(std::move(mesh));
  });
}

void parse_nodes(GltfSource& source, GltfDocument& document) {
  const uint64_t limit = source.options->limits.nodes;
  if (root_array_size(source, "nodes") > limit) {
    source.fail("nodes", "LIMIT",
                fmt::format("{} nodes, the limit is {} (--limit-nodes)", source.root["nodes"].size(), limit));
  }
  JsonObject(source).for_each("nodes",
                              [&](const JsonObject& object) { document.nodes.push_back(read_node(object)); });
  JsonObject(source).for_each("skins", [&](const JsonObject& object) {
    object.require("joints");
    GltfSkin skin;
    skin.joints = object.indices("joints", "nodes");
    skin.inverse_bind_matrices = object.index("inverseBindMatrices", "accessors");
    object.index("skeleton", "nodes");
    document.skins.push_back(std::move(skin));
  });
  parse_scenes(source, document);
}

void parse_animations(GltfSource& source, GltfDocument& document) {
  JsonObject(source).for_each("animations", [&](const JsonObject& object) {
    GltfAnimation animation;
    object.require("samplers");
    object.require("channels");
    object.for_each("samplers", [&](const JsonObject& sampler) {
      animation.samplers.push_back({static_cast<uint32_t>(sampler.required_index("input", "accessors")),
                                    static_cast<uint32_t>(sampler.required_index("output", "accessors")),
                                    read_name(sampler, "interpolation", interpolations)});
    });
    object.for_each("channels", [&](const JsonObject& channel) {
      channel.require("sampler");
      channel.require("target");
      const uint64_t sampler = channel.integer("sampler", 0);
      if (sampler >= animation.samplers.size()) {
        channel.fail("sampler", "UNRESOLVED_REFERENCE",
                     fmt::format("sampler {}, there are {}", sampler, animation.samplers.size()));
      }
      const JsonObject target = *channel.object("target");
      target.require("path");
      animation.channels.push_back(
          {static_cast<uint32_t>(sampler), target.index("node", "nodes"), read_name(target, "path", paths)});
    });
    document.animations.push_back(std::move(animation));
  });
}

GltfDocument parse_gltf(GltfSource& source) {
  check_version(source);
  GltfDocument document;
  parse_extensions(source, document);
  load_buffers(source, document);
  parse_data(source, document);
  parse_meshes(source, document);
  parse_nodes(source, document);
  parse_animations(source, document);
  parse_materials(source, document);
  parse_cameras(source, document);
  parse_lights(source, document);
  return document;
}

}  // namespace halflight
