#pragma once

#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace tenon::internal {

/// Returns a user's text for use in a message: at most 80 characters and an ellipsis, with control characters
/// escaped as `\n` or `\x1b` and bytes that are not UTF-8 as `\xff`.
std::string Excerpt(std::string_view text);

/// Returns a message that is safe to print: at most 4000 characters, with control characters except line ends
/// escaped as `\x1b` and bytes that are not UTF-8 as `\xff`.
std::string Printable(std::string_view message);

/// Calls `take` with each part of a text between separators. A text without separators is one part.
void Split(std::string_view text, char separator, const auto& take) {
  for (std::size_t end; (end = text.find(separator)) != text.npos; text.remove_prefix(end + 1))
    take(text.substr(0, end));
  take(text);
}

/// Removes blanks, tabs and line ends at both ends.
inline std::string_view Trimmed(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\r\n";
  const std::size_t begin = text.find_first_not_of(kBlanks);
  return begin == text.npos ? "" : text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

/// Returns the name with the smallest edit distance to `wanted`, for "did you mean"; empty without names.
std::string NearestName(std::string_view wanted, const std::vector<std::string>& names);

/// Splits a key into its stem and its unit: `inertia_kg_m2` into "inertia" and "kg_m2".
std::pair<std::string_view, std::string_view> SplitUnit(std::string_view key);

/// Returns the unit of a key in the usual notation, such as "kg m^2" for inertia_kg_m2; empty without unit.
std::string UnitOfKey(std::string_view key);

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
