// Text to value, for options: strict, whole-string, with the reason of a refusal as the message.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace halflight {

/// A finite number in [low, high]. Throws Error (exit code 2) for text that is no number, NaN, infinity or
/// out of bounds.
double parse_number(std::string_view text, double low, double high);

/// A whole number in [low, high], decimal. Throws Error (exit code 2).
uint64_t parse_integer(std::string_view text, uint64_t low, uint64_t high);

/// A whole number with an optional K, M or G (powers of 1024). Throws Error (exit code 2).
uint64_t parse_amount(std::string_view text, uint64_t low, uint64_t high);

/// "WxH", each side in [1, 16384]. Throws Error (exit code 2).
std::pair<int, int> parse_size(std::string_view text);

/// "true" or "false". Throws Error (exit code 2).
bool parse_switch(std::string_view text);

/// "NAME=VALUE" in two. Throws Error (exit code 2) when there is no '=' or no name.
std::pair<std::string, std::string> parse_assignment(std::string_view text);

/// "A,B,C" in its parts, at least one. Throws Error (exit code 2) where a part is empty.
std::vector<std::string> parse_list(std::string_view text);

/// Index of `text` among `names`. Throws Error (exit code 2) that lists them and suggests the nearest.
size_t parse_choice(std::string_view text, const std::vector<std::string>& names);

}  // namespace halflight
