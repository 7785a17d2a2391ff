// `--json FILE|-`: one object, written whole or not at all.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace halflight {

using Json = nlohmann::ordered_json;

/// The number, or null where JSON has no word for it.
Json finite_or_null(double value);

/// Throws Error (exit code 1) when nothing could be written at `target` later: no such folder, a folder
/// itself, no permission. Work that takes minutes asks first. An empty target and "-" are fine.
void check_writable(const std::string& target);

/// Writes to the file, or to standard output for "-". Throws Error (exit code 1).
void write_json(const std::string& target, const Json&);
void write_text(const std::string& target, const std::string& text);

}  // namespace halflight
