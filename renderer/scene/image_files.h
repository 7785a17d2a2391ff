// Reading images from memory or disk. Sizes are read and checked against the limits before anything is allocated.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "core/errors.h"
#include "core/image.h"
#include "scene/load.h"

namespace halflight {

/// PNG, JPEG (8 bit) or WebP, by content. Throws Error (exit code 3) with `file` and `place` in the message.
ImageRgba8 decode_ldr(std::span<const uint8_t> bytes, const LoadLimits&, std::string_view file, std::string_view place);

/// Radiance RGBE or XYZE, old and new run lengths, flips, EXPOSURE divided out. Truncation is an error, never black.
ImageRgb decode_radiance(std::span<const uint8_t> bytes, const LoadLimits&, std::string_view file);

/// OpenEXR: the display window of the first flat part that has R G B (also as LAYER.R …), Y, or Y RY BY. Throws Error
/// (exit code 3).
ImageRgb decode_exr(std::span<const uint8_t> bytes, const LoadLimits&, std::string_view file);

/// .hdr, .exr or an 8-bit image (decoded to linear), by content.
ImageRgb read_image(const std::filesystem::path&, const LoadLimits&);

/// A whole file; throws Error (exit code 3) where it cannot be read or is larger than `limit`.
std::vector<uint8_t> read_file(const std::filesystem::path&, uint64_t limit);

}  // namespace halflight
