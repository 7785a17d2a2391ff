// PNG, JPEG and WebP. Sizes come from the header before anything is decoded.
#include <algorithm>
#include <limits>

#include "scene/image_files.h"

#ifdef HALFLIGHT_HAVE_WEBP
#include <webp/decode.h>
#endif

// Other libraries of the process carry their own copies of these functions: ours stay inside this file.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#pragma GCC diagnostic ignored "-Wsign-compare"
#pragma GCC diagnostic ignored "-Wshadow"
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#define STBI_NO_FAILURE_STRINGS
#include <stb_image.h>
#pragma GCC diagnostic pop

namespace halflight {

namespace {

struct Place {
  std::string_view file, place;
  Error error(std::string_view reason) const { return input_error(file, place, reason); }
};

void check_size(int width, int height, const LoadLimits& limits, const Place& at) {
  if (width <= 0 || height <= 0)
    throw at.error(fmt::format("IMAGE_DATA_INVALID: {} x {} pixels", width, height));
  if (static_cast<uint64_t>(width) * static_cast<uint64_t>(height) > limits.image_pixels) {
    throw at.error(fmt::format("LIMIT: {} x {} pixels, the limit is {} (--limit-image-pixels)", width, height,
                               limits.image_pixels));
  }
}

bool begins_with(std::span<const uint8_t> bytes, std::string_view text, size_t at = 0) {
  return bytes.size() >= at + text.size() &&
         std::equal(text.begin(), text.end(), bytes.begin() + at,
                    [](char a, uint8_t b) { return static_cast<uint8_t>(a) == b; });
}

/// stb fills what a truncated JPEG lacks with grey; a whole one has an end-of-image marker.
bool is_truncated_jpeg(std::span<const uint8_t> bytes) {
  if (bytes[0] != 0xff) return false;
  constexpr uint8_t end_of_image[] = {0xff, 0xd9};
  return std::find_end(bytes.begin(), bytes.end(), std::begin(end_of_image), std::end(end_of_image)) ==
         bytes.end();
}

/// Checks a PNG's size before stb does, which only says that the header is bad. IHDR comes first, at byte 8.
void check_png_size(std::span<const uint8_t> bytes, const LoadLimits& limits, const Place& at) {
  if (bytes.size() < 24 || !begins_with(bytes, "IHDR", 12)) return;
  const auto size_at = [&](size_t i) {
    const uint32_t size =
        static_cast<uint32_t>(bytes[i]) << 24 | bytes[i + 1] << 16 | bytes[i + 2] << 8 | bytes[i + 3];
    return static_cast<int>(std::min<uint32_t>(size, std::numeric_limits<int>::max()));
  };
  check_size(size_at(16), size_at(20), limits, at);
}

ImageRgba8 decode_stb(std::span<const uint8_t> bytes, const LoadLimits& limits, const Place& at) {
  if (bytes.size() > static_cast<size_t>(std::numeric_limits<int>::max()))
    throw at.error("IMAGE_DATA_INVALID: too large");
  const int size = static_cast<int>(bytes.size());
  if (bytes[0] == 0x89) check_png_size(bytes, limits, at);
  int width = 0, height = 0, channels = 0;
  if (!stbi_info_from_memory(bytes.data(), size, &width, &height, &channels)) {
    throw at.error("IMAGE_DATA_INVALID: damaged header");
  }
  check_size(width, height, limits, at);
  if (is_truncated_jpeg(bytes)) throw at.error("IMAGE_DATA_INVALID: truncated");
  stbi_uc* pixels = stbi_load_from_memory(bytes.data(), size, &width, &height, &channels, 4);
  if (!pixels) throw at.error("IMAGE_DATA_INVALID: damaged or truncated");
  ImageRgba8 image;
  image.width = width;
  image.height = height;
  try {
    image.bytes.assign(pixels, pixels + 4 * static_cast<size_t>(width) * height);
  } catch (...) {
    stbi_image_free(pixels);
    throw;
  }
  stbi_image_free(pixels);
  return image;
}

ImageRgba8 decode_webp(std::span<const uint8_t> bytes, const LoadLimits& limits, const Place& at) {
#ifdef HALFLIGHT_HAVE_WEBP
  int width = 0, height = 0;
  if (!WebPGetInfo(bytes.data(), bytes.size(), &width, &height))
    throw at.error("IMAGE_DATA_INVALID: damaged header");
  check_size(width, height, limits, at);
  ImageRgba8 image;
  image.width = width;
  image.height = height;
  image.bytes.resize(4 * static_cast<size_t>(width) * height);
  if (!WebPDecodeRGBAInto(bytes.data(), bytes.size(), image.bytes.data(), image.bytes.size(), 4 * width)) {
    throw at.error("IMAGE_DATA_INVALID: damaged or truncated");
  }
  return image;
#else
  throw at.error("IMAGE_UNRECOGNIZED_FORMAT: this build cannot read WebP");
#endif
}

}  // namespace

ImageRgba8 decode_ldr(std::span<const uint8_t> bytes, const LoadLimits& limits, std::string_view file,
                      std::string_view place) {
  const Place at{file, place};
  if (begins_with(bytes, "\x89PNG") || begins_with(bytes, "\xff\xd8\xff"))
    return decode_stb(bytes, limits, at);
  if (begins_with(bytes, "RIFF") && begins_with(bytes, "WEBP", 8)) return decode_webp(bytes, limits, at);
  throw at.error("IMAGE_UNRECOGNIZED_FORMAT: not PNG, JPEG or WebP");
}

}  // namespace halflight
