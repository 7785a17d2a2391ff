// The bytes behind buffers.
#include "scene/gltf_document.h"
#include "scene/gltf_json.h"
#include "scene/image_files.h"

namespace halflight {

namespace {

/// The GLB's BIN chunk, padded to 4 bytes, belongs to a first buffer without a URI.
void use_bin_chunk(const JsonObject& object, GltfBuffer& buffer) {
  const GltfSource& source = object.source();
  if (!source.has_bin) object.fail("", "BUFFER_MISSING_GLB_DATA", "the GLB has no BIN chunk");
  if (source.bin.size() < buffer.length) {
    object.fail("byteLength", "BUFFER_BYTE_LENGTH_MISMATCH",
                fmt::format("{} bytes declared, the BIN chunk has {}", buffer.length, source.bin.size()));
  }
  buffer.bytes = source.bin.first(buffer.length);
}

void read_uri(const JsonObject& object, GltfBuffer& buffer, uint64_t budget) {
  const GltfSource& source = object.source();
  const std::string uri = object.string("uri");
  const std::string place = object.place_of("uri");
  constexpr uint64_t padding = 3;  // writers round up to a multiple of four
  if (is_data_uri(uri)) {
    buffer.owned = decode_data_uri(source, uri, buffer.length + padding, place);
  } else {
    const auto path = resolve_uri(source, uri, place);
    try {
      buffer.owned = read_file(path, budget);
    } catch (const Error& error) {
      source.fail(place, "IO_ERROR", error.what());
    }
  }
  if (buffer.owned.size() < buffer.length) {
    object.fail("byteLength", "BUFFER_BYTE_LENGTH_MISMATCH",
                fmt::format("{} bytes declared, there are {}", buffer.length, buffer.owned.size()));
  }
  buffer.bytes = std::span<const uint8_t>(buffer.owned).first(buffer.length);
}

}  // namespace

void load_buffers(GltfSource& source, GltfDocument& document) {
  uint64_t budget = source.options->limits.buffer_bytes;
  JsonObject(source).for_each("buffers", [&](const JsonObject& object) {
    object.require("byteLength");
    GltfBuffer buffer;
    buffer.length = object.integer("byteLength", 0, 1);
    const bool has_uri = object.has("uri");
    if (buffer.length > budget && (has_uri || source.binary)) {
      object.fail("byteLength", "LIMIT",
                  fmt::format("{} bytes, the limit for all buffers is {} (--limit-buffer-bytes)",
                              buffer.length, source.options->limits.buffer_bytes));
    }
    if (has_uri) {
      read_uri(object, buffer, budget);
    } else if (source.binary && document.buffers.empty()) {
      use_bin_chunk(object, buffer);
    }
    budget -= std::min<uint64_t>(budget, buffer.bytes.size());
    document.buffers.push_back(std::move(buffer));
  });
}

}  // namespace halflight
