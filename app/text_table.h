// Rows of text in aligned columns, for people.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace halflight {

/// Names from files may hold anything, and control characters would drive the terminal: they become \xNN.
std::string terminal_safe(std::string_view text);

/// Each column as wide as its longest cell, two spaces between them; nothing after the last. Cells are UTF-8,
/// made `terminal_safe`.
std::string text_table(const std::vector<std::vector<std::string>>& rows, const std::string& indent = "");

/// 1234567 as "1,234,567".
std::string grouped(unsigned long long number);

/// "1 light", "2 lights", "1,234 lights".
std::string counted(unsigned long long number, const std::string& singular, const std::string& plural);

}  // namespace halflight
