// A PNG made without a library: stored, not compressed.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace halflight {

inline void append_big_endian(std::vector<uint8_t>& bytes, uint32_t value) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<uint8_t>(value >> shift));
}

inline uint32_t png_crc(const std::vector<uint8_t>& bytes) {
  uint32_t crc = 0xffffffffu;
  for (const uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? 0xedb88320u ^ (crc >> 1) : crc >> 1;
  }
  return ~crc;
}

inline void append_png_chunk(std::vector<uint8_t>& png, const char* type, const std::vector<uint8_t>& data) {
  append_big_endian(png, static_cast<uint32_t>(data.size()));
  std::vector<uint8_t> body(type, type + 4);
  body.insert(body.end(), data.begin(), data.end());
  png.insert(png.end(), body.begin(), body.end());
  append_big_endian(png, png_crc(body));
}

/// 8-bit RGBA of one colour. `claimed` is what the header says of width and height; the data are for 1×1.
inline std::vector<uint8_t> make_png(std::array<uint8_t, 4> color, uint32_t claimed = 1) {
  std::vector<uint8_t> png = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
  std::vector<uint8_t> header;
  append_big_endian(header, claimed);
  append_big_endian(header, claimed);
  header.insert(header.end(), {8, 6, 0, 0, 0});
  append_png_chunk(png, "IHDR", header);
  const std::vector<uint8_t> row = {0, color[0], color[1], color[2], color[3]};
  uint32_t a = 1, b = 0;
  for (const uint8_t byte : row) a += byte, b += a;
  std::vector<uint8_t> zlib = {0x78, 0x01, 1, 5, 0, 0xfa, 0xff};
  zlib.insert(zlib.end(), row.begin(), row.end());
  append_big_endian(zlib, (b % 65521) << 16 | a % 65521);
  append_png_chunk(png, "IDAT", zlib);
  append_png_chunk(png, "IEND", {});
  return png;
}

}  // namespace halflight
