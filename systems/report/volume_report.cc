#include <tenon/systems/report/internal/report_json.h>
#include <tenon/systems/report/volume_report.h>

#include <fmt/core.h>

namespace tenon {
namespace {

using internal::Base64;
using Json = nlohmann::ordered_json;

/// Returns a replay of a single frame with static shapes.
Json FramesJson(const Geometry& shapes) {
  std::vector<float> first;
  for (const Shape& shape : shapes) {
    for (int k = 0; k < 3; ++k) first.push_back(static_cast<float>(shape.p_W[k]));
    for (int k = 0; k < 4; ++k) first.push_back(static_cast<float>(shape.q_W[k]));
    for (int k = 0; k < 3; ++k) first.push_back(static_cast<float>(shape.vector_W[k]));
    first.push_back(static_cast<float>(shape.value));
    first.push_back(shape.visible ? 1 : 0);
  }
  return {{"shapes", internal::ShapesJson(shapes)},
          {"time", Base64(std::vector<double>{0})},
          {"first", Base64(first)},
          {"moving", Json::array()},
          {"data", Base64(std::vector<float>{})}};
}

Json MapJson(const VolumeReport::Map& map) {
  std::vector<float> rows;
  for (const VolumeReport::Part& part : map.parts) {
    if (part.values.size() != map.quantities.size()) {
      throw ParameterError(fmt::format("map '{}': a part has {} values for {} quantities", map.title,
                                       part.values.size(), map.quantities.size()));
    }
    for (const int index : part.first) rows.push_back(static_cast<float>(index));
    for (const int count : part.size) rows.push_back(static_cast<float>(count));
    rows.push_back(static_cast<float>(part.state));
    for (const double value : part.values) rows.push_back(static_cast<float>(value));
  }
  return {{"title", map.title},
          {"coordinates", map.coordinates},
          {"low", {map.low[0], map.low[1], map.low[2]}},
          {"high", {map.high[0], map.high[1], map.high[2]}},
          {"cells", map.cells},
          {"quantities", map.quantities},
          {"parts", Base64(rows)},
          {"frames", FramesJson(map.shapes)}};
}

}  // namespace

void VolumeReport::Write(const std::filesystem::path& file) const {
  Json data{
      {"title", title}, {"description", description}, {"figures", Json::array()}, {"maps", Json::array()}};
  for (const auto& [name, value] : figures) data["figures"].push_back({name, internal::JsonOrNull(value)});
  for (const Map& map : maps) data["maps"].push_back(MapJson(map));
  internal::WritePage(file, title, internal::Dump(data), internal::PageKind::kVolume);
}

}  // namespace tenon
