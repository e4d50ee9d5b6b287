#pragma once

#include <tenon/systems/framework/types/errors.h>

#include <expat.h>
#include <fmt/format.h>

#include <cstddef>
#include <string_view>
#include <vector>

namespace tenon::internal {

/// Returns the line that `parser` has reached. Expat 2.9 deprecates the function of older versions.
inline std::size_t LineOf(XML_Parser parser) {
#if XML_MAJOR_VERSION > 2 || (XML_MAJOR_VERSION == 2 && XML_MINOR_VERSION >= 9)
  return static_cast<std::size_t>(XML_GetCurrentLineNumber64(parser));
#else
  return static_cast<std::size_t>(XML_GetCurrentLineNumber(parser));
#endif
}

/// An element of an XML file.
struct Element {
  std::string name;
  std::size_t line;
  std::vector<std::pair<std::string, std::string>> attributes{};
  std::vector<Element> children{};

  /// The value of an attribute, empty without one.
  const std::string& operator[](std::string_view attribute) const;
  /// The first child of this name; null if there is none.
  const Element* Child(std::string_view child) const;
};

/// Throws ParameterError with a place.
template <class... Args>
[[noreturn]] void FailAt(const std::string& file, std::size_t line, fmt::format_string<Args...> format,
                         Args&&... args) {
  throw ParameterError(
      fmt::format("{}:{}: {}", file, line, fmt::format(format, std::forward<Args>(args)...)));
}

/// Parses a URDF into its elements. Elements of the robot other than links, joints and materials, which
/// extend a URDF for other programs, have no attributes and children. Throws ParameterError for other
/// formats, and for files that are deeper or larger than any robot's.
Element ParseXml(const std::string& text, const std::string& file);

}  // namespace tenon::internal
