// What the user reads: results on standard output, messages on standard error.
#pragma once

#include <string>
#include <string_view>

#include "core/errors.h"

namespace halflight {

/// `halflight: text` on standard error; coloured on a terminal unless NO_COLOR is set.
void print_error(std::string_view text);
void print_warning(std::string_view text);
void print_note(std::string_view text);

/// Whether standard error is a terminal that understands cursor movement.
bool terminal_shows_progress();

/// Writes results to standard output at once. A reader that has gone away is no error. Throws Error (exit
/// code 1) when the output cannot be written, such as on a full disk.
void write_standard_output(const std::string& text);

/// Prints warnings as they come in, each once.
class WarningPrinter {
 public:
  explicit WarningPrinter(bool quiet) : quiet_(quiet) {}
  void print_new(const Messages&);

 private:
  bool quiet_;
  size_t printed_ = 0;
};

}  // namespace halflight
