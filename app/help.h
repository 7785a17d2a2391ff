// What `--help` and `--completions` print, made of the option table.
#pragma once

#include <string>
#include <string_view>

#include "options.h"

namespace halflight {

/// The commands, one line each, and where to read on.
std::string overview_text();

/// A command's operands and options in groups, in 100 columns.
std::string help_text(Command);

/// A completion script. Throws Error (exit code 2) for a shell other than bash, zsh or fish.
std::string completion_script(const std::string& shell);

}  // namespace halflight
