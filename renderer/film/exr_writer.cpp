#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>

#include "core/errors.h"
#include "film/image_writers.h"

namespace halflight {

namespace {

Imf::Header make_header(const ImageRgb& image, const ImageMetadata& metadata) {
  Imf::Header header(image.width, image.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const auto& [key, value] : metadata.text) header.insert(key, Imf::StringAttribute(value));
  for (const auto& [key, value] : metadata.numbers) header.insert(key, Imf::DoubleAttribute(value));
  for (const auto& [key, value] : metadata.matrices) {
    Imath::M44f matrix;
    // EXR multiplies row vectors from the left: the transpose of ours, which column-major storage already is.
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) matrix[i][j] = value[i][j];
    header.insert(key, Imf::M44fAttribute(matrix));
  }
  return header;
}

/// One float channel of interleaved storage; EXR only reads through the pointer.
void insert_channel(Imf::Header& header, Imf::FrameBuffer& buffer, const std::string& name,
                    const float* first, size_t channels, int width) {
  header.channels().insert(name, Imf::Channel(Imf::FLOAT));
  const size_t step = channels * sizeof(float);
  buffer.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(const_cast<float*>(first)), step,
                                 step * static_cast<size_t>(width)));
}

}  // namespace

void write_exr(const std::filesystem::path& path, const ImageRgb& image, const ImageMetadata& metadata) {
  Imf::Header header = make_header(image, metadata);
  Imf::FrameBuffer buffer;
  static constexpr const char* names[] = {"R", "G", "B"};
  for (size_t c = 0; c < 3; ++c)
    insert_channel(header, buffer, names[c], &image.pixels[0].x + c, 3, image.width);
  for (const ImageLayer& layer : metadata.layers) {
    HALFLIGHT_CHECK(layer.values.size() == layer.channels.size() * image.pixels.size());
    for (size_t c = 0; c < layer.channels.size(); ++c)
      insert_channel(header, buffer, layer.name + "." + layer.channels[c], layer.values.data() + c,
                     layer.channels.size(), image.width);
  }
  write_atomically(path, [&](const std::filesystem::path& target) {
    Imf::OutputFile file(target.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(image.height);
  });
}

}  // namespace halflight
