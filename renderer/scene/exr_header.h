// The header of an OpenEXR file, walked before the library sees it.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "scene/load.h"

namespace halflight {

/// Throws Error (exit code 3) where an attribute claims more bytes than there are, or a window more pixels
/// than the limits allow: the library allocates both before it reads them.
void check_exr_header(std::span<const uint8_t> bytes, const LoadLimits&, std::string_view file);

}  // namespace halflight
