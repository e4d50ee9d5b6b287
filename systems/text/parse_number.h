#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

namespace tenon::internal {

/// All of a text as a number, as std::from_chars reads it: in no locale, without blanks or a '+' before it.
/// Returns errc() if that it is; result_out_of_range; invalid_argument for any other text.
template <class Number>
std::errc ParseNumber(std::string_view text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return end == text.data() + text.size() ? error : std::errc::invalid_argument;
}

/// A text without the sign of a positive number, which YAML and XML have and C++ has not.
inline std::string_view WithoutPlus(std::string_view text) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  return text;
}

/// The same as ParseNumber; nothing if it is none.
template <class Number>
std::optional<Number> NumberIn(std::string_view text) {
  Number value{};
  if (ParseNumber(text, value) != std::errc()) return {};
  return value;
}

}  // namespace tenon::internal
