#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace tenon::docs {

/// Something that a public header declares.
struct Declaration {
  std::string header;     ///< from the top of the source tree: "systems/primitives/gain.h"
  std::string summary;    ///< the first sentence of its docstring
  bool is_block = false;  ///< derives from LeafSystem or Subdiagram
};

/// What the public headers below `source` declare at the top level of a namespace: classes, structures,
/// enumerations and names of types.
std::map<std::string, Declaration> ReadHeaders(const std::filesystem::path& source);

std::vector<std::string> ReadLines(const std::filesystem::path& file);

}  // namespace tenon::docs
