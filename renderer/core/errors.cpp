#include "core/errors.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <numeric>

namespace halflight {

Error input_error(std::string_view file, std::string_view place, std::string_view reason) {
  if (place.empty()) return Error(ExitCode::bad_input, fmt::format("{}: {}", file, reason));
  return Error(ExitCode::bad_input, fmt::format("{}: {}: {}", file, place, reason));
}

Error usage_error(std::string_view message) { return Error(ExitCode::usage, std::string(message)); }

Error unknown_name(std::string_view what, std::string_view name, const std::vector<std::string>& valid) {
  const auto nearest = std::min_element(valid.begin(), valid.end(), [&](const auto& a, const auto& b) {
    return edit_distance(name, a) < edit_distance(name, b);
  });
  std::string message = fmt::format("unknown {} '{}'", what, name);
  if (nearest != valid.end() && edit_distance(name, *nearest) <= std::max<size_t>(2, name.size() / 3))
    message += fmt::format("; did you mean '{}'?", *nearest);
  message += fmt::format(" (valid: {})", fmt::join(valid, ", "));
  return usage_error(message);
}

size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), size_t{0});
  for (size_t i = 0; i < a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i + 1;
    for (size_t j = 0; j < b.size(); ++j) {
      const size_t substitute = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({substitute, row[j] + 1, diagonal + 1});
    }
  }
  return row[b.size()];
}

std::string_view without_identifier(std::string_view what) {
  const size_t end = what.find("] ");
  return what.starts_with('[') && end != std::string_view::npos ? what.substr(end + 2) : what;
}

void Messages::placeholder(std::string_view file, std::string_view place, std::string_view reason) {
  const Error error = input_error(file, place, reason);
  if (strict) throw error;
  warn(error.what());
}

void check_failed(const char* condition, const char* file, int line) {
  std::fprintf(stderr, "halflight: internal error: %s (%s:%d)\n", condition, file, line);
  std::abort();
}

}  // namespace halflight
