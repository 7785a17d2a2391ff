// A glTF file before its contents are understood: container, JSON text, paths, and how faults are worded.
// Codes are those of the Khronos glTF validator (ISSUES.md of KhronosGroup/glTF-Validator).
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "scene/load.h"

namespace halflight {

/// An opened file. Owns the bytes that everything else points into.
struct GltfSource {
  std::string name;              ///< as the user gave it; opens every message
  std::filesystem::path folder;  ///< what relative URIs start from and may not leave
  const LoadOptions* options = nullptr;
  std::vector<uint8_t> bytes;    ///< the whole file
  std::span<const uint8_t> bin;  ///< a GLB's BIN chunk, inside `bytes`
  bool binary = false;           ///< a GLB
  bool has_bin = false;
  nlohmann::json root;  ///< an object

  /// Faults that do not stop the import, by code: the first is told in full, the others are counted.
  struct Fault {
    std::string text;
    size_t count = 0;
  };
  std::map<std::string, Fault, std::less<>> faults;

  /// Throws input_error: `name: place: CODE: reason`.
  [[noreturn]] void fail(std::string_view place, std::string_view code, std::string_view reason) const;
  /// Notes a fault that can be lived with.
  void warn(std::string_view place, std::string_view code, std::string_view reason);
  /// Hands the noted faults to `messages`, one line a code.
  void report(Messages& messages);
};

/// Reads a .gltf or .glb file up to the parsed JSON. Throws Error (exit code 3): GLB_* and INVALID_JSON
/// codes, a file that is neither, one over a limit.
GltfSource open_gltf(const std::filesystem::path&, const LoadOptions&, Messages&);

/// Text of a file in a message: control characters become '?', long texts are cut.
std::string printable(std::string_view);

/// Path a relative URI stands for. Refused: schemes (http:, file:), and whatever leaves the asset's folder
/// (`..`, absolute, percent-encoded, through links) unless LoadOptions::allow_external.
std::filesystem::path resolve_uri(const GltfSource&, std::string_view uri, std::string_view place);

bool is_data_uri(std::string_view uri);

/// Bytes of a data: URI (base64 or percent-encoded). More than `limit` bytes are refused before they are
/// decoded.
std::vector<uint8_t> decode_data_uri(const GltfSource&, std::string_view uri, uint64_t limit,
                                     std::string_view place);

}  // namespace halflight
