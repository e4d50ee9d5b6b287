#pragma once

#include <string>
#include <string_view>

namespace tenon::internal {

/// Returns a user's text for use in a message: at most 80 characters and an ellipsis, with control characters
/// escaped as `\n` or `\x1b` and bytes that are not UTF-8 as `\xff`.
std::string Excerpt(std::string_view text);

/// Returns a message that is safe to print: at most 4000 characters, with control characters except line ends
/// escaped as `\x1b` and bytes that are not UTF-8 as `\xff`.
std::string Printable(std::string_view message);

}  // namespace tenon::internal
