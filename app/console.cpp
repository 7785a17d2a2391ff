#include "console.h"

#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "text_table.h"

namespace halflight {

namespace {

bool on_terminal() {
  const char* terminal = std::getenv("TERM");
  return isatty(STDERR_FILENO) && !(terminal && std::strcmp(terminal, "dumb") == 0);
}

/// https://no-color.org: set and not empty.
bool colour() {
  const char* no_colour = std::getenv("NO_COLOR");
  return on_terminal() && !(no_colour && *no_colour);
}

void print(std::string_view ansi, std::string_view kind, std::string_view text) {
  const bool coloured = colour() && !kind.empty();
  const std::string line = fmt::format("halflight: {}{}{}{}\n", coloured ? ansi : "", kind,
                                       coloured ? "\x1b[0m" : "", terminal_safe(text));
  std::fwrite(line.data(), 1, line.size(), stderr);
}

}  // namespace

void print_error(std::string_view text) { print("\x1b[1;31m", "", text); }
void print_warning(std::string_view text) { print("\x1b[1;33m", "warning: ", text); }
void print_note(std::string_view text) { print("", "", text); }

bool terminal_shows_progress() { return on_terminal(); }

void write_standard_output(const std::string& text) {
  const bool whole =
      std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
  if (!whole && errno != EPIPE)
    throw Error(ExitCode::failure, fmt::format("cannot write to standard output: {}", std::strerror(errno)));
}

void WarningPrinter::print_new(const Messages& messages) {
  for (; printed_ < messages.warnings.size(); ++printed_)
    if (!quiet_) print_warning(messages.warnings[printed_]);
}

}  // namespace halflight
