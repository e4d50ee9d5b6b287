#pragma once

#include <expat.h>

#include <cstddef>

namespace tenon::internal {

/// Returns the line that `parser` has reached. Expat 2.9 deprecates the function of older versions.
inline std::size_t LineOf(XML_Parser parser) {
#if XML_MAJOR_VERSION > 2 || (XML_MAJOR_VERSION == 2 && XML_MINOR_VERSION >= 9)
  return static_cast<std::size_t>(XML_GetCurrentLineNumber64(parser));
#else
  return static_cast<std::size_t>(XML_GetCurrentLineNumber(parser));
#endif
}

}  // namespace tenon::internal
