#include <tenon/systems/files/input_file.h>
#include <tenon/systems/report/internal/page.h>
#include <tenon/systems/report/internal/run.h>
#include <tenon/systems/text/text.h>

#include <fmt/format.h>

#include <sstream>

namespace tenon {

namespace {

namespace fs = std::filesystem;
using internal::ColumnLog;
using Json = nlohmann::ordered_json;

std::string ReadPart(const fs::path& directory, const std::string& name) {
  std::ifstream in = OpenInput(directory / name, std::ios::binary);
  if (!in.is_open()) {
    throw ParameterError(
        fmt::format("'{}' has no {}: give the output directory of one run; a comparison has them in "
                    "subdirectories",
                    directory.string(), name));
  }
  std::ostringstream text;
  text << in.rdbuf();
  return std::move(text).str();
}

/// Calls `take` with each cell of a line.
void Split(std::string_view line, char separator, const auto& take) {
  for (std::size_t end; (end = line.find(separator)) != line.npos; line.remove_prefix(end + 1))
    take(line.substr(0, end));
  take(line);
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
  Split(next_line(), ',', [&](std::string_view cell) {
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
    Split(next_line(), ',', [&](std::string_view cell) {
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
