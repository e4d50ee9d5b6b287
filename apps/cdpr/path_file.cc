#include <tenon/apps/cdpr/path_file.h>

#include <fmt/core.h>

#include <charconv>
#include <cmath>
#include <fstream>
#include <string_view>

#include <tenon/systems/framework/errors.h>
#include <tenon/systems/framework/internal/excerpt.h>

namespace tenon::apps {
namespace {

constexpr const char* kPositions = "t,x,y,z";
constexpr const char* kPoses = "t,x,y,z,roll,pitch,yaw";

/// Without blanks, and without what other systems put at the end of a line.
std::string Compact(const std::string& line) {
  std::string text;
  for (const char c : line)
    if (c != ' ' && c != '\t' && c != '\r') text += c;
  return text;
}

}  // namespace

PathTable ReadPathFile(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw ParameterError(fmt::format("{}: cannot be read: give the path of a CSV file", file));
  PathTable table;
  std::string line;
  int number = 1;
  const auto refuse = [&](const std::string& what) {
    throw ParameterError(fmt::format("{}:{}: {}", file, number, what));
  };
  std::getline(in, line);
  const std::string header = Compact(line);
  if (header != kPositions && header != kPoses)
    refuse(fmt::format("the columns are '{}': give '{}' or '{}', in s, m and rad", internal::Excerpt(header),
                       kPositions, kPoses));
  const std::size_t columns = header == kPoses ? 7 : 4;

  while (std::getline(in, line)) {
    ++number;
    const std::string text = Compact(line);
    if (text.empty()) continue;
    std::vector<double> row;
    for (std::size_t begin = 0; begin <= text.size();) {
      const std::size_t end = std::min(text.find(',', begin), text.size());
      double value = 0;
      const auto [stop, error] = std::from_chars(text.data() + begin, text.data() + end, value);
      if (error != std::errc() || stop != text.data() + end || !std::isfinite(value))
        refuse(fmt::format("'{}' is no finite number", internal::Excerpt(text.substr(begin, end - begin))));
      row.push_back(value);
      begin = end + 1;
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
  if (table.times.size() < 2) refuse(fmt::format("{} points: a path takes two or more", table.times.size()));
  return table;
}

}  // namespace tenon::apps
