#pragma once

#include <string_view>

namespace halflight {

/// Text of a file of shaders/ by its name; empty for an unknown one.
std::string_view shader_source(std::string_view name);

}  // namespace halflight
