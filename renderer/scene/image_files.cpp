#include "scene/image_files.h"

#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>

namespace halflight {

namespace {

bool starts_with(std::span<const uint8_t> bytes, std::string_view signature) {
  return bytes.size() >= signature.size() &&
         std::memcmp(bytes.data(), signature.data(), signature.size()) == 0;
}

constexpr std::string_view exr_signature("\x76\x2f\x31\x01", 4);

/// IEC 61966-2-1 for each of the 256 codes.
std::array<float, 256> srgb_table() {
  std::array<float, 256> table{};
  for (size_t i = 0; i < table.size(); ++i) {
    const double v = static_cast<double>(i) / 255;
    table[i] = static_cast<float>(v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4));
  }
  return table;
}

}  // namespace

std::vector<uint8_t> read_file(const std::filesystem::path& path, uint64_t limit) {
  std::error_code code;
  const auto status = std::filesystem::status(path, code);
  if (!std::filesystem::exists(status)) throw input_error(path.string(), "", "no such file");
  if (std::filesystem::is_directory(status))
    throw input_error(path.string(), "", "it is a folder, not a file");
  errno = 0;
  std::ifstream file(path, std::ios::binary);
  if (!file) throw input_error(path.string(), "", errno != 0 ? std::strerror(errno) : "cannot be opened");

  std::vector<uint8_t> bytes;
  if (std::filesystem::is_regular_file(status)) {
    const uint64_t size = std::filesystem::file_size(path, code);
    if (size > limit)
      throw input_error(path.string(), "", fmt::format("{} bytes exceed the limit of {}", size, limit));
    bytes.reserve(size + 1);
  }
  // In pieces: a pipe has no size, and a file may grow while it is read.
  constexpr size_t piece = 1 << 20;
  while (file) {
    const size_t have = bytes.size();
    bytes.resize(have + piece);
    file.read(reinterpret_cast<char*>(bytes.data() + have), static_cast<std::streamsize>(piece));
    bytes.resize(have + static_cast<size_t>(file.gcount()));
    if (bytes.size() > limit)
      throw input_error(path.string(), "", fmt::format("more than the limit of {} bytes", limit));
  }
  if (file.bad()) throw input_error(path.string(), "", "reading failed");
  return bytes;
}

ImageRgb read_image(const std::filesystem::path& path, const LoadLimits& limits) {
  const std::vector<uint8_t> bytes = read_file(path, limits.buffer_bytes);
  const std::string name = path.string();
  if (bytes.empty()) throw input_error(name, "", "the file is empty");
  if (starts_with(bytes, exr_signature)) return decode_exr(bytes, limits, name);
  if (starts_with(bytes, "#?")) return decode_radiance(bytes, limits, name);

  if (!starts_with(bytes, "\x89PNG") && !starts_with(bytes, "\xff\xd8\xff") && !starts_with(bytes, "RIFF"))
    throw input_error(name, "", "not Radiance, OpenEXR, PNG, JPEG or WebP");

  static const std::array<float, 256> decode = srgb_table();
  const ImageRgba8 ldr = decode_ldr(bytes, limits, name, "");
  ImageRgb image(ldr.width, ldr.height);
  for (size_t i = 0; i < image.pixels.size(); ++i)
    image.pixels[i] = {decode[ldr.bytes[4 * i]], decode[ldr.bytes[4 * i + 1]], decode[ldr.bytes[4 * i + 2]]};
  return image;
}

}  // namespace halflight
