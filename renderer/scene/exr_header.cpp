// Layout: "OpenEXR File Layout" (openexr.com): magic number, version and flags, then for each part attributes
// NAME\0 TYPE\0 SIZE VALUE up to an empty name; several parts end with an empty one.
#include "scene/exr_header.h"

#include <algorithm>
#include <cstring>
#include <string>

#include "core/errors.h"

namespace halflight {

namespace {

class HeaderWalk {
 public:
  HeaderWalk(std::span<const uint8_t> bytes, const LoadLimits& limits, std::string_view file)
      : bytes_(bytes), limits_(limits), file_(file) {}

  void run() {
    constexpr uint32_t several_parts = 0x1000;
    take(4, "header");
    const bool multipart = (number(take(4, "header"), 0) & several_parts) != 0;
    while (check_part() && multipart) {
    }
  }

 private:
  using Bytes = std::span<const uint8_t>;

  [[noreturn]] void fail(const std::string& place, const std::string& reason) const {
    throw input_error(file_, place, reason);
  }

  Bytes take(uint64_t count, const std::string& place) {
    if (count > bytes_.size())
      fail(place, fmt::format("truncated: needs {} bytes, {} are left", count, bytes_.size()));
    const Bytes taken = bytes_.first(count);
    bytes_ = bytes_.subspan(count);
    return taken;
  }

  std::string take_name() {
    constexpr size_t longest = 255;
    const size_t reach = std::min(bytes_.size(), longest + 1);
    const auto end = std::find(bytes_.begin(), bytes_.begin() + static_cast<ptrdiff_t>(reach), uint8_t{0});
    const size_t length = static_cast<size_t>(end - bytes_.begin());
    if (length == reach) fail("header", bytes_.size() > longest ? "a name without end" : "truncated");
    const Bytes name = take(length + 1, "header");
    std::string text(name.begin(), name.end() - 1);
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < 32 || c > 126; }, '?');
    return text;
  }

  static uint32_t number(Bytes value, size_t at) {
    return static_cast<uint32_t>(value[at]) | static_cast<uint32_t>(value[at + 1]) << 8 |
           static_cast<uint32_t>(value[at + 2]) << 16 | static_cast<uint32_t>(value[at + 3]) << 24;
  }
  static int64_t signed_number(Bytes value, size_t at) { return static_cast<int32_t>(number(value, at)); }

  /// False at the empty part that ends a list of them.
  bool check_part() {
    for (bool first = true;; first = false) {
      const std::string name = take_name();
      if (name.empty()) return !first;
      const std::string type = take_name();
      const int64_t size = signed_number(take(4, name), 0);
      if (size < 0) fail(name, fmt::format("{} bytes are no size", size));
      check_value(name, type, take(static_cast<uint64_t>(size), name));
    }
  }

  void check_value(const std::string& name, const std::string& type, Bytes value) const {
    if (type == "box2i" && (name == "dataWindow" || name == "displayWindow")) check_window(name, value);
    if (type == "stringvector") check_strings(name, value);
    if (type == "preview") check_preview(name, value);
    // A table of that many offsets of eight bytes follows.
    if (name == "chunkCount" && value.size() == 4 && uint64_t{number(value, 0)} * 8 > bytes_.size())
      fail(name, fmt::format("{} blocks do not fit the file", number(value, 0)));
  }

  void check_window(const std::string& name, Bytes value) const {
    if (value.size() != 16) fail(name, "is not four numbers");
    const int64_t width = signed_number(value, 8) - signed_number(value, 0) + 1,
                  height = signed_number(value, 12) - signed_number(value, 4) + 1;
    if (width <= 0 || height <= 0) fail(name, fmt::format("{} x {} is no picture size", width, height));
    constexpr int64_t longest_side = 1 << 24;
    if (width > longest_side || height > longest_side)
      fail(name, fmt::format("{} x {} pixels: sides end at {}", width, height, longest_side));
    if (static_cast<uint64_t>(width * height) > limits_.image_pixels)
      fail(name,
           fmt::format("{} x {} pixels exceed --limit-image-pixels {}", width, height, limits_.image_pixels));
  }

  void check_strings(const std::string& name, Bytes value) const {
    while (!value.empty()) {
      const uint64_t length = value.size() < 4 ? value.size() : number(value, 0);
      if (value.size() < 4 || length > value.size() - 4) fail(name, "a text goes past the attribute's end");
      value = value.subspan(4 + length);
    }
  }

  void check_preview(const std::string& name, Bytes value) const {
    if (value.size() < 8 || uint64_t{number(value, 0)} * number(value, 4) != (value.size() - 8) / 4)
      fail(name, "its size is not its width times its height");
  }

  Bytes bytes_;
  const LoadLimits& limits_;
  std::string_view file_;
};

}  // namespace

void check_exr_header(std::span<const uint8_t> bytes, const LoadLimits& limits, std::string_view file) {
  HeaderWalk(bytes, limits, file).run();
}

}  // namespace halflight
