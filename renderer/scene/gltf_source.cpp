#include "scene/gltf_source.h"

#include <cstring>

#include "scene/image_files.h"

namespace halflight {

namespace {

using nlohmann::json;

constexpr uint32_t glb_magic = 0x46546c67, json_chunk = 0x4e4f534a, bin_chunk = 0x004e4942;

uint32_t little_endian32(std::span<const uint8_t> bytes, size_t at) {
  return bytes[at] | bytes[at + 1] << 8 | bytes[at + 2] << 16 | static_cast<uint32_t>(bytes[at + 3]) << 24;
}

/// Splits a GLB into its chunks; returns the JSON text and sets the BIN chunk.
std::string_view read_glb_chunks(GltfSource& source) {
  const std::span<const uint8_t> file = source.bytes;
  if (file.size() < 12) source.fail("", "GLB_UNEXPECTED_END_OF_HEADER", fmt::format("{} bytes", file.size()));
  const uint32_t version = little_endian32(file, 4), length = little_endian32(file, 8);
  if (version == 1) source.fail("", "GLB_INVALID_VERSION", "glTF 1.0; only 2.0 is read");
  if (version != 2) source.fail("", "GLB_INVALID_VERSION", fmt::format("version {}", version));
  if (length <= 12) source.fail("", "GLB_LENGTH_TOO_SMALL", fmt::format("declared length {}", length));
  if (length != file.size()) {
    source.fail("", "GLB_LENGTH_MISMATCH",
                fmt::format("declared length {}, the file has {} bytes", length, file.size()));
  }

  std::string_view text;
  bool has_json = false;
  for (size_t at = 12; at < file.size();) {
    if (file.size() - at < 8) {
      source.fail("", "GLB_UNEXPECTED_END_OF_CHUNK_HEADER", fmt::format("at byte {}", at));
    }
    const uint32_t size = little_endian32(file, at), type = little_endian32(file, at + 4);
    at += 8;
    if (size % 4 != 0) {
      source.fail("", "GLB_CHUNK_LENGTH_UNALIGNED", fmt::format("chunk of {} bytes", size));
    }
    if (size > file.size() - at) {
      source.fail("", "GLB_CHUNK_TOO_BIG",
                  fmt::format("chunk of {} bytes, {} are left", size, file.size() - at));
    }
    if (!has_json && type != json_chunk) {
      source.fail("", "GLB_UNEXPECTED_FIRST_CHUNK", fmt::format("type 0x{:08x} instead of JSON", type));
    }
    if ((type == json_chunk && has_json) || (type == bin_chunk && source.has_bin)) {
      source.fail("", "GLB_DUPLICATE_CHUNK", fmt::format("type 0x{:08x}", type));
    }
    const auto chunk = file.subspan(at, size);
    if (type == json_chunk) {
      text = {reinterpret_cast<const char*>(chunk.data()), chunk.size()};
      has_json = true;
    } else if (type == bin_chunk) {
      source.bin = chunk;
      source.has_bin = true;
    }
    at += size;
  }
  if (!has_json) source.fail("", "GLB_UNEXPECTED_END_OF_CHUNK_HEADER", "no JSON chunk");
  return text;
}

/// Deepest nesting of brackets outside strings, stopped at `limit` + 1. Runs before the parser, which
/// recurses.
uint32_t nesting_depth(std::string_view text, uint32_t limit) {
  uint32_t depth = 0, deepest = 0;
  bool in_string = false;
  for (size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (in_string) {
      if (c == '\\') ++i;
      if (c == '"') in_string = false;
    } else if (c == '"') {
      in_string = true;
    } else if (c == '[' || c == '{') {
      deepest = std::max(deepest, ++depth);
      if (deepest > limit) break;
    } else if ((c == ']' || c == '}') && depth > 0) {
      --depth;
    }
  }
  return deepest;
}

void parse_json(GltfSource& source, std::string_view text) {
  constexpr std::string_view byte_order_mark = "\xef\xbb\xbf";
  if (text.starts_with(byte_order_mark)) {
    source.warn("", "INVALID_JSON", "begins with a byte order mark");
    text.remove_prefix(byte_order_mark.size());
  }
  const uint32_t limit = source.options->limits.json_depth;
  if (nesting_depth(text, limit) > limit) {
    source.fail("", "INVALID_JSON", fmt::format("nested deeper than {} (--limit-json-depth)", limit));
  }
  try {
    source.root = json::parse(text.begin(), text.end());
  } catch (const json::parse_error& error) {
    source.fail("", "INVALID_JSON", fmt::format("syntax error at byte {}", error.byte));
  } catch (const json::exception&) {
    source.fail("", "INVALID_JSON", "a number is out of range");
  }
  if (!source.root.is_object()) source.fail("", "TYPE_MISMATCH", "the JSON is not an object");
}

// ---- URIs ----

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::string percent_decoded(std::string_view uri) {
  std::string text;
  text.reserve(uri.size());
  for (size_t i = 0; i < uri.size(); ++i) {
    const bool escape =
        uri[i] == '%' && i + 2 < uri.size() && hex_digit(uri[i + 1]) >= 0 && hex_digit(uri[i + 2]) >= 0;
    text += escape ? static_cast<char>(hex_digit(uri[i + 1]) * 16 + hex_digit(uri[i + 2])) : uri[i];
    if (escape) i += 2;
  }
  return text;
}

/// RFC 3986: a letter, then letters, digits and "+-.", up to a colon.
bool has_scheme(std::string_view uri) {
  const size_t colon = uri.find(':');
  if (colon == std::string_view::npos) return false;
  if (colon == 0) return true;
  for (size_t i = 0; i < colon; ++i) {
    const char c = uri[i];
    const bool letter = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
    const bool other = (c >= '0' && c <= '9') || c == '+' || c == '-' || c == '.';
    if (!letter && !(other && i > 0)) return false;
  }
  return true;
}

bool is_inside(const std::filesystem::path& path, const std::filesystem::path& folder) {
  const auto [end, rest] = std::mismatch(folder.begin(), folder.end(), path.begin(), path.end());
  return end == folder.end();
}

int base64_value(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+' || c == '-') return 62;
  if (c == '/' || c == '_') return 63;
  return -1;
}

/// False where a character is not base64's.
bool decode_base64(std::string_view text, std::vector<uint8_t>& bytes) {
  bytes.reserve(text.size() / 4 * 3 + 3);
  uint32_t buffer = 0;
  int bits = 0;
  for (const char c : text) {
    const int value = base64_value(c);
    if (value < 0) return false;
    buffer = buffer << 6 | static_cast<uint32_t>(value);
    bits += 6;
    if (bits >= 8) {
      bits -= 8;
      bytes.push_back(static_cast<uint8_t>(buffer >> bits));
    }
  }
  return bits < 6;
}

}  // namespace

void GltfSource::fail(std::string_view place, std::string_view code, std::string_view reason) const {
  throw input_error(name, printable(place), fmt::format("{}: {}", code, reason));
}

void GltfSource::warn(std::string_view place, std::string_view code, std::string_view reason) {
  Fault& fault = faults[std::string(code)];
  if (fault.count++ == 0)
    fault.text = input_error(name, printable(place), fmt::format("{}: {}", code, reason)).what();
}

void GltfSource::report(Messages& messages) {
  for (const auto& [code, fault] : faults) {
    messages.warn(fault.count == 1 ? fault.text
                                   : fmt::format("{} (and {} more like it)", fault.text, fault.count - 1));
  }
  faults.clear();
}

GltfSource open_gltf(const std::filesystem::path& path, const LoadOptions& options, Messages& messages) {
  GltfSource source;
  source.name = path.string();
  source.folder = path.parent_path().empty() ? std::filesystem::path(".") : path.parent_path();
  source.options = &options;
  source.bytes = read_file(path, options.limits.buffer_bytes);
  if (source.bytes.empty()) source.fail("", "GLB_UNEXPECTED_END_OF_HEADER", "the file is empty");

  source.binary = source.bytes.size() >= 4 && little_endian32(source.bytes, 0) == glb_magic;
  if (source.binary) {
    parse_json(source, read_glb_chunks(source));
    return source;
  }
  if (path.extension() == ".glb" || path.extension() == ".GLB") {
    if (source.bytes.size() < 12) {
      source.fail("", "GLB_UNEXPECTED_END_OF_HEADER", fmt::format("{} bytes", source.bytes.size()));
    }
    source.fail("", "GLB_INVALID_MAGIC", "does not begin with 'glTF'");
  }
  parse_json(source, {reinterpret_cast<const char*>(source.bytes.data()), source.bytes.size()});
  source.bytes = {};
  return source;
}

std::string printable(std::string_view text) {
  constexpr size_t longest = 120;
  std::string result;
  for (const char c : text.substr(0, longest)) {
    const bool control = static_cast<unsigned char>(c) < 32 || c == 127;
    result += control ? '?' : c;
  }
  if (text.size() > longest) result += "…";
  return result;
}

std::filesystem::path resolve_uri(const GltfSource& source, std::string_view uri, std::string_view place) {
  namespace fs = std::filesystem;
  if (has_scheme(uri)) {
    source.fail(place, "INVALID_URI",
                fmt::format("'{}' is not a relative path; nothing is fetched", printable(uri)));
  }
  const std::string decoded = percent_decoded(uri);
  if (decoded.empty() || decoded.find('\0') != std::string::npos) {
    source.fail(place, "INVALID_URI", fmt::format("'{}' names no file", printable(uri)));
  }
  const fs::path path = source.folder / decoded;
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    source.fail(place, "IO_ERROR", fmt::format("'{}' is no regular file", printable(uri)));
  }
  if (source.options->allow_external) return path;

  const auto leaves = [&] {
    source.fail(place, "INVALID_URI",
                fmt::format("'{}' leaves the asset's folder (--allow-external opens it)", printable(uri)));
  };
  const fs::path relative = fs::path(decoded).lexically_normal();
  if (relative.is_absolute() || *relative.begin() == "..") leaves();
  const fs::path folder = fs::canonical(source.folder, error);
  if (error) source.fail(place, "IO_ERROR", fmt::format("'{}': {}", printable(uri), error.message()));
  const fs::path real = fs::weakly_canonical(path, error);
  if (error) source.fail(place, "IO_ERROR", fmt::format("'{}': {}", printable(uri), error.message()));
  if (!is_inside(real, folder)) leaves();
  return path;
}

bool is_data_uri(std::string_view uri) {
  constexpr std::string_view scheme = "data:";
  if (uri.size() < scheme.size()) return false;
  return std::equal(scheme.begin(), scheme.end(), uri.begin(),
                    [](char a, char b) { return a == (b >= 'A' && b <= 'Z' ? b - 'A' + 'a' : b); });
}

std::vector<uint8_t> decode_data_uri(const GltfSource& source, std::string_view uri, uint64_t limit,
                                     std::string_view place) {
  const size_t comma = uri.find(',');
  if (comma == std::string_view::npos) source.fail(place, "INVALID_URI", "a data: URI without a comma");
  const std::string_view header = uri.substr(0, comma);
  std::string_view payload = uri.substr(comma + 1);
  if (!header.ends_with(";base64")) {
    const std::string text = percent_decoded(payload);
    if (text.size() > limit) {
      source.fail(place, "BUFFER_BYTE_LENGTH_MISMATCH",
                  fmt::format("the data: URI has {} bytes, {} are declared", text.size(), limit));
    }
    return {text.begin(), text.end()};
  }
  std::string unescaped;
  if (payload.find('%') != std::string_view::npos) payload = unescaped = percent_decoded(payload);
  while (payload.ends_with('=')) payload.remove_suffix(1);
  const uint64_t size = payload.size() / 4 * 3 + payload.size() % 4 * 3 / 4;
  if (size > limit) {
    source.fail(place, "BUFFER_BYTE_LENGTH_MISMATCH",
                fmt::format("the data: URI has {} bytes, {} are declared", size, limit));
  }
  std::vector<uint8_t> bytes;
  if (!decode_base64(payload, bytes)) source.fail(place, "INVALID_URI", "not valid base64");
  return bytes;
}

}  // namespace halflight
