#pragma once

#include <string>
#include <string_view>

namespace tenon::internal {

/// What a message repeats of a text that somebody gave: at most 80 characters, then an ellipsis; control
/// characters as \n or \x1b, so that they reach no terminal. Takes UTF-8 and cuts between its characters.
std::string Excerpt(std::string_view text);

}  // namespace tenon::internal
