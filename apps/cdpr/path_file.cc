#include <tenon/apps/cdpr/path_file.h>
#include <tenon/systems/files/input_file.h>
#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/text/text.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace tenon::apps {
namespace {

constexpr const char* kPositions = "t,x,y,z";
constexpr const char* kPoses = "t,x,y,z,roll,pitch,yaw";

/// Removes blanks and carriage returns at both ends.
std::string_view Trimmed(std::string_view text) {
  constexpr const char* kBlanks = " \t\r";
  const std::size_t begin = text.find_first_not_of(kBlanks);
  return begin == text.npos ? "" : text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

std::vector<std::string_view> Cells(std::string_view line) {
  std::vector<std::string_view> cells;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find(',', begin), line.size());
    cells.push_back(Trimmed(line.substr(begin, end - begin)));
    begin = end + 1;
  }
  return cells;
}

}  // namespace

PathTable ReadPathFile(const std::string& file) {
  std::ifstream in = OpenInput(file);
  if (!in.is_open())
    throw ParameterError(fmt::format("{}: cannot be read: give the path of a CSV file", file));
  PathTable table;
  std::string line;
  int number = 1;
  const auto refuse = [&](const std::string& what) {
    throw ParameterError(fmt::format("{}:{}: {}", file, number, what));
  };
  std::getline(in, line);
  if (line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);  // a byte-order mark
  const std::string header = fmt::format("{}", fmt::join(Cells(line), ","));
  if (header != kPositions && header != kPoses)
    refuse(fmt::format("the columns are '{}': give '{}' or '{}', in s, m and rad", internal::Excerpt(header),
                       kPositions, kPoses));
  const std::size_t columns = header == kPoses ? 7 : 4;

  while (std::getline(in, line)) {
    ++number;
    if (Trimmed(line).empty()) continue;
    std::vector<double> row;
    for (const std::string_view cell : Cells(line)) {
      const auto value = internal::NumberIn<double>(cell);
      if (!value || !std::isfinite(*value))
        refuse(fmt::format("'{}' is not a finite number", internal::Excerpt(std::string(cell))));
      row.push_back(*value);
    }
    if (row.size() != columns)
      refuse(fmt::format("{} values, but the header names {} columns", row.size(), columns));
    if (!table.times.empty() && row[0] <= table.times.back())
      refuse(fmt::format("t = {} s does not come after the {} s of the row before: times must increase",
                         row[0], table.times.back()));
    table.times.push_back(row[0]);
    table.points.emplace_back(row[1], row[2], row[3]);
    if (columns == 7) table.attitudes.emplace_back(row[4], row[5], row[6]);
  }
  if (table.times.size() < 2) refuse(fmt::format("{} points: a path needs two or more", table.times.size()));
  return table;
}

}  // namespace tenon::apps
