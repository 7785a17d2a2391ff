// OpenEXR from memory: the first flat part that has colour. The header is checked before anything of its size
// is allocated, and pixels are read in bands, so that a file cut short fails before its whole claim takes
// memory.
#include <OpenEXR/IexBaseExc.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfCompression.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfRgbaFile.h>
#include <OpenEXR/ImfTileDescription.h>

#include <algorithm>
#include <array>
#include <new>
#include <optional>

#include "scene/exr_header.h"
#include "scene/image_files.h"

namespace halflight {

namespace {

using Window = Imath::Box2i;

class MemoryInput : public Imf::IStream {
 public:
  MemoryInput(std::span<const uint8_t> bytes, const std::string& name)
      : Imf::IStream(name.c_str()), bytes_(bytes) {}

  bool read(char out[], int count) override {
    const auto wanted = static_cast<uint64_t>(std::max(count, 0));
    if (at_ > bytes_.size() || wanted > bytes_.size() - at_) throw Iex::InputExc("truncated");
    std::copy_n(bytes_.begin() + static_cast<ptrdiff_t>(at_), wanted, out);
    at_ += wanted;
    return at_ < bytes_.size();
  }
  uint64_t tellg() override { return at_; }
  void seekg(uint64_t position) override { at_ = position; }

 private:
  std::span<const uint8_t> bytes_;
  uint64_t at_ = 0;
};

/// Where the picture is among a part's channels.
struct ColorChannels {
  std::array<std::string, 3> names;  ///< for red, green, blue; all the same for luminance
  bool chroma = false;               ///< beside luminance stand RY and BY
};

/// R, G and B, of the first layer that has them where the part has no plain ones, else Y.
std::optional<ColorChannels> find_color(const Imf::ChannelList& channels) {
  const auto layer = [&](const std::string& prefix) -> std::optional<ColorChannels> {
    if (!channels.findChannel(prefix + "R") || !channels.findChannel(prefix + "G") ||
        !channels.findChannel(prefix + "B"))
      return {};
    return ColorChannels{{prefix + "R", prefix + "G", prefix + "B"}};
  };
  if (const auto plain = layer("")) return plain;
  if (channels.findChannel("Y"))
    return ColorChannels{{"Y", "Y", "Y"}, channels.findChannel("RY") && channels.findChannel("BY")};
  for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
    const std::string name = channel.name();
    if (!name.ends_with(".R")) continue;
    if (const auto found = layer(name.substr(0, name.size() - 1))) return found;
  }
  return {};
}

bool is_flat(const Imf::Header& header) {
  return !header.hasType() || header.type() == Imf::SCANLINEIMAGE || header.type() == Imf::TILEDIMAGE;
}

int64_t width_of(const Window& window) { return int64_t{window.max.x} - window.min.x + 1; }
int64_t height_of(const Window& window) { return int64_t{window.max.y} - window.min.y + 1; }

/// Lines that are compressed together (OpenEXR file layout, "Compression").
uint64_t lines_in_block(Imf::Compression compression) {
  switch (compression) {
    case Imf::NO_COMPRESSION:
    case Imf::RLE_COMPRESSION:
    case Imf::ZIPS_COMPRESSION:
      return 1;
    case Imf::ZIP_COMPRESSION:
    case Imf::PXR24_COMPRESSION:
      return 16;
    case Imf::PIZ_COMPRESSION:
    case Imf::B44_COMPRESSION:
    case Imf::B44A_COMPRESSION:
    case Imf::DWAA_COMPRESSION:
      return 32;
    default:
      return 256;
  }
}

/// The library decodes a block of lines, or a row of tiles, of all channels at once.
void check_block(const Imf::Header& header, const std::string& name) {
  constexpr uint64_t largest = uint64_t{1} << 30;
  uint64_t bytes_a_pixel = 0;
  for (auto channel = header.channels().begin(); channel != header.channels().end(); ++channel)
    bytes_a_pixel += channel.channel().type == Imf::HALF ? 2 : 4;
  uint64_t width = static_cast<uint64_t>(width_of(header.dataWindow()));
  uint64_t lines = lines_in_block(header.compression());
  if (header.hasTileDescription()) {
    lines = header.tileDescription().ySize;
    width = std::max<uint64_t>(width, header.tileDescription().xSize);
  }
  if (bytes_a_pixel * width > largest / std::max<uint64_t>(lines, 1))
    throw input_error(name, "header",
                      fmt::format("blocks of {} lines of {} pixels are too large", lines, width));
}

/// A display window is filled whatever the file holds: a few bytes must not ask for gigabytes.
void check_display(const Window& window, const Window& display, const std::string& name) {
  constexpr int64_t always_fine = 1 << 24, most_black = 64;
  const int64_t stored = width_of(window) * height_of(window), shown = width_of(display) * height_of(display);
  if (shown > always_fine && shown / most_black > stored)
    throw input_error(name, "displayWindow",
                      fmt::format("{} x {} pixels, of which only {} x {} are in the file", width_of(display),
                                  height_of(display), width_of(window), height_of(window)));
}

/// The library's reconstruction of colour knows one part, and holds some thirty lines of the picture.
void check_luminance_chroma(const Imf::MultiPartInputFile& file, int index, const std::string& name) {
  constexpr int64_t widest = 1 << 20;
  if (file.parts() > 1)
    throw input_error(name, fmt::format("part {}", index),
                      "luminance and chroma are read from single-part files only");
  if (width_of(file.header(index).dataWindow()) > widest)
    throw input_error(name, "dataWindow",
                      fmt::format("luminance and chroma are read up to {} pixels wide", widest));
}

/// Lines to read at a time: whole blocks of lines or rows of tiles, about a million pixels.
int lines_in_band(const Imf::Header& header) {
  constexpr int64_t pixels = 1 << 20;
  const Window window = header.dataWindow();
  const int64_t lines = header.hasTileDescription()
                            ? std::max<int64_t>(1, header.tileDescription().ySize)
                            : static_cast<int64_t>(lines_in_block(header.compression()));
  const int64_t blocks = std::max<int64_t>(1, pixels / (lines * width_of(window)));
  return static_cast<int>(std::min(lines * blocks, height_of(window)));
}

/// An image of the window's size whose pixels are yet to come: memory that is not written to is not taken.
ImageRgb reserved_image(const Window& window) {
  ImageRgb image;
  image.width = static_cast<int>(width_of(window)), image.height = static_cast<int>(height_of(window));
  image.pixels.reserve(static_cast<size_t>(image.width) * static_cast<size_t>(image.height));
  return image;
}

/// Luminance and two chroma channels at half the resolution, through the library's own reconstruction.
ImageRgb read_luminance_chroma(MemoryInput& stream, const Window& window) {
  stream.seekg(0);
  Imf::RgbaInputFile file(stream);
  ImageRgb image = reserved_image(window);
  std::vector<Imf::Rgba> line(static_cast<size_t>(image.width));
  // The library adds x times the stride to an address that may lie outside the line.
  const auto base = reinterpret_cast<uintptr_t>(line.data()) -
                    sizeof(Imf::Rgba) * static_cast<uintptr_t>(int64_t{window.min.x});
  file.setFrameBuffer(reinterpret_cast<Imf::Rgba*>(base), 1, 0);
  for (int row = 0; row < image.height; ++row) {
    file.readPixels(window.min.y + row);
    for (const Imf::Rgba& pixel : line) image.pixels.emplace_back(pixel.r, pixel.g, pixel.b);
  }
  return image;
}

/// The pixels of the data window, in bands that no block crosses.
ImageRgb read_channels(Imf::MultiPartInputFile& file, int index, const ColorChannels& color) {
  const Imf::Header& header = file.header(index);
  const Window window = header.dataWindow();
  const int band_height = lines_in_band(header);
  Imf::InputPart part(file, index);
  ImageRgb image = reserved_image(window);
  for (int64_t top = window.min.y; top <= window.max.y; top += band_height) {
    const int y = static_cast<int>(top);
    const int last = static_cast<int>(std::min<int64_t>(window.max.y, top + band_height - 1));
    const Window band_window({window.min.x, y}, {window.max.x, last});
    ImageRgb band(image.width, last - y + 1);
    Imf::FrameBuffer buffer;
    const bool luminance = color.names[0] == color.names[1];
    for (int c = 0; c < (luminance ? 1 : 3); ++c)
      buffer.insert(color.names[c],
                    Imf::Slice::Make(Imf::FLOAT, &band.pixels[0].x + c, band_window, sizeof(Vec3),
                                     sizeof(Vec3) * static_cast<size_t>(image.width)));
    part.setFrameBuffer(buffer);
    part.readPixels(y, last);
    if (luminance)
      for (Vec3& pixel : band.pixels) pixel = Vec3(pixel.x);
    image.pixels.insert(image.pixels.end(), band.pixels.begin(), band.pixels.end());
  }
  return image;
}

/// The data window cut and padded with black to the display window: that is the picture, and an environment's
/// directions hang on where its borders are.
ImageRgb to_display(ImageRgb data, const Window& window, const Window& display, const std::string& name) {
  if (window == display) return data;
  if (!window.intersects(display)) throw input_error(name, "dataWindow", "lies outside the display window");
  ImageRgb image(static_cast<int>(width_of(display)), static_cast<int>(height_of(display)));
  for (int y = std::max(window.min.y, display.min.y); y <= std::min(window.max.y, display.max.y); ++y)
    for (int x = std::max(window.min.x, display.min.x); x <= std::min(window.max.x, display.max.x); ++x)
      image.at(x - display.min.x, y - display.min.y) = data.at(x - window.min.x, y - window.min.y);
  return image;
}

ImageRgb read_first_picture(std::span<const uint8_t> bytes, const std::string& name) {
  MemoryInput stream(bytes, name);
  Imf::MultiPartInputFile file(stream);
  for (int index = 0; index < file.parts(); ++index) {
    const Imf::Header& header = file.header(index);
    const auto color = is_flat(header) ? find_color(header.channels()) : std::nullopt;
    if (!color) continue;
    const Window window = header.dataWindow(), display = header.displayWindow();
    check_block(header, name);
    check_display(window, display, name);
    if (color->chroma) check_luminance_chroma(file, index, name);
    if (color->chroma) return to_display(read_luminance_chroma(stream, window), window, display, name);
    for (const std::string& channel : color->names) {
      const Imf::Channel& found = header.channels()[channel.c_str()];
      if (found.xSampling != 1 || found.ySampling != 1)
        throw input_error(name, fmt::format("channel {}", channel), "subsampled channels are not read");
    }
    return to_display(read_channels(file, index, *color), window, display, name);
  }
  throw input_error(name, "channels", "no flat part with R, G and B, or with Y");
}

}  // namespace

ImageRgb decode_exr(std::span<const uint8_t> bytes, const LoadLimits& limits, std::string_view file) {
  const std::string name(file);
  try {
    check_exr_header(bytes, limits, file);
    return read_first_picture(bytes, name);
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw input_error(name, "OpenEXR", "not enough memory for it");
  } catch (const std::exception& error) {
    std::string reason = error.what();
    std::replace(reason.begin(), reason.end(), '\n', ' ');  // its messages may span lines
    throw input_error(name, "OpenEXR", reason);
  }
}

}  // namespace halflight
