#pragma once

#include <tenon/systems/framework/types/internal/type_info.h>

#include <string>

namespace tenon::internal {

/// Block-style YAML, lists in flow style, numbers with the fewest digits that give them back exactly. Throws
/// ParameterError for what could not be read again.
std::string WriteYaml(const TypeInfo& type, const void* value);
/// A text as a scalar of any style, quoted unless all readers take it for just that text.
std::string YamlScalar(const std::string& text);

}  // namespace tenon::internal
