#include <tenon/systems/live/internal/live_run.h>

#include <charconv>

namespace tenon::internal {
namespace {

constexpr std::size_t kMaxElements = 64;  // maximal number of elements of a shown Parameter

/// Appends a number in the shortest form that reads back in single (`exact`: double) precision; null if not
/// finite.
void AppendNumber(std::string& text, double value, bool exact) {
  if (!std::isfinite(value)) {
    text += "null";
    return;
  }
  char digits[32];
  char* const end = exact ? std::to_chars(digits, digits + sizeof(digits), value).ptr
                          : std::to_chars(digits, digits + sizeof(digits), static_cast<float>(value)).ptr;
  text.append(digits, end);
}

Json Point(const Vec<3>& p) {
  return {p[0], p[1], p[2]};
}

Json ControlsJson(const LiveControls& controls) {
  Json json = Json::object();
  if (const auto& drive = controls.drive)
    json["drive"] = {{"forward", drive->forward}, {"sideways", drive->sideways}, {"yaw", drive->yaw}};
  if (controls.gaits) json["gaits"] = controls.gaits->names;
  if (controls.postures) json["postures"] = controls.postures->names;
  if (const auto& goal = controls.goal)
    json["goal"] = {{"name", goal->name}, {"box", {Point(goal->box_W[0]), Point(goal->box_W[1])}}};
  if (const auto& pull = controls.pull) {
    Json bodies = Json::object();
    for (const auto& [shape, name] : pull->bodies) bodies[std::to_string(shape)] = name;
    json["pull"] = {
        {"stiffness_N_per_m", pull->stiffness}, {"max_N", pull->max_force}, {"bodies", std::move(bodies)}};
  }
  if (const auto& load = controls.load)
    json["load"] = {{"name", load->name}, {"mass_kg", load->mass}, {"start", load->start}};
  return json;
}

/// Infinities become null in the text.
Json RangeJson(const Range& range, const std::string& unit) {
  return {{"low", range.low()},
          {"high", range.high()},
          {"above", range.low_open()},
          {"below", range.high_open()},
          {"text", range.Text(unit)}};
}

Json ParameterJson(const ParameterSource& parameter, Context& context) {
  Json names = Json::array();
  std::string unit;
  const std::vector<Element> elements = context.Elements(parameter);
  const auto same = [&](const Element& element) { return element.unit == elements.front().unit; };
  const bool one_unit = std::ranges::all_of(elements, same);
  for (const Element& element : elements) {
    if (element.name.empty()) continue;
    names.push_back(one_unit || element.unit.empty() ? element.name
                                                     : element.name + " [" + element.unit + "]");
  }
  Json ranges = Json::array();
  for (const Range& range : parameter.ranges())
    ranges.push_back(RangeJson(range, elements[ranges.size()].unit));
  return {{"path", parameter.path()},     {"value", ParameterValue(parameter, context)},
          {"elements", std::move(names)}, {"unit", one_unit ? elements.front().unit : ""},
          {"ranges", std::move(ranges)},  {"meaning", parameter.description()}};
}

}  // namespace

std::string PageData(const LiveView& view, const std::string& token) {
  Json run{{"verdict", ""}, {"good", nullptr}, {"figures", Json::array()}, {"name", ""}};
  return Dump({{"format", kPageFormat},
               {"title", view.title},
               {"description", view.description},
               {"plots", PlotsJson(view.plots)},
               {"runs", Json::array({std::move(run)})},
               {"live", {{"token", token}}}});
}

std::vector<const ParameterSource*> Tunable(const Diagram& diagram) {
  std::vector<const ParameterSource*> tunable;
  for (const ParameterSource* parameter : diagram.parameters()) {
    const TypeInfo& type = parameter->type();
    const std::size_t size = parameter->initial_numbers().size();
    if (type.fixed && size > 0 && size <= kMaxElements) tunable.push_back(parameter);
  }
  return tunable;
}

Json ParameterValue(const ParameterSource& parameter, Context& context) {
  const std::vector<double> values = context.EvalDoubles(parameter);
  return parameter.type().kind == TypeInfo::Kind::kNumber ? Json(values.front()) : Json(values);
}

Json Hello(const LiveView& view, const Geometry& shapes, Context& context,
           const std::vector<const ParameterSource*>& parameters, double history) {
  Json bands = Json::array(), tunable = Json::array();
  for (const Band& band : view.bands)
    bands.push_back({{"signal", band.signal}, {"names", band.names}, {"intervals", Json::array()}});
  for (const ParameterSource* parameter : parameters) tunable.push_back(ParameterJson(*parameter, context));
  return {{"run",
           {{"name", ""},
            {"shapes", ShapesJson(shapes)},
            {"bands", std::move(bands)},
            {"limits", LimitsJson(view.limits)},
            {"plots", PlotsJson(view.plots)},
            {"figures", Json::array()}}},
          {"description", view.description},
          {"controls", ControlsJson(view.controls)},
          {"parameters", std::move(tunable)},
          {"history_s", history}};
}

Json TimesJson(const TimeQuantiles& times) {
  Json below = Json::array();
  for (const int limit : times.kLimits) below.push_back({limit, times.Below(1e-6 * limit)});
  const auto quantile = [&](double share) { return 1e6 * times.Quantile(share).value_or(0); };
  return {{"below_us", below}, {"count", times.count()}, {"quantiles_us", {quantile(0.5), quantile(0.99)}}};
}

void LiveRows::Begin(const std::vector<std::string>& names, const std::vector<std::string>& units) {
  names_ = names;
  units_ = units;
}

void LiveRows::Row(std::span<const double> row) {
  if (!muted) data_.insert(data_.end(), row.begin(), row.end());
}

std::string LiveRows::Take(const char* key, bool constants) {
  const std::size_t columns = names_.size(), rows = columns == 0 ? 0 : data_.size() / columns;
  std::string text;
  text.reserve(data_.size() * 8 + 64);
  const auto append_column = [&](std::size_t column) {
    text += '[';
    for (std::size_t row = 0; row < rows; ++row) {
      if (row > 0) text += ',';
      AppendNumber(text, data_[row * columns + column], column == 0);
    }
    text += ']';
  };
  text += "\"time\":";
  append_column(0);
  text += std::string(",\"") + key + "\":[";
  for (std::size_t column = 1; column < columns; ++column) {
    if (column > 1) text += ',';
    bool same = constants;
    for (std::size_t row = 1; same && row < rows; ++row)
      same = data_[row * columns + column] == data_[column];
    if (same) {
      AppendNumber(text, data_[column], false);
    } else {
      append_column(column);
    }
  }
  text += ']';
  data_.clear();
  return text;
}

}  // namespace tenon::internal
