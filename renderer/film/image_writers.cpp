#include "film/image_writers.h"

#include <algorithm>
#include <array>

#include "core/errors.h"
#include "film/tonemap.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STBI_WRITE_NO_STDIO
#define STB_IMAGE_WRITE_STATIC
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb_image_write.h>
#pragma GCC diagnostic pop

namespace halflight {

namespace {

/// Shared-exponent encoding (Ward 1991, "Real Pixels"): mantissas of the brightest channel's exponent.
std::array<uint8_t, 4> to_rgbe(Vec3 color) {
  const Vec3 c = glm::max(is_finite(color) ? color : Vec3(0), Vec3(0));
  int exponent = 0;
  if (!(std::frexp(max_component(c), &exponent) > 0) || exponent < -127) return {0, 0, 0, 0};
  exponent = std::min(exponent, 127);
  const auto mantissa = [&](float v) {
    return static_cast<uint8_t>(std::min(std::ldexp(static_cast<double>(v), 8 - exponent), 255.0));
  };
  return {mantissa(c.x), mantissa(c.y), mantissa(c.z), static_cast<uint8_t>(exponent + 128)};
}

/// One channel of a scan line in the run-length form of Radiance's "new" encoding.
void append_runs(const std::vector<uint8_t>& values, std::string& out) {
  constexpr size_t shortest_run = 4, longest_run = 127, longest_literal = 128;
  const size_t count = values.size();
  for (size_t i = 0; i < count;) {
    const auto run_length = [&](size_t at) {
      size_t length = 1;
      while (at + length < count && length < longest_run && values[at + length] == values[at]) ++length;
      return length;
    };
    if (const size_t run = run_length(i); run >= shortest_run) {
      out += static_cast<char>(128 + run);
      out += static_cast<char>(values[i]);
      i += run;
      continue;
    }
    size_t end = i;
    while (end < count && end - i < longest_literal && run_length(end) < shortest_run) ++end;
    out += static_cast<char>(end - i);
    out.append(values.begin() + static_cast<ptrdiff_t>(i), values.begin() + static_cast<ptrdiff_t>(end));
    i = end;
  }
}

/// Comment lines of a Radiance header; a value of several lines becomes one.
std::string comment_lines(const ImageMetadata& metadata) {
  std::string lines;
  for (auto [key, value] : metadata.text) {
    std::replace_if(
        value.begin(), value.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
    lines += fmt::format("# {}: {}\n", key, value);
  }
  for (const auto& [key, value] : metadata.numbers) lines += fmt::format("# {}: {}\n", key, value);
  return lines;
}

uint32_t crc32(std::string_view bytes) {
  uint32_t crc = ~0u;
  for (const char byte : bytes) {
    crc ^= static_cast<uint8_t>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0u);
  }
  return ~crc;
}

std::string big_endian(uint32_t v) {
  return {static_cast<char>(v >> 24), static_cast<char>(v >> 16), static_cast<char>(v >> 8),
          static_cast<char>(v)};
}

/// A PNG text chunk; keywords are at most 79 bytes long. tEXt holds Latin-1, iTXt UTF-8: an uncompressed one,
/// with neither language nor translated keyword.
std::string text_chunk(const std::string& key, const std::string& value) {
  const bool ascii =
      std::all_of(value.begin(), value.end(), [](char c) { return static_cast<uint8_t>(c) < 128; });
  const std::string keyword = key.substr(0, 79) + '\0';
  const std::string body = ascii ? "tEXt" + keyword + value : "iTXt" + keyword + std::string(4, '\0') + value;
  return big_endian(static_cast<uint32_t>(body.size() - 4)) + body + big_endian(crc32(body));
}

}  // namespace

std::string radiance_bytes(const ImageRgb& image, const ImageMetadata& metadata) {
  std::string out = "#?RADIANCE\n" + comment_lines(metadata);
  out += fmt::format("FORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", image.height, image.width);
  const bool run_lengths = image.width >= 8 && image.width < 32768;  // the widths the encoding exists for
  std::array<std::vector<uint8_t>, 4> channels;
  for (int y = 0; y < image.height; ++y) {
    for (auto& channel : channels) channel.clear();
    for (int x = 0; x < image.width; ++x) {
      const auto rgbe = to_rgbe(image.at(x, y));
      for (size_t c = 0; c < 4; ++c) {
        channels[c].push_back(rgbe[c]);
        if (!run_lengths) out += static_cast<char>(rgbe[c]);
      }
    }
    if (!run_lengths) continue;
    out += {'\x02', '\x02', static_cast<char>(image.width >> 8), static_cast<char>(image.width & 255)};
    for (const auto& channel : channels) append_runs(channel, out);
  }
  return out;
}

void write_radiance(const std::filesystem::path& path, const ImageRgb& image, const ImageMetadata& metadata) {
  write_bytes_atomically(path, radiance_bytes(image, metadata));
}

std::string png_bytes(const ImageRgba8& image, const ImageMetadata& metadata) {
  HALFLIGHT_CHECK(image.width > 0 && image.height > 0);
  // The encoder counts in int and doubles its buffer, and noise grows by an eighth in it.
  constexpr int64_t most_bytes = 1 << 29;
  if (int64_t{4} * image.width * image.height > most_bytes)
    throw Error(ExitCode::failure, fmt::format("{} x {} pixels are too many for a PNG; write an .exr",
                                               image.width, image.height));
  std::string png;
  const auto append = [](void* context, void* data, int size) {
    static_cast<std::string*>(context)->append(static_cast<const char*>(data), static_cast<size_t>(size));
  };
  if (stbi_write_png_to_func(append, &png, image.width, image.height, 4, image.bytes.data(),
                             4 * image.width) == 0)
    throw Error(ExitCode::failure, "encoding a PNG failed");
  std::string chunks = text_chunk("Software", "Halflight");
  for (const auto& [key, value] : metadata.text) chunks += text_chunk(key, value);
  for (const auto& [key, value] : metadata.numbers) chunks += text_chunk(key, fmt::format("{}", value));
  constexpr size_t behind_header = 8 + 25;  // signature and IHDR
  png.insert(behind_header, chunks);
  return png;
}

void write_png(const std::filesystem::path& path, const ImageRgba8& image, const ImageMetadata& metadata) {
  write_bytes_atomically(path, png_bytes(image, metadata));
}

void write_image(const std::filesystem::path& path, const ImageRgb& image, const DisplaySettings& display,
                 const ImageMetadata& metadata) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  if (ending == ".exr") return write_exr(path, image, metadata);
  if (ending == ".hdr") return write_radiance(path, image, metadata);
  if (ending == ".png")
    return write_png(path, display_image(image, display.ev, find_tone_map(display.tonemap)), metadata);
  throw usage_error(fmt::format("{}: unknown ending '{}' (valid: .exr, .hdr, .png)", path.string(), ending));
}

}  // namespace halflight
