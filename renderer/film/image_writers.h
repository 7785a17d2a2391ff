// Writing pictures whole or not at all: a temporary name beside the target, close checked, then renamed.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "core/image.h"
#include "core/math.h"

namespace halflight {

/// A named three- or one-channel layer of an EXR, e.g. "Albedo".
struct ImageLayer {
  std::string name;                   ///< channels are NAME.R, NAME.G, NAME.B (NAME.X … for vectors)
  std::vector<std::string> channels;  ///< e.g. {"R", "G", "B"} or {"X", "Y", "Z"}
  std::vector<float> values;          ///< channels interleaved, row-major
};

/// What goes with the picture into the file.
struct ImageMetadata {
  std::map<std::string, std::string> text;
  std::map<std::string, double> numbers;
  std::map<std::string, Mat4> matrices;  ///< worldToCamera, worldToNDC
  std::vector<ImageLayer> layers;        ///< EXR only
};

/// Chooses the format by the ending: .exr and .hdr hold radiance, .png the display image of (ev, tonemap).
/// Throws Error (exit code 2: unknown ending; 1: cannot write).
struct DisplaySettings {
  float ev = 0;
  std::string tonemap = "linear";
};
void write_image(const std::filesystem::path&, const ImageRgb&, const DisplaySettings&, const ImageMetadata&);

void write_exr(const std::filesystem::path&, const ImageRgb&, const ImageMetadata&);
void write_radiance(const std::filesystem::path&, const ImageRgb&, const ImageMetadata&);
void write_png(const std::filesystem::path&, const ImageRgba8&, const ImageMetadata&);
/// The file `write_png` would write.
std::string png_bytes(const ImageRgba8&, const ImageMetadata&);

/// The files `write_exr` and `write_radiance` would write.
std::string exr_bytes(const ImageRgb&, const ImageMetadata&);
std::string radiance_bytes(const ImageRgb&, const ImageMetadata&);

/// Writes a temporary file beside `path`, then renames it; nothing is left behind on failure. The file behind
/// a link is replaced, not the link; a device or a pipe is written straight into. Throws Error (exit code 1)
/// with the system's reason.
void write_bytes_atomically(const std::filesystem::path&, std::string_view bytes);
void write_text_atomically(const std::filesystem::path&, const std::string&);

}  // namespace halflight
