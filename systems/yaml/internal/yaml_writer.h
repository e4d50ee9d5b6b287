#pragma once

#include <string>

#include <tenon/systems/framework/internal/type_info.h>

namespace tenon::internal {

/// Block-style YAML, lists in flow style, numbers with the fewest digits that give them back exactly. Throws
/// ParameterError for what could not be read again.
std::string WriteYaml(const TypeInfo& type, const void* value);

}  // namespace tenon::internal
