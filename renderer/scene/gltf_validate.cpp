// Everything about a parsed document that single properties cannot tell. All numbers of the document are at
// most 2^53 (gltf_json.h), so that no sum or product below wraps in 64 bits.
#include <algorithm>

#include "scene/gltf_document.h"

namespace halflight {

namespace {

std::string place_of(std::string_view array, size_t index) { return fmt::format("{}[{}]", array, index); }

// ---- Views and accessors ----

void check_view(const GltfSource& source, const GltfDocument& document, size_t index) {
  const GltfBufferView& view = document.views[index];
  const auto check = [&](uint32_t buffer, uint64_t offset, uint64_t length) {
    const uint64_t size = document.buffers[buffer].length;
    if (offset + length > size) {
      source.fail(place_of("bufferViews", index), "BUFFER_VIEW_TOO_LONG",
                  fmt::format("ends at byte {}, buffer {} has {}", offset + length, buffer, size));
    }
  };
  check(view.buffer, view.offset, view.length);
  if (view.meshopt) check(view.meshopt->buffer, view.meshopt->offset, view.meshopt->length);
}

/// `needed` bytes from `offset` of a view.
void check_fits(const GltfSource& source, const GltfDocument& document, const std::string& place,
                uint32_t view, uint64_t offset, uint64_t needed) {
  const uint64_t size = document.views[view].length;
  if (offset + needed > size) {
    source.fail(place, "ACCESSOR_TOO_LONG",
                fmt::format("needs {} bytes, bufferView {} has {}", offset + needed, view, size));
  }
}

void check_sparse(const GltfSource& source, const GltfDocument& document, const std::string& place,
                  const GltfAccessor& accessor) {
  const GltfSparse& sparse = *accessor.sparse;
  if (sparse.count > accessor.count) {
    source.fail(place + ".sparse", "ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE",
                fmt::format("replaces {} elements of {}", sparse.count, accessor.count));
  }
  check_fits(source, document, place + ".sparse.indices", sparse.index_view, sparse.index_offset,
             sparse.count * component_size(sparse.index_component));
  check_fits(source, document, place + ".sparse.values", sparse.value_view, sparse.value_offset,
             sparse.count * accessor.element_size());
}

void check_accessor(GltfSource& source, const GltfDocument& document, size_t index) {
  const GltfAccessor& accessor = document.accessors[index];
  const std::string place = place_of("accessors", index);
  const uint64_t size = accessor.element_size();
  if (accessor.sparse) check_sparse(source, document, place, accessor);
  if (accessor.view < 0) return;

  const GltfBufferView& view = document.views[accessor.view];
  const uint64_t stride = view.stride > 0 ? view.stride : size;
  if (stride < size) {
    source.fail(place, "ACCESSOR_SMALL_BYTESTRIDE",
                fmt::format("bufferView {} has a stride of {}, an element has {} bytes", accessor.view,
                            stride, size));
  }
  const size_t alignment = component_size(accessor.component);
  if (accessor.offset % alignment != 0 || (accessor.offset + view.offset) % alignment != 0) {
    source.warn(place, "ACCESSOR_OFFSET_ALIGNMENT",
                fmt::format("does not begin at a multiple of {} bytes", alignment));
  }
  check_fits(source, document, place, static_cast<uint32_t>(accessor.view), accessor.offset,
             stride * (accessor.count - 1) + size);
}

// ---- Attributes ----

bool is_integer(GltfComponent c) { return c != GltfComponent::float32 && c != GltfComponent::uint32; }

bool is_unsigned_small(GltfComponent c) { return c == GltfComponent::uint8 || c == GltfComponent::uint16; }

/// glTF 2.0 §3.7.2.1, with KHR_mesh_quantization's formats where it is declared.
bool has_valid_format(std::string_view semantic, const GltfAccessor& accessor, bool quantized) {
  if (accessor.columns != 1) return false;
  const bool is_float = accessor.component == GltfComponent::float32;
  const bool fraction = is_float || (is_unsigned_small(accessor.component) && accessor.normalized);
  const bool quantizable = is_float || (quantized && is_integer(accessor.component));
  if (semantic == "POSITION" || semantic == "NORMAL") return accessor.rows == 3 && quantizable;
  if (semantic == "TANGENT") return accessor.rows == 4 && quantizable;
  if (semantic == "TEXCOORD_0" || semantic == "TEXCOORD_1")
    return accessor.rows == 2 && (fraction || quantizable);
  if (semantic == "COLOR_0") return (accessor.rows == 3 || accessor.rows == 4) && fraction;
  if (semantic.starts_with("JOINTS_"))
    return accessor.rows == 4 && is_unsigned_small(accessor.component) && !accessor.normalized;
  if (semantic.starts_with("WEIGHTS_")) return accessor.rows == 4 && fraction;
  return true;  // not read
}

/// A target's tangents have no sign, and so three components.
bool has_valid_target_format(std::string_view semantic, const GltfAccessor& accessor, bool quantized) {
  if (semantic != "POSITION" && semantic != "NORMAL" && semantic != "TANGENT") return true;
  return has_valid_format("POSITION", accessor, quantized);
}

void check_primitive(const GltfSource& source, const GltfDocument& document, const std::string& place,
                     const GltfPrimitive& primitive) {
  const auto fail_format = [&](const std::string& where, uint32_t index) {
    source.fail(where, "MESH_PRIMITIVE_ATTRIBUTES_ACCESSOR_INVALID_FORMAT",
                fmt::format("accessor {} is {}", index, document.accessors[index].format()));
  };
  const int32_t position = find_attribute(primitive.attributes, "POSITION");
  for (const auto& [name, index] : primitive.attributes) {
    const std::string where = fmt::format("{}.attributes.{}", place, name);
    const GltfAccessor& accessor = document.accessors[index];
    if (!has_valid_format(name, accessor, document.quantized)) fail_format(where, index);
    if (position >= 0 && accessor.count != document.accessors[position].count) {
      source.fail(
          where, "MESH_PRIMITIVE_UNEQUAL_ACCESSOR_COUNT",
          fmt::format("{} elements, POSITION has {}", accessor.count, document.accessors[position].count));
    }
  }
  for (size_t t = 0; t < primitive.targets.size(); ++t) {
    for (const auto& [name, index] : primitive.targets[t]) {
      const std::string where = fmt::format("{}.targets[{}].{}", place, t, name);
      const GltfAccessor& accessor = document.accessors[index];
      if (!has_valid_target_format(name, accessor, document.quantized)) fail_format(where, index);
      if (position >= 0 && accessor.count != document.accessors[position].count) {
        source.fail(
            where, "MESH_PRIMITIVE_MORPH_TARGET_INVALID_ATTRIBUTE_COUNT",
            fmt::format("{} elements, POSITION has {}", accessor.count, document.accessors[position].count));
      }
    }
  }
  if (primitive.indices >= 0) {
    const GltfAccessor& accessor = document.accessors[primitive.indices];
    const bool is_index =
        is_unsigned_small(accessor.component) || accessor.component == GltfComponent::uint32;
    if (accessor.width() != 1 || !is_index || accessor.normalized) {
      source.fail(place + ".indices", "MESH_PRIMITIVE_INDICES_ACCESSOR_INVALID_FORMAT",
                  fmt::format("accessor {} is {}", primitive.indices, accessor.format()));
    }
  }
}

// ---- Node graph ----

/// Each node has one parent at most; with that, a loop is what no root reaches.
void check_tree(const GltfSource& source, const GltfDocument& document) {
  const size_t count = document.nodes.size();
  constexpr uint32_t none = 0xffffffffu;
  std::vector<uint32_t> parent(count, none);
  for (uint32_t i = 0; i < count; ++i) {
    for (const uint32_t child : document.nodes[i].children) {
      if (child == i) source.fail(place_of("nodes", i), "NODE_LOOP", "the node is its own child");
      if (parent[child] != none) {
        source.fail(place_of("nodes", i), "NODE_PARENT_OVERRIDE",
                    fmt::format("node {} already has node {} as its parent", child, parent[child]));
      }
      parent[child] = i;
    }
  }
  std::vector<uint32_t> reached;
  for (uint32_t i = 0; i < count; ++i) {
    if (parent[i] == none) reached.push_back(i);
  }
  for (size_t next = 0; next < reached.size(); ++next) {
    const auto& children = document.nodes[reached[next]].children;
    reached.insert(reached.end(), children.begin(), children.end());
  }
  if (reached.size() < count) {
    std::vector<bool> seen(count, false);
    for (const uint32_t i : reached) seen[i] = true;
    const size_t first = std::find(seen.begin(), seen.end(), false) - seen.begin();
    source.fail(place_of("nodes", first), "NODE_LOOP", "the node is its own ancestor");
  }
  for (const uint32_t root : document.roots) {
    if (parent[root] != none) {
      source.fail("scenes", "SCENE_NON_ROOT_NODE",
                  fmt::format("node {} is a child of node {}", root, parent[root]));
    }
  }
}

void check_skin(const GltfSource& source, const GltfDocument& document, size_t index) {
  const GltfSkin& skin = document.skins[index];
  if (skin.inverse_bind_matrices < 0) return;
  const GltfAccessor& accessor = document.accessors[skin.inverse_bind_matrices];
  const std::string place = place_of("skins", index) + ".inverseBindMatrices";
  if (accessor.columns != 4 || accessor.component != GltfComponent::float32) {
    source.fail(place, "SKIN_IBM_INVALID_FORMAT", fmt::format("accessor is {}", accessor.format()));
  }
  if (accessor.count < skin.joints.size()) {
    source.fail(place, "INVALID_IBM_ACCESSOR_COUNT",
                fmt::format("{} matrices for {} joints", accessor.count, skin.joints.size()));
  }
}

// ---- Animations ----

bool has_valid_output(GltfPath path, const GltfAccessor& accessor) {
  const bool fraction =
      accessor.component == GltfComponent::float32 || (is_integer(accessor.component) && accessor.normalized);
  if (accessor.columns != 1) return false;
  switch (path) {
    case GltfPath::translation:
    case GltfPath::scale:
      return accessor.rows == 3 && accessor.component == GltfComponent::float32;
    case GltfPath::rotation:
      return accessor.rows == 4 && fraction;
    case GltfPath::weights:
      return accessor.rows == 1 && fraction;
    case GltfPath::other:
      break;
  }
  return true;
}

void check_channel(const GltfSource& source, const GltfDocument& document, const std::string& place,
                   const GltfAnimation& animation, const GltfChannel& channel) {
  const GltfAnimationSampler& sampler = animation.samplers[channel.sampler];
  const GltfAccessor &input = document.accessors[sampler.input], &output = document.accessors[sampler.output];
  if (input.width() != 1 || input.component != GltfComponent::float32) {
    source.fail(place, "ANIMATION_SAMPLER_INPUT_ACCESSOR_INVALID_FORMAT",
                fmt::format("input is {}", input.format()));
  }
  if (channel.path == GltfPath::other) return;
  if (!has_valid_output(channel.path, output)) {
    source.fail(place, "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_FORMAT",
                fmt::format("output is {}", output.format()));
  }
  const uint64_t keys = input.count * (sampler.interpolation == GltfInterpolation::cubic_spline ? 3 : 1);
  const bool matches = channel.path == GltfPath::weights ? output.count % keys == 0 : output.count == keys;
  if (!matches) {
    source.fail(place, "ANIMATION_SAMPLER_OUTPUT_ACCESSOR_INVALID_COUNT",
                fmt::format("{} values for {} keys", output.count, input.count));
  }
}

}  // namespace

void validate_data(GltfSource& source, const GltfDocument& document) {
  for (size_t i = 0; i < document.views.size(); ++i) check_view(source, document, i);
  for (size_t i = 0; i < document.accessors.size(); ++i) check_accessor(source, document, i);
}

void validate_meshes(GltfSource& source, const GltfDocument& document) {
  for (size_t m = 0; m < document.meshes.size(); ++m) {
    const auto& primitives = document.meshes[m].primitives;
    for (size_t p = 0; p < primitives.size(); ++p) {
      check_primitive(source, document, fmt::format("meshes[{}].primitives[{}]", m, p), primitives[p]);
    }
  }
}

void validate_graph(GltfSource& source, const GltfDocument& document) {
  check_tree(source, document);
  for (size_t i = 0; i < document.skins.size(); ++i) check_skin(source, document, i);
}

void validate_animations(GltfSource& source, const GltfDocument& document) {
  for (size_t a = 0; a < document.animations.size(); ++a) {
    const GltfAnimation& animation = document.animations[a];
    for (size_t c = 0; c < animation.channels.size(); ++c) {
      check_channel(source, document, fmt::format("animations[{}].channels[{}]", a, c), animation,
                    animation.channels[c]);
    }
  }
}

void validate_gltf(GltfSource& source, const GltfDocument& document) {
  validate_data(source, document);
  validate_meshes(source, document);
  validate_graph(source, document);
  validate_animations(source, document);
}

}  // namespace halflight
