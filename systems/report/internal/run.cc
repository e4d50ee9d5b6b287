#include <tenon/systems/files/input_file.h>
#include <tenon/systems/report/internal/report_json.h>
#include <tenon/systems/text/text.h>

#include <fmt/format.h>

namespace tenon {
namespace {

namespace fs = std::filesystem;
using internal::Base64;
using internal::ColumnLog;
using internal::FindColumns;
using Json = nlohmann::ordered_json;

// Limits for the data of a page, which its runs share, so that the page stays below 10 MB.
constexpr std::size_t kPlotRows = 12000;      // rows of one plot; one run uses at most half of them
constexpr std::size_t kPlotSamples = 400000;  // samples of plotted signals, 4 bytes each before base64
constexpr std::size_t kRestSamples = 180000;  // samples of the other signals, 6 bytes each
constexpr std::size_t kRestRows = 4000;       // rows of one of the other signals
constexpr std::size_t kFrameBytes = 2700000;  // size of the replay before base64
constexpr std::size_t kChangesMarked = 50;    // marked changes of one signal; more would be unreadable
constexpr std::size_t kModesMarked = 1000;    // marked modes of one band

std::string Number(double value) {
  return fmt::format("{:.4g}", value);
}

/// Shortens the name of a signal for a label: "loop.load.load.mass" to "load.mass".
std::string LastTwo(const std::string& name) {
  const std::size_t last = name.rfind('.');
  if (last == std::string::npos || last == 0) return name;
  const std::size_t before = name.rfind('.', last - 1);
  return before == std::string::npos ? name : name.substr(before + 1);
}

Limits LimitsFrom(const Json& json) {
  const auto bound = [](const Json& value) {
    return value.is_null() ? std::nullopt : std::optional<double>(value);
  };
  return {bound(json.at(0)), bound(json.at(1))};
}

/// Returns columns of a log at common rows, without rows that repeat the previous values.
Json Group(const ColumnLog& log, const std::vector<std::size_t>& columns, std::size_t max_rows) {
  const std::vector<std::size_t> all = internal::DecimatePeaks(log, columns, max_rows);
  const auto same = [&](std::size_t a, std::size_t b) {
    return std::ranges::all_of(columns, [&](std::size_t c) { return log.at(a, c) == log.at(b, c); });
  };
  std::vector<std::uint16_t> rows;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (i == 0 || i + 1 == all.size() || !same(all[i], all[i - 1]) || !same(all[i], all[i + 1]))
      rows.push_back(static_cast<std::uint16_t>(all[i]));
  }
  Json list = Json::array();
  for (const std::size_t column : columns) {
    std::vector<float> values;
    for (const std::uint16_t row : rows) values.push_back(log.at(row, column));
    list.push_back(
        {{"name", log.names()[column]}, {"unit", log.units()[column]}, {"values", Base64(values)}});
  }
  return {{"rows", Base64(rows)}, {"columns", std::move(list)}};
}

/// Returns {start, step, count} for equidistant times, else all times.
Json Times(const ColumnLog& log) {
  std::vector<double> time;
  for (std::size_t row = 0; row < log.rows(); ++row) time.push_back(log.time(row));
  const double step =
      time.size() > 1 ? (time.back() - time.front()) / static_cast<double>(time.size() - 1) : 0;
  for (std::size_t row = 0; row < time.size(); ++row) {
    if (std::abs(time[row] - (time.front() + static_cast<double>(row) * step)) > 1e-9) return Base64(time);
  }
  return {{"start", time.empty() ? 0 : time.front()}, {"step", step}, {"count", time.size()}};
}

/// Returns whether a value has not changed; NaN equals NaN.
bool Same(float before, float after) {
  return before == after || (std::isnan(before) && std::isnan(after));
}

Json BandJson(const Band& band, const ColumnLog& log) {
  Json intervals = Json::array();
  for (const std::size_t column : FindColumns(log.names(), band.signal)) {
    for (std::size_t row = 0; row < log.rows(); ++row) {
      const float value = log.at(row, column);
      if (row > 0 && Same(value, log.at(row - 1, column))) continue;
      if (intervals.size() == kModesMarked) {
        intervals.push_back(
            {{"time", log.time(row)}, {"value", nullptr}, {"name", "further changes are not shown"}});
        return intervals;
      }
      const bool in_names = value >= 0 && value < static_cast<float>(band.names.size());
      const std::size_t index = in_names ? static_cast<std::size_t>(value) : 0;
      const bool named = in_names && value == static_cast<float>(index);
      intervals.push_back(
          {{"time", log.time(row)}, {"value", value}, {"name", named ? band.names[index] : Number(value)}});
    }
  }
  return intervals;
}

template <class E>
E EnumFrom(const Json& name) {
  for (const auto& [value, text] : EnumNames(E{})) {
    if (name == text) return value;
  }
  throw ParameterError(fmt::format("unknown name {}", name.dump()));
}

}  // namespace

std::vector<Plot> Report::Run::DefaultPlots() const {
  const auto stem = [&](std::size_t i) {
    return signals->names()[i].substr(0, signals->names()[i].rfind('.'));
  };
  std::vector<Plot> result;
  for (std::size_t i = 0; i < signals->columns(); ++i) {
    if (i == 0 || stem(i) != stem(i - 1) || signals->units()[i] != signals->units()[i - 1])
      result.push_back({.title = stem(i)});
    result.back().signals.push_back(signals->names()[i]);
  }
  return result;
}

/// Returns {time, groups: [{rows, columns: [{name, unit, values}]}]}, where a group has samples at the given
/// rows of `time`. The columns of a plot form one group, so that a signal and its reference have the same
/// times.
Json Report::Run::Samples(const std::vector<Plot>& plots, std::size_t num_runs) const {
  std::vector<bool> taken(signals->columns());
  std::vector<std::vector<std::size_t>> groups;
  std::size_t num_plotted = 0;
  for (const Plot& plot : plots) {
    std::vector<std::size_t> group;
    for (const auto& names : {plot.signals, plot.references}) {
      for (const std::string& name : names) {
        for (const std::size_t column : FindColumns(signals->names(), name)) {
          if (!taken[column]) group.push_back(column);
          taken[column] = true;
        }
      }
    }
    num_plotted += group.size();
    if (!group.empty()) groups.push_back(std::move(group));
  }
  const std::size_t plot_rows = std::min(kPlotRows / std::max<std::size_t>(2, num_runs),
                                         kPlotSamples / num_runs / std::max<std::size_t>(1, num_plotted));
  const std::size_t num_rest = std::max<std::size_t>(1, signals->columns() - num_plotted);
  const std::size_t rest_rows = std::min(kRestRows, kRestSamples / num_runs / num_rest);

  Json json = Json::array();
  for (const auto& group : groups) json.push_back(Group(*signals, group, plot_rows));
  for (std::size_t column = 0; column < signals->columns(); ++column)
    if (!taken[column]) json.push_back(Group(*signals, {column}, rest_rows));
  return {{"time", Times(*signals)}, {"groups", std::move(json)}};
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
  return {{"shapes", internal::ShapesJson(*shapes)},
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
        if (Same(before, after)) continue;
        ++changes;
        list.push_back({{"time", signals->time(row)},
                        {"label", fmt::format("{} {} → {} {}", LastTwo(signals->names()[column]),
                                              Number(before), Number(after), signals->units()[column])}});
      }
    }
  }
  return list;
}

Json Report::Run::ToJson(const std::vector<Plot>& plots, std::size_t num_runs) const {
  Json json{{"verdict", verdict}, {"good", internal::JsonOrNull(good)}, {"figures", Json::array()}};
  for (const Figure& figure : figures) {
    Json item{{"name", figure.name}, {"value", figure.value}};
    if (figure.limits.low || figure.limits.high) item["limits"] = internal::LimitsJson(figure.limits);
    json["figures"].push_back(std::move(item));
  }
  if (signals == nullptr) return json;
  json["samples"] = Samples(plots, num_runs);
  json["frames"] = Frames(kFrameBytes / num_runs);
  json["events"] = Events();
  json["bands"] = Json::array();
  for (const Band& band : bands)
    json["bands"].push_back(
        {{"signal", band.signal}, {"names", band.names}, {"intervals", BandJson(band, *signals)}});
  json["limits"] = internal::LimitsJson(limits);
  return json;
}

std::size_t Report::Run::JsonBytes() const {
  std::size_t bytes = 1 << 16;
  if (signals == nullptr) return bytes;
  bytes += std::min(signals->rows() * signals->columns() * 6, kPlotSamples * 4 + kRestSamples * 6);
  bytes += std::min(frames->rows() * frames->columns() * 4, kFrameBytes);
  bytes += signals->columns() * 512;  // names and list overhead
  return bytes * 4 / 3;               // as base64
}

Report::Run Report::Run::FromJson(const Json& json) {
  Run run;
  run.verdict = json.at("verdict");
  if (!json.at("good").is_null()) run.good = json.at("good").get<bool>();
  for (const Json& item : json.at("figures")) {
    run.figures.push_back({item.at("name"), item.at("value"),
                           item.contains("limits") ? LimitsFrom(item.at("limits")) : Limits{}});
  }
  for (const Json& event : json.at("events")) run.events.emplace_back(event.at("time"), event.at("label"));
  for (const Json& band : json.at("bands")) run.bands.push_back({band.at("signal"), band.at("names")});
  for (const Json& item : json.at("limits"))
    run.limits.push_back({item.at("signal"), LimitsFrom(item.at("limits"))});

  const Json& frames = json.at("frames");
  for (const Json& item : frames.at("shapes")) {
    Shape shape;
    shape.kind = EnumFrom<ShapeKind>(item.at("kind"));
    shape.role = EnumFrom<ShapeRole>(item.at("role"));
    shape.name = item.at("name");
    for (std::size_t k = 0; k < 3; ++k) shape.size[static_cast<Eigen::Index>(k)] = item.at("size").at(k);
    shape.scale = item.at("scale");
    shape.unit = item.at("unit");
    if (item.contains("corners")) {
      TriangleMesh mesh{internal::FromBase64<std::array<float, 3>>(item.at("corners")),
                        internal::FromBase64<std::array<std::uint32_t, 3>>(item.at("triangles"))};
      if (item.contains("colours"))
        mesh.colours = internal::FromBase64<std::array<std::uint8_t, 4>>(item.at("colours"));
      shape.mesh = std::make_shared<const TriangleMesh>(std::move(mesh));
    }
    run.shapes->push_back(std::move(shape));
  }
  const auto time = internal::FromBase64<double>(frames.at("time").get<std::string>());
  const auto first = internal::FromBase64<float>(frames.at("first").get<std::string>());
  const auto data = internal::FromBase64<float>(frames.at("data").get<std::string>());
  const auto moving = frames.at("moving").get<std::vector<std::size_t>>();
  std::vector<double> row(1 + first.size());
  std::ranges::copy(first, row.begin() + 1);
  run.frames = std::make_shared<ColumnLog>(ColumnLog::Thinning::kSample, ColumnLog::kFrames, nullptr);
  run.frames->Begin(std::vector<std::string>(row.size()), std::vector<std::string>(row.size()));
  for (std::size_t i = 0; i < time.size(); ++i) {
    row[0] = time[i];
    for (std::size_t k = 0; k < moving.size(); ++k) row.at(1 + moving[k]) = data.at(k * time.size() + i);
    run.frames->Row(row);
  }
  return run;
}

namespace {

std::string ReadPart(const fs::path& directory, const std::string& name) {
  std::ifstream in = OpenInput(directory / name, std::ios::binary);
  if (!in.is_open()) {
    throw ParameterError(
        fmt::format("'{}' has no {}: give the output directory of one run; a comparison has them in "
                    "subdirectories",
                    directory.string(), name));
  }
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Reads a file of CsvLog, and computes what `plots` derive from it.
std::shared_ptr<ColumnLog> ReadSignals(const fs::path& file, std::string_view text,
                                       const std::vector<Plot>& plots) {
  const auto fail = [&](std::size_t line, const std::string& what) {
    throw ParameterError(fmt::format("'{}', line {}: {}; run the scenario again", file.string(), line, what));
  };
  const auto next_line = [&] {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(line.size() + 1, text.size()));
    return line;
  };
  std::vector<std::string> names, units;
  internal::Split(next_line(), ',', [&](std::string_view cell) {
    const std::size_t unit = cell.ends_with(']') ? cell.rfind(" [") : cell.npos;
    names.emplace_back(cell.substr(0, unit));
    units.emplace_back(unit == cell.npos ? "" : cell.substr(unit + 2, cell.size() - unit - 3));
  });
  if (names.front() != "time") fail(1, "the first column of a log must be the time");
  auto log = std::make_shared<ColumnLog>(ColumnLog::Thinning::kPeaks, ColumnLog::kRows, nullptr);
  const std::shared_ptr<LogSink> sink = internal::WithDerived(plots, log);
  sink->Begin(names, units);
  std::vector<double> row;
  for (std::size_t number = 2; !text.empty(); ++number) {
    row.clear();
    internal::Split(next_line(), ',', [&](std::string_view cell) {
      const auto value = internal::NumberIn<double>(cell);
      if (!value) fail(number, fmt::format("'{}' is no number", cell.substr(0, 40)));
      row.push_back(*value);
    });
    if (row.size() != names.size())
      fail(number, fmt::format("the line has {} values for {} columns", row.size(), names.size()));
    sink->Row(row);
  }
  return log;
}

}  // namespace

Report Report::Read(const fs::path& directory) {
  if (!fs::is_directory(directory))
    throw ParameterError(
        fmt::format("'{}' is not a directory: give the output directory of a run", directory.string()));
  const std::string text = ReadPart(directory, "report.html");
  const std::string signals = ReadPart(directory, "signals.csv");
  try {
    const Json data = Json::parse(internal::DataOf(text));
    if (data.at("format") == internal::kPageFormat && data.at("runs").size() == 1) {
      Report report({.title = data.at("title"), .description = data.at("description")});
      for (const Json& plot : data.at("plots")) {
        report.params_.plots.push_back(
            {plot.at("title"), plot.at("signals"), plot.at("references"), plot.at("group")});
      }
      report.variants_.push_back({"", std::make_shared<Run>(Run::FromJson(data.at("runs").at(0)))});
      report.own().signals = ReadSignals(directory / "signals.csv", signals, report.params_.plots);
      return report;
    }
  } catch (const Json::exception&) {  // handled below
  } catch (const std::out_of_range&) {
  }
  throw ParameterError(
      fmt::format("'{}' is not the report of one run by this version of Tenon: run the scenario again",
                  (directory / "report.html").string()));
}

}  // namespace tenon
