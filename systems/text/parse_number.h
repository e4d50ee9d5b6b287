#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

namespace tenon::internal {

/// Parses a whole text as a number by std::from_chars, which ignores the locale and accepts neither blanks
/// nor a leading '+'. Returns errc(), result_out_of_range, or invalid_argument if the text is not a number.
template <class Number>
std::errc ParseNumber(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return end == text.data() + text.size() ? error : std::errc::invalid_argument;
}

/// Removes a leading '+', which YAML and XML allow in numbers but std::from_chars does not.
inline std::string_view WithoutPlus(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  return text;
}

/// Parses a whole text as ParseNumber does; empty if it is not a number.
template <class Number>
std::optional<Number> NumberIn(std::string_view text) {
  Number value{};
  if (ParseNumber(text, value) != std::errc()) return {};
  return value;
}

}  // namespace tenon::internal
