// Small glTF files made from code: a document, the bytes behind it, and what loading it came to.
#pragma once

#include <cstring>
#include <nlohmann/json.hpp>
#include <vector>

#include "scene/load.h"
#include "support/temporary_folder.h"

namespace halflight {

inline std::string base64(const std::vector<uint8_t>& bytes) {
  constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = bytes[i] << 16;
    if (i + 1 < bytes.size()) group |= bytes[i + 1] << 8;
    if (i + 2 < bytes.size()) group |= bytes[i + 2];
    for (size_t k = 0; k < 4; ++k)
      text += i + k < bytes.size() + 1 ? digits[group >> (18 - 6 * k) & 63] : '=';
  }
  return text;
}

/// A document under construction. Bytes go into buffer 0, which is embedded when the file is written.
struct GltfFixture {
  nlohmann::json json = {{"asset", {{"version", "2.0"}}}};
  std::vector<uint8_t> bytes;

  /// Appends values as a buffer view of their own; returns its index.
  template <class T>
  size_t add_view(const std::vector<T>& values, nlohmann::json extra = nlohmann::json::object()) {
    while (bytes.size() % 4 != 0) bytes.push_back(0);
    nlohmann::json view = {
        {"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", values.size() * sizeof(T)}};
    view.update(extra);
    const auto* first = reinterpret_cast<const uint8_t*>(values.data());
    bytes.insert(bytes.end(), first, first + values.size() * sizeof(T));
    json["bufferViews"].push_back(view);
    return json["bufferViews"].size() - 1;
  }

  /// Appends values and an accessor over all of them; returns its index.
  template <class T>
  size_t add_accessor(const std::string& type, const std::vector<T>& values,
                      nlohmann::json extra = nlohmann::json::object()) {
    const size_t view = add_view(values);
    return add_accessor_of(view, type, component<T>(), values.size() / width(type), std::move(extra));
  }

  size_t add_accessor_of(size_t view, const std::string& type, int component_type, size_t count,
                         nlohmann::json extra = nlohmann::json::object()) {
    nlohmann::json accessor = {
        {"bufferView", view}, {"type", type}, {"componentType", component_type}, {"count", count}};
    accessor.update(extra);
    json["accessors"].push_back(accessor);
    return json["accessors"].size() - 1;
  }

  /// A mesh of one primitive shown by one node.
  void show(const nlohmann::json& primitive) {
    json["meshes"].push_back({{"primitives", nlohmann::json::array({primitive})}});
    json["nodes"].push_back({{"mesh", json["meshes"].size() - 1}});
    json["scenes"] = {{{"nodes", nlohmann::json::array()}}};
    for (size_t i = 0; i < json["nodes"].size(); ++i) json["scenes"][0]["nodes"].push_back(i);
  }

  nlohmann::json& primitive() { return json["meshes"][0]["primitives"][0]; }

  /// The text of a .gltf with the bytes as a data: URI, unless buffers are spelled out.
  std::string text() const {
    nlohmann::json out = json;
    if (!bytes.empty() && !out.contains("buffers")) {
      out["buffers"] = {
          {{"byteLength", bytes.size()}, {"uri", "data:application/octet-stream;base64," + base64(bytes)}}};
    }
    return out.dump();
  }

  /// A GLB of the same.
  std::string glb() const {
    nlohmann::json out = json;
    if (!bytes.empty() && !out.contains("buffers")) out["buffers"] = {{{"byteLength", bytes.size()}}};
    std::string text = out.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string bin(bytes.begin(), bytes.end());
    bin.resize((bin.size() + 3) / 4 * 4, '\0');
    std::string file = "glTF" + word(2) + word(static_cast<uint32_t>(12 + 8 + text.size() + 8 + bin.size()));
    file += word(static_cast<uint32_t>(text.size())) + "JSON" + text;
    return file + word(static_cast<uint32_t>(bin.size())) + std::string("BIN\0", 4) + bin;
  }

  static std::string word(uint32_t value) {
    std::string text(4, '\0');
    std::memcpy(text.data(), &value, 4);
    return text;
  }

  template <class T>
  static int component() {
    if constexpr (std::is_same_v<T, float>)
      return 5126;
    else if constexpr (sizeof(T) == 4)
      return 5125;
    else
      return (sizeof(T) == 2 ? 5122 : 5120) + (std::is_unsigned_v<T> ? 1 : 0);
  }
  static size_t width(const std::string& type) {
    if (type == "SCALAR") return 1;
    return type == "MAT4" ? 16 : static_cast<size_t>(type.back() - '0');
  }
};

/// The triangle (0,0,0), (1,0,0), (0,1,0) with indices; accessors 0 (positions) and 1 (indices).
inline GltfFixture triangle_fixture() {
  GltfFixture gltf;
  const size_t positions = gltf.add_accessor<float>("VEC3", {0, 0, 0, 1, 0, 0, 0, 1, 0});
  const size_t indices = gltf.add_accessor<uint16_t>("SCALAR", {0, 1, 2});
  gltf.show({{"attributes", {{"POSITION", positions}}}, {"indices", indices}});
  return gltf;
}

/// What loading came to.
struct LoadOutcome {
  ExitCode exit = ExitCode::ok;
  std::string message;  ///< of the error
  Scene scene;
  std::vector<std::string> warnings;

  /// Whether the error, or else any warning, contains a text.
  bool tells(std::string_view text) const {
    if (message.find(text) != std::string::npos) return true;
    for (const std::string& warning : warnings) {
      if (warning.find(text) != std::string::npos) return true;
    }
    return false;
  }
  std::string all() const {
    std::string text = message;
    for (const std::string& warning : warnings) text += "\n  " + warning;
    return text;
  }
};

inline LoadOutcome load_outcome(const std::filesystem::path& path, const LoadOptions& options = {},
                                bool strict = false) {
  LoadOutcome outcome;
  Messages messages;
  messages.strict = strict;
  try {
    outcome.scene = load_gltf(path, options, messages);
  } catch (const Error& error) {
    outcome.exit = error.code();
    outcome.message = error.what();
  }
  outcome.warnings = messages.warnings;
  return outcome;
}

inline LoadOutcome load_outcome(const GltfFixture& gltf, const LoadOptions& options = {},
                                bool strict = false) {
  const TemporaryFolder folder;
  return load_outcome(folder.write("test.gltf", gltf.text()), options, strict);
}

}  // namespace halflight
