#pragma once

#include <tenon/systems/framework/types/internal/type_info.h>

namespace tenon::internal {

/// Writes block-style YAML with lists in flow style and the shortest numbers that read back exactly. Throws
/// ParameterError for a value that could not be read back.
std::string WriteYaml(const TypeInfo& type, const void* value);
/// Writes a text as a scalar, quoted unless every YAML reader takes it for this text.
std::string YamlScalar(const std::string& text);

}  // namespace tenon::internal
