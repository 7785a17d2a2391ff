// EXR files made byte by byte: uncompressed scan lines, so that every field can be a wrong one.
#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace halflight {

/// Little-endian bytes of a number.
template <class T>
std::string little(T value) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  return bytes;
}

struct ExrChannel {
  std::string name;
  int32_t type = 2;  ///< 0 unsigned, 1 half, 2 float
  int32_t x_sampling = 1, y_sampling = 1;
};

struct ExrWindow {
  int32_t min_x = 0, min_y = 0, max_x = 0, max_y = 0;
};

/// What an EXR says of itself; pixels are floats, a line at a time, channels in the order given (the format
/// wants them sorted by name).
struct ExrFile {
  std::vector<ExrChannel> channels = {{"B"}, {"G"}, {"R"}};
  ExrWindow data{0, 0, 3, 1}, display{0, 0, 3, 1};
  uint8_t compression = 0;
  uint32_t version = 2;       ///< flags in the upper bytes: 0x200 tiles, 0x800 deep, 0x1000 several parts
  std::string more;           ///< further attributes, before the header's end
  std::vector<float> pixels;  ///< [line][channel][x]

  static std::string attribute(const std::string& name, const std::string& type, const std::string& value) {
    return name + '\0' + type + '\0' + little(static_cast<int32_t>(value.size())) + value;
  }

  std::string header() const {
    const auto box = [](const ExrWindow& w) {
      return little(w.min_x) + little(w.min_y) + little(w.max_x) + little(w.max_y);
    };
    std::string list;
    for (const ExrChannel& c : channels)
      list +=
          c.name + '\0' + little(c.type) + little(int32_t{0}) + little(c.x_sampling) + little(c.y_sampling);
    return "\x76\x2f\x31\x01" + little(version) + attribute("channels", "chlist", list + '\0') +
           attribute("compression", "compression", std::string(1, static_cast<char>(compression))) +
           attribute("dataWindow", "box2i", box(data)) + attribute("displayWindow", "box2i", box(display)) +
           attribute("lineOrder", "lineOrder", std::string(1, '\0')) +
           attribute("pixelAspectRatio", "float", little(1.0f)) +
           attribute("screenWindowCenter", "v2f", little(0.0f) + little(0.0f)) +
           attribute("screenWindowWidth", "float", little(1.0f)) + more + '\0';
  }

  /// The whole file: header, table of offsets, lines.
  std::string bytes() const {
    const std::string head = header();
    const size_t lines = static_cast<size_t>(data.max_y - data.min_y + 1), line = pixels.size() / lines * 4;
    std::string table, body;
    for (size_t y = 0; y < lines; ++y) {
      table += little(static_cast<uint64_t>(head.size() + 8 * lines + body.size()));
      body += little(data.min_y + static_cast<int32_t>(y)) + little(static_cast<int32_t>(line));
      body.append(reinterpret_cast<const char*>(pixels.data()) + y * line, line);
    }
    return head + table + body;
  }
};

/// A small good one: 4×2, value = channel's place + 10 x + 100 y.
inline ExrFile small_exr() {
  ExrFile file;
  for (int y = 0; y < 2; ++y)
    for (int c = 0; c < 3; ++c)
      for (int x = 0; x < 4; ++x) file.pixels.push_back(static_cast<float>(c + 10 * x + 100 * y));
  return file;
}

}  // namespace halflight
