#pragma once

#include <tenon/systems/report/internal/run_log.h>

#include <nlohmann/json.hpp>

namespace tenon::internal {

/// Converts a value to JSON, null if it is empty.
template <class T>
nlohmann::ordered_json JsonOrNull(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

/// Converts limits to [low, high], with null for a missing bound.
inline nlohmann::ordered_json LimitsJson(const Limits& limits) {
  return {JsonOrNull(limits.low), JsonOrNull(limits.high)};
}

/// Converts the constant properties of shapes to the format that the scripts of the pages read.
inline nlohmann::ordered_json ShapesJson(const Geometry& shapes) {
  auto list = nlohmann::ordered_json::array();
  for (const Shape& shape : shapes) {
    auto& item =
        list.emplace_back(nlohmann::ordered_json{{"kind", EnumName(shape.kind)},
                                                 {"role", EnumName(shape.role)},
                                                 {"name", shape.name},
                                                 {"size", {shape.size[0], shape.size[1], shape.size[2]}},
                                                 {"scale", shape.scale},
                                                 {"unit", shape.unit}});
    if (shape.mesh == nullptr) continue;
    item["corners"] = Base64(shape.mesh->corners);
    item["triangles"] = Base64(shape.mesh->triangles);
    if (!shape.mesh->colours.empty()) item["colours"] = Base64(shape.mesh->colours);
  }
  return list;
}

}  // namespace tenon::internal
