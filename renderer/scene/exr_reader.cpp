#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfPartType.h>

#include <algorithm>

#include "scene/image_files.h"

namespace halflight {

namespace {

/// The first part that is a flat image with colour or luminance; −1 where there is none.
int find_flat_part(const Imf::MultiPartInputFile& file) {
  for (int part = 0; part < file.parts(); ++part) {
    const Imf::Header& header = file.header(part);
    const bool flat =
        !header.hasType() || header.type() == Imf::SCANLINEIMAGE || header.type() == Imf::TILEDIMAGE;
    const Imf::ChannelList& channels = header.channels();
    if (flat && (channels.findChannel("R") || channels.findChannel("Y"))) return part;
  }
  return -1;
}

void check_size(const Imath::Box2i& window, const LoadLimits& limits, const std::string& name) {
  const int64_t width = int64_t{window.max.x} - window.min.x + 1,
                height = int64_t{window.max.y} - window.min.y + 1;
  if (width <= 0 || height <= 0)
    throw input_error(name, "dataWindow", fmt::format("{} x {} is no picture size", width, height));
  if (width > 1 << 24 || height > 1 << 24 || static_cast<uint64_t>(width * height) > limits.image_pixels)
    throw input_error(
        name, "dataWindow",
        fmt::format("{} x {} pixels exceed --limit-image-pixels {}", width, height, limits.image_pixels));
}

ImageRgb read_part(Imf::MultiPartInputFile& file, int index, const LoadLimits& limits,
                   const std::string& name) {
  const Imf::Header& header = file.header(index);
  const Imath::Box2i window = header.dataWindow();
  check_size(window, limits, name);
  const Imf::ChannelList& channels = header.channels();
  const bool color = channels.findChannel("R") != nullptr;
  for (const char* channel : {"R", "G", "B", "Y"}) {
    const Imf::Channel* found = channels.findChannel(channel);
    if (found && (found->xSampling != 1 || found->ySampling != 1))
      throw input_error(name, fmt::format("channel {}", channel), "subsampled channels are not read");
  }

  ImageRgb image(window.max.x - window.min.x + 1, window.max.y - window.min.y + 1);
  Imf::FrameBuffer buffer;
  static constexpr const char* names[] = {"R", "G", "B"};
  for (int c = 0; c < 3; ++c) {
    // A missing channel is filled with 0; luminance alone goes to all three.
    buffer.insert(color ? names[c] : "Y", Imf::Slice::Make(Imf::FLOAT, &image.pixels[0].x + c, window,
                                                           sizeof(Vec3), sizeof(Vec3) * image.width));
    if (!color) break;
  }
  Imf::InputPart part(file, index);
  part.setFrameBuffer(buffer);
  part.readPixels(window.min.y, window.max.y);
  if (!color)
    for (Vec3& pixel : image.pixels) pixel = Vec3(pixel.x);
  return image;
}

}  // namespace

ImageRgb read_exr(const std::filesystem::path& path, const LoadLimits& limits) {
  const std::string name = path.string();
  try {
    // A header's claim is checked by us before anything is allocated; the library's bound is a second net.
    const int longest_side = 1 << 24;
    Imf::Header::setMaxImageSize(longest_side, longest_side);
    Imf::MultiPartInputFile file(name.c_str());
    const int part = find_flat_part(file);
    if (part < 0) throw input_error(name, "", "no flat part with R, G, B or Y channels");
    return read_part(file, part, limits, name);
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    std::string reason = error.what();
    // The library's messages name the file again and may span lines.
    std::replace(reason.begin(), reason.end(), '\n', ' ');
    throw input_error(name, "OpenEXR", reason);
  }
}

}  // namespace halflight
