#include "commands/json_output.h"

#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "console.h"
#include "core/errors.h"
#include "film/image_writers.h"

namespace halflight {

namespace {

Error cannot_write(const std::string& target, std::string_view reason) {
  return Error(ExitCode::failure, fmt::format("{}: cannot write: {}", target, reason));
}

/// A device or pipe is written to, never replaced by a file.
void write_through(const std::string& target, const std::string& text) {
  std::ofstream file(target, std::ios::binary);
  file << text;
  file.close();
  if (!file) throw cannot_write(target, std::strerror(errno));
}

}  // namespace

Json finite_or_null(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

void check_writable(const std::string& target) {
  if (target.empty() || target == "-") return;
  const std::filesystem::path path(target);
  const std::filesystem::path folder =
      path.has_parent_path() ? path.parent_path() : std::filesystem::path(".");
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored)) throw cannot_write(target, "it is a folder");
  if (!std::filesystem::exists(folder, ignored))
    throw cannot_write(target, fmt::format("there is no folder {}", folder.string()));
  if (!std::filesystem::is_directory(folder, ignored))
    throw cannot_write(target, fmt::format("{} is no folder", folder.string()));
  if (access(folder.c_str(), W_OK | X_OK) != 0 && !std::filesystem::is_other(path, ignored))
    throw cannot_write(target, std::strerror(errno));
}

void write_json(const std::string& target, const Json& json) {
  // Names from a file may be no UTF-8: replaced rather than refused.
  write_text(target, json.dump(2, ' ', false, Json::error_handler_t::replace) + '\n');
}

void write_text(const std::string& target, const std::string& text) {
  std::error_code ignored;
  if (target == "-")
    write_standard_output(text);
  else if (std::filesystem::exists(target, ignored) && !std::filesystem::is_regular_file(target, ignored))
    write_through(target, text);
  else
    write_text_atomically(target, text);
}

}  // namespace halflight
