#pragma once

#include <string_view>

namespace halflight {

/// Text of the page's template, style or script by its name in this folder; empty for an unknown one.
std::string_view report_source(std::string_view name);

}  // namespace halflight
