#pragma once

#include <tenon/systems/geometry.h>
#include <tenon/systems/report/internal/run_log.h>

#include <nlohmann/json.hpp>

namespace tenon::internal {

/// What stays the same of shapes, as the scripts of the pages read it.
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
  }
  return list;
}

}  // namespace tenon::internal
