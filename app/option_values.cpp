#include "option_values.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/errors.h"

namespace halflight {

namespace {

std::string_view without_plus(std::string_view text) {
  return text.size() > 1 && text.front() == '+' && text[1] != '-' ? text.substr(1) : text;
}

}  // namespace

double parse_number(std::string_view text, double low, double high) {
  const std::string_view digits = without_plus(text);
  double value = 0;
  const auto [end, fault] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  if (fault == std::errc::result_out_of_range && end == digits.data() + digits.size())
    throw usage_error(fmt::format("'{}' is out of range (valid: {} to {})", text, low, high));
  if (fault != std::errc() || end != digits.data() + digits.size())
    throw usage_error(fmt::format("expects a number, not '{}'", text));
  if (!std::isfinite(value)) throw usage_error(fmt::format("expects a finite number, not '{}'", text));
  if (value < low || value > high)
    throw usage_error(fmt::format("{} is out of range (valid: {} to {})", text, low, high));
  return value;
}

uint64_t parse_integer(std::string_view text, uint64_t low, uint64_t high) {
  const std::string_view digits = without_plus(text);
  uint64_t value = 0;
  const auto [end, fault] = std::from_chars(digits.data(), digits.data() + digits.size(), value);
  const bool whole = end == digits.data() + digits.size() && !digits.empty();
  const bool negative = digits.size() > 1 && digits.front() == '-' &&
                        digits.find_first_not_of("0123456789", 1) == std::string_view::npos;
  if (negative || (whole && fault == std::errc::result_out_of_range) ||
      (whole && fault == std::errc() && (value < low || value > high)))
    throw usage_error(fmt::format("{} is out of range (valid: {} to {})", text, low, high));
  if (!whole || fault != std::errc())
    throw usage_error(fmt::format("expects a whole number, not '{}'", text));
  return value;
}

uint64_t parse_amount(std::string_view text, uint64_t low, uint64_t high) {
  const size_t unit = text.empty() ? std::string_view::npos : std::string_view("KMG").find(text.back());
  if (unit == std::string_view::npos) return parse_integer(text, low, high);
  const uint64_t factor = uint64_t{1} << (10 * (unit + 1));
  return parse_integer(text.substr(0, text.size() - 1), (low + factor - 1) / factor, high / factor) * factor;
}

std::pair<int, int> parse_size(std::string_view text) {
  constexpr uint64_t largest = 16384;
  const size_t cross = text.find_first_of("xX");
  if (cross == std::string_view::npos || text.find_first_not_of("0123456789xX") != std::string_view::npos)
    throw usage_error(fmt::format("expects WIDTHxHEIGHT such as 640x480, not '{}'", text));
  try {
    return {static_cast<int>(parse_integer(text.substr(0, cross), 1, largest)),
            static_cast<int>(parse_integer(text.substr(cross + 1), 1, largest))};
  } catch (const Error&) {
    throw usage_error(fmt::format("expects WIDTHxHEIGHT from 1x1 to {0}x{0}, not '{1}'", largest, text));
  }
}

bool parse_switch(std::string_view text) {
  if (text != "true" && text != "false")
    throw usage_error(fmt::format("expects true or false, not '{}'", text));
  return text == "true";
}

std::pair<std::string, std::string> parse_assignment(std::string_view text) {
  const size_t equals = text.find('=');
  if (equals == std::string_view::npos || equals == 0)
    throw usage_error(fmt::format("expects NAME=VALUE, not '{}'", text));
  return {std::string(text.substr(0, equals)), std::string(text.substr(equals + 1))};
}

std::vector<std::string> parse_list(std::string_view text) {
  std::vector<std::string> parts;
  while (true) {
    const size_t comma = std::min(text.find(','), text.size());
    if (comma == 0) throw usage_error("expects values with commas between them, none empty");
    parts.emplace_back(text.substr(0, comma));
    if (comma == text.size()) return parts;
    text.remove_prefix(comma + 1);
  }
}

size_t parse_choice(std::string_view text, const std::vector<std::string>& names) {
  for (size_t i = 0; i < names.size(); ++i)
    if (names[i] == text) return i;
  throw unknown_name("value", text, names);
}

}  // namespace halflight
