// Arguments to options: picks the command, reads --config, then lets the command line win.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "options.h"

namespace halflight {

/// What the arguments (without the program's own name) ask for. Throws Error: exit code 2 for an unknown
/// command, option, name or value; 3 for a config file that cannot be read.
Options parse_arguments(const std::vector<std::string>& arguments);

/// Applies a config file: one JSON object, keys as in the option table without dashes, "scene", and "set" an
/// object of its own; files it names are relative to it. Options of other commands are allowed and passed
/// over. Throws Error (exit code 3) naming the file and the key.
void apply_config(Options&, const std::filesystem::path&);

}  // namespace halflight
