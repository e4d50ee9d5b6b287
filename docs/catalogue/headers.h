#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace tenon::docs {

/// A declaration in a public header.
struct Declaration {
  std::string header;     ///< path in the source tree: "systems/primitives/gain.h"
  std::string summary;    ///< the first sentence of its docstring
  bool is_block = false;  ///< derives from LeafSystem or Subdiagram
};

/// The classes, structures, enumerations and type aliases that the public headers below `source` declare in
/// namespaces, by name.
std::map<std::string, Declaration> ReadHeaders(const std::filesystem::path& source);

std::vector<std::string> ReadLines(const std::filesystem::path& file);

}  // namespace tenon::docs
