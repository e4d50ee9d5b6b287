#pragma once

#include <tenon/systems/report/internal/run_log.h>

#include <nlohmann/json.hpp>

namespace tenon::internal {

/// Writes JSON as text; replaces bytes that are not UTF-8.
inline std::string Dump(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

/// Converts a value to JSON, null if it is empty.
template <class T>
nlohmann::ordered_json JsonOrNull(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

/// Converts limits to [low, high], with null for a missing bound.
inline nlohmann::ordered_json LimitsJson(const Limits& limits) {
  return {JsonOrNull(limits.low), JsonOrNull(limits.high)};
}

inline nlohmann::ordered_json LimitsJson(const std::vector<SignalLimits>& limits) {
  auto list = nlohmann::ordered_json::array();
  for (const auto& [signal, range] : limits)
    list.push_back({{"signal", signal}, {"limits", LimitsJson(range)}});
  return list;
}

inline nlohmann::ordered_json PlotsJson(const std::vector<Plot>& plots) {
  auto list = nlohmann::ordered_json::array();
  for (const Plot& plot : plots)
    list.push_back({{"title", plot.title},
                    {"group", plot.group},
                    {"signals", plot.signals},
                    {"references", plot.references}});
  return list;
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

/// Throws RunError with the Debian package to install if three.js or Dygraphs is missing.
void CheckPageParts();

/// Version of the data in a page of runs; it changes whenever Report::Read cannot read earlier pages.
inline constexpr int kPageFormat = 2;

/// Returns the JSON data of a page. Throws std::out_of_range if there are none.
std::string_view DataOf(std::string_view page);

enum class PageKind { kRun, kCampaign, kVolume };

/// Returns the page: the template with style, libraries, data and scripts inserted. Throws RunError.
std::string MakePage(const std::string& title, std::string data_json, PageKind kind = PageKind::kRun);

/// Writes the page. Throws RunError and OutputError.
void WritePage(const std::filesystem::path& file, const std::string& title, std::string data_json,
               PageKind kind = PageKind::kRun);

}  // namespace tenon::internal

namespace tenon {

/// The data of one run and their conversion to a page. Reports that show the run share this object.
struct Report::Run {
  using Json = nlohmann::ordered_json;
  struct Figure {
    std::string name;
    Json value;
    Limits limits{};
  };

  std::vector<std::string> event_signals;
  std::vector<Band> bands;
  std::vector<SignalLimits> limits;
  std::shared_ptr<internal::ColumnLog> signals, frames;
  std::shared_ptr<Geometry> shapes = std::make_shared<Geometry>();
  std::vector<Figure> figures;
  std::vector<std::pair<double, std::string>> events;
  std::optional<bool> good;
  std::string verdict;

  /// Makes one plot for adjacent columns with the same unit, titled by the common beginning of their names.
  std::vector<Plot> DefaultPlots() const;
  /// Converts the run to the data of a page with `num_runs` runs. Signals in `plots` have a finer resolution.
  Json ToJson(const std::vector<Plot>& plots, std::size_t num_runs) const;
  /// Returns an upper estimate of the size of these data [bytes].
  std::size_t JsonBytes() const;
  /// Reads the data of ToJson, without the signals.
  static Run FromJson(const Json& json);

 private:
  Json Samples(const std::vector<Plot>& plots, std::size_t num_runs) const;
  Json Frames(std::size_t max_bytes) const;
  Json Events() const;
};

}  // namespace tenon
