// Exit codes, the exception that carries one, checks for our own bugs, and the sink for warnings.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace halflight {

/// What the program returns to its caller; part of its interface.
enum class ExitCode : int {
  ok = 0,
  failure = 1,            ///< something failed at run time
  usage = 2,              ///< an unknown option, name or value
  bad_input = 3,          ///< a file that cannot be read as what it claims to be
  no_gl = 4,              ///< an OpenGL back end was asked for and none could be made
  comparison_failed = 5,  ///< a comparison the user asked for fell short
  interrupted = 130,
};

/// A failure with a message for the user (one line, no trailing full stop) and the exit code it leads to.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

/// A bad file: `file: place: reason`, exit code 3. `place` may be empty.
Error input_error(std::string_view file, std::string_view place, std::string_view reason);

/// A bad option or name, exit code 2.
Error usage_error(std::string_view message);

/// Error for an unknown name: lists the valid ones and suggests the nearest (exit code 2).
Error unknown_name(std::string_view what, std::string_view name, const std::vector<std::string>& valid);

/// What a JSON library's exception says, without its identifier in brackets ("[json.exception.…] ").
std::string_view without_identifier(std::string_view what);

/// Edit distance with insertions, deletions and substitutions at cost one.
size_t edit_distance(std::string_view a, std::string_view b);

/// Warnings gathered while loading or rendering, in order; the app prints them, the window shows them.
struct Messages {
  std::vector<std::string> warnings;
  bool strict = false;  ///< a warning that names something unusable becomes an error (`--strict`)

  void warn(std::string text) { warnings.push_back(std::move(text)); }

  /// Something unusable that a placeholder can stand in for: a warning, or under `strict` an error.
  void placeholder(std::string_view file, std::string_view place, std::string_view reason);
};

[[noreturn]] void check_failed(const char* condition, const char* file, int line);

/// For our own bugs, in release builds too; never for user input.
#define HALFLIGHT_CHECK(condition) \
  ((condition) ? void() : ::halflight::check_failed(#condition, __FILE__, __LINE__))

}  // namespace halflight
