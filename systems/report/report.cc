#include <tenon/systems/report/report.h>

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include <tenon/systems/framework/fields.h>
#include <tenon/systems/framework/internal/nearest_name.h>
#include <tenon/systems/report/internal/page.h>
#include <tenon/systems/report/internal/run_log.h>

namespace tenon {

namespace {

using internal::Base64;
using internal::ColumnLog;
using internal::FindColumns;
using Json = nlohmann::ordered_json;

// What one page holds, shared by its runs, so that it stays well below 10 MB.
constexpr std::size_t kPlotRows = 12000;      // of one plot; at most half of them of one run
constexpr std::size_t kFrameBytes = 4000000;  // of the replay, before base64
// What is gathered in a run as it was: at the usual rates, of some 80 s; of longer ones coarser.
constexpr std::size_t kLogRows = 16384, kLogFrames = 4096;
constexpr std::size_t kChangesMarked = 50;  // of one signal; more would be a hatching

std::string Number(double value) {
  return fmt::format("{:.4g}", value);
}

/// "loop.load.load.mass" is marked as "load.mass".
std::string LastTwo(const std::string& name) {
  const std::size_t last = name.rfind('.');
  if (last == std::string::npos || last == 0) return name;
  const std::size_t before = name.rfind('.', last - 1);
  return before == std::string::npos ? name : name.substr(before + 1);
}

/// Whether one of the names means this column: its own, or that of its signal.
bool Means(const std::vector<std::string>& names, const std::string& column) {
  return std::any_of(names.begin(), names.end(), [&](const std::string& name) {
    return column == name || column.starts_with(name + ".");
  });
}

}  // namespace

/// What is gathered of one run. Shared by the reports that show it.
struct Report::Run {
  std::vector<std::string> event_signals;
  std::vector<Band> band_signals;
  std::shared_ptr<ColumnLog> signals, frames;
  std::shared_ptr<Geometry> shapes = std::make_shared<Geometry>();
  std::vector<std::pair<std::string, Json>> figures;
  std::vector<std::pair<double, std::string>> events;
  std::optional<bool> good;
  std::string verdict;

  std::vector<Plot> DefaultPlots() const;
  Json Series(const Plot& plot, std::size_t max_rows) const;
  Json Frames(std::size_t max_bytes) const;
  Json Events() const;
  Json Bands() const;
};

void ReportParams::Validate() const {
  for (const Plot& plot : plots) {
    if (plot.signals.empty()) {
      throw ParameterError(fmt::format("the plot '{}' has no signals; name at least one", plot.title));
    }
  }
}

/// One plot for neighbouring columns of one unit, called by what their names begin with.
std::vector<Plot> Report::Run::DefaultPlots() const {
  const auto stem = [&](std::size_t i) {
    return signals->names()[i].substr(0, signals->names()[i].rfind('.'));
  };
  std::vector<Plot> result;
  for (std::size_t i = 0; i < signals->columns(); ++i) {
    if (i == 0 || stem(i) != stem(i - 1) || signals->units()[i] != signals->units()[i - 1])
      result.push_back({stem(i), {}, {}});
    result.back().signals.push_back(signals->names()[i]);
  }
  return result;
}

Json Report::Run::Series(const Plot& plot, std::size_t max_rows) const {
  std::vector<std::size_t> columns;
  const auto add = [&](const std::vector<std::string>& names) {
    for (const std::string& name : names) {
      for (const std::size_t column : FindColumns(signals->names(), name)) columns.push_back(column);
    }
  };
  add(plot.signals);
  const std::size_t num_signals = columns.size();
  add(plot.references);

  const std::vector<std::size_t> rows = internal::DecimatePeaks(*signals, columns, max_rows);
  std::vector<double> time;
  for (const std::size_t row : rows) time.push_back(signals->time(row));
  Json series = Json::array();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    std::vector<float> values;
    for (const std::size_t row : rows) values.push_back(signals->at(row, columns[i]));
    series.push_back({{"name", signals->names()[columns[i]]},
                      {"unit", signals->units()[columns[i]]},
                      {"reference", i >= num_signals},
                      {"pair", i >= num_signals ? i - num_signals : i},
                      {"values", Base64(values)}});
  }
  return {{"title", plot.title}, {"time", Base64(time)}, {"series", std::move(series)}};
}

Json Report::Run::Frames(std::size_t max_bytes) const {
  std::vector<std::size_t> moving;
  std::vector<float> first;
  for (std::size_t column = 0; frames->rows() > 0 && column < frames->columns(); ++column) {
    first.push_back(frames->at(0, column));
    for (std::size_t row = 1; row < frames->rows(); ++row) {
      if (frames->at(row, column) == first.back()) continue;
      moving.push_back(column);
      break;
    }
  }
  const std::size_t bytes = frames->rows() * moving.size() * sizeof(float);
  const std::size_t stride = 1 + bytes / max_bytes;
  std::vector<std::size_t> rows;
  for (std::size_t row = 0; row < frames->rows(); row += stride) rows.push_back(row);
  if (!rows.empty() && rows.back() + 1 < frames->rows()) rows.push_back(frames->rows() - 1);

  std::vector<double> time;
  std::vector<float> data;
  for (const std::size_t row : rows) time.push_back(frames->time(row));
  for (const std::size_t column : moving) {
    for (const std::size_t row : rows) data.push_back(frames->at(row, column));
  }
  Json list = Json::array();
  for (const Shape& shape : *shapes) {
    list.push_back({{"kind", EnumName(shape.kind)},
                    {"role", EnumName(shape.role)},
                    {"name", shape.name},
                    {"size", {shape.size[0], shape.size[1], shape.size[2]}},
                    {"scale", shape.scale},
                    {"unit", shape.unit}});
  }
  return {{"shapes", std::move(list)},
          {"time", Base64(time)},
          {"first", Base64(first)},
          {"moving", moving},
          {"data", Base64(data)}};
}

Json Report::Run::Events() const {
  Json list = Json::array();
  for (const auto& [time, label] : events) list.push_back({{"time", time}, {"label", label}});
  for (const std::string& name : event_signals) {
    for (const std::size_t column : FindColumns(signals->names(), name)) {
      std::size_t changes = 0;
      for (std::size_t row = 1; row < signals->rows() && changes < kChangesMarked; ++row) {
        const float before = signals->at(row - 1, column), after = signals->at(row, column);
        if (before == after) continue;
        ++changes;
        list.push_back({{"time", signals->time(row)},
                        {"label", fmt::format("{} {} → {} {}", LastTwo(signals->names()[column]),
                                              Number(before), Number(after), signals->units()[column])}});
      }
    }
  }
  return list;
}

Json Report::Run::Bands() const {
  Json bands = Json::array();
  for (const Band& band : band_signals) {
    Json intervals = Json::array();
    for (const std::size_t column : FindColumns(signals->names(), band.signal)) {
      for (std::size_t row = 0; row < signals->rows() && intervals.size() < kChangesMarked; ++row) {
        const float value = signals->at(row, column);
        if (row > 0 && value == signals->at(row - 1, column)) continue;
        const auto index = static_cast<std::size_t>(std::max(value, 0.0F));
        const bool named = index < band.names.size() && value == static_cast<float>(index);
        intervals.push_back({{"time", signals->time(row)},
                             {"value", value},
                             {"name", named ? band.names[index] : Number(value)}});
      }
    }
    bands.push_back(std::move(intervals));
  }
  return bands;
}

Report::Report(ReportParams params) : params_(std::move(params)) {
  params_.Validate();
  internal::CheckPageParts();
}
Report::~Report() = default;
Report::Report(Report&&) noexcept = default;

/// Figures and a verdict can be given without a log, for a page that has only these.
Report::Run& Report::own() {
  if (variants_.empty()) variants_.push_back({"", std::make_shared<Run>()});
  return *variants_.front().run;
}

void Report::Log(Simulator& simulator, const std::vector<const Source*>& signals,
                 const std::vector<const OutputPort<Geometry>*>& geometry) {
  Run& run = own();
  if (run.signals != nullptr)
    throw Error("this report logs a run already; make one report for each run, and Add them");

  std::vector<std::string> names;
  bool all_known = true;  // no signal whose size only shows in the run
  for (const Source* signal : signals) {
    const std::vector<Element> elements = signal->Resolve().elements();
    all_known = all_known && !elements.empty();
    for (const Element& element : elements)
      names.push_back(signal->path() + (element.name.empty() ? "" : "." + element.name));
  }
  const auto check = [&](const std::string& place, const std::vector<std::string>& wanted) {
    for (const std::string& name : wanted) {
      if (!all_known || !FindColumns(names, name).empty()) continue;
      std::vector<std::string> known = names;
      for (const Source* signal : signals) known.push_back(signal->path());
      throw ParameterError(
          fmt::format("{} there is no signal '{}'; did you mean '{}'? The names are those of signals.csv",
                      place, name, internal::NearestName(name, known)));
    }
  };
  for (const Plot& plot : params_.plots) {
    check(fmt::format("plot '{}':", plot.title), plot.signals);
    check(fmt::format("plot '{}':", plot.title), plot.references);
  }
  check("events of the report:", params_.events);
  for (const Band& band : params_.bands) check("bands of the report:", {band.signal});

  run.event_signals = params_.events;
  run.band_signals = params_.bands;
  // The sinks outlive this call, and perhaps the report: they hold copies.
  run.signals = std::make_shared<ColumnLog>(
      ColumnLog::Thinning::kPeaks, kLogRows,
      [plots = params_.plots, events = params_.events, bands = params_.bands](const std::string& column) {
        return plots.empty() || Means(events, column) ||
               std::any_of(bands.begin(), bands.end(),
                           [&](const Band& band) { return Means({band.signal}, column); }) ||
               std::any_of(plots.begin(), plots.end(), [&](const Plot& plot) {
                 return Means(plot.signals, column) || Means(plot.references, column);
               });
      },
      nullptr);
  simulator.AddLog(params_.signal_rate, signals, {run.signals});

  // What stays the same of the shapes is in the values, not in the rows.
  run.frames = std::make_shared<ColumnLog>(ColumnLog::Thinning::kSample, kLogFrames, nullptr,
                                           [all = run.shapes, &simulator, geometry] {
                                             for (const auto* port : geometry) {
                                               const Geometry& shapes = simulator.context().Eval(*port);
                                               all->insert(all->end(), shapes.begin(), shapes.end());
                                             }
                                           });
  if (!geometry.empty()) {
    simulator.AddLog(params_.frame_rate, {geometry.begin(), geometry.end()}, {run.frames});
  }
}

void Report::AddFigure(const std::string& name, std::optional<double> value) {
  own().figures.emplace_back(name, value ? Json(*value) : Json(nullptr));
}
void Report::AddFigure(const std::string& name, const std::string& text) {
  own().figures.emplace_back(name, text);
}
void Report::AddEvent(double time, const std::string& label) {
  own().events.emplace_back(time, label);
}

void Report::Conclude(bool good, const std::string& verdict) {
  own().good = good;
  own().verdict = verdict;
}
void Report::Conclude(const RunStatus& status) {
  if (status.ended) AddEvent(status.time, status.reason);
  Conclude(!status.ended, status.ended ? fmt::format("ended at {} s: {}", Number(status.time), status.reason)
                                       : fmt::format("finished after {} s", Number(status.time)));
}

void Report::Add(const std::string& variant, const Report& other) {
  if (other.variants_.size() != 1)
    throw Error(fmt::format("cannot add the variant '{}': a report of one run is needed", variant));
  variants_.push_back({variant, other.variants_.front().run});
}

void Report::Write(const std::filesystem::path& file) const {
  if (variants_.empty()) throw RunError("the report is empty: Log a run, or Add one");
  Json data{{"title", params_.title}, {"description", params_.description}, {"runs", Json::array()}};
  for (const auto& [name, run] : variants_) {
    Json json{{"name", name}, {"verdict", run->verdict}, {"figures", run->figures}};
    json["good"] = run->good ? Json(*run->good) : Json(nullptr);
    json["plots"] = Json::array();
    if (run->signals != nullptr) {
      for (const Plot& plot : params_.plots.empty() ? run->DefaultPlots() : params_.plots)
        json["plots"].push_back(run->Series(plot, kPlotRows / std::max<std::size_t>(2, variants_.size())));
      json["frames"] = run->Frames(kFrameBytes / variants_.size());
      json["events"] = run->Events();
      json["bands"] = run->Bands();
    }
    data["runs"].push_back(std::move(json));
  }
  internal::WritePage(file, params_.title, data.dump(-1, ' ', false, Json::error_handler_t::replace));
}

}  // namespace tenon
