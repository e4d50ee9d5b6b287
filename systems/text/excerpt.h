#pragma once

#include <string>
#include <string_view>

namespace tenon::internal {

/// What a message repeats of a text that somebody gave: at most 80 characters, then an ellipsis; control
/// characters as \n or \x1b, so that they reach no terminal, and bytes that are not UTF-8 as \xff. Cuts
/// between characters.
std::string Excerpt(std::string_view text);

/// A message as it may reach a terminal: its control characters, but for the ends of lines, as \x1b, and
/// bytes that are not UTF-8 as \xff; at most 4000 characters.
std::string Printable(std::string_view message);

}  // namespace tenon::internal
