#include <tenon/apps/common/figure_text.h>
#include <tenon/systems/text/text.h>

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace tenon::apps {

namespace {

constexpr std::size_t kNarrowest = 10;  // minimal width of a column of numbers [characters]
constexpr std::size_t kWidest = 24;     // maximal width of a column of a run [characters]
constexpr std::size_t kLongLine = 120;  // wider tables are written as lines [characters]

/// Counts characters: all bytes except continuation bytes of UTF-8.
std::size_t Width(const std::string& text) {
  return static_cast<std::size_t>(
      std::ranges::count_if(text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }));
}

std::string Cut(const std::string& text) {
  if (Width(text) <= kWidest) return text;
  std::size_t end = 0;
  for (std::size_t count = 0; end < text.size(); ++end) {
    if ((static_cast<unsigned char>(text[end]) & 0xC0) != 0x80 && ++count == kWidest) break;
  }
  return text.substr(0, end) + "…";
}

std::string Left(const std::string& text, std::size_t width) {
  return text + std::string(width - std::min(width, Width(text)), ' ');
}

std::string Right(const std::string& text, std::size_t width) {
  return std::string(width - std::min(width, Width(text)), ' ') + text;
}

/// Removes trailing blanks and ends the line.
std::string Line(std::string text) {
  text.erase(text.find_last_not_of(' ') + 1);
  return text + '\n';
}

std::string Behind(const FigureText& figure) {
  return (figure.unit.empty() ? "" : " " + figure.unit) + figure.limit;
}

std::vector<std::string> NamesOf(const FigureText& figure) {
  std::vector<std::string> names;
  for (const auto& [name, value] : figure.values) names.push_back(name);
  return names;
}

bool IsNumber(const std::string& text) {
  const auto number = internal::NumberIn<double>(text);
  return number && std::isfinite(*number);
}

/// Formats a value; integers keep all digits, because a seed can have more digits than a double.
std::string ValueText(const std::string& text) {
  if (text.empty()) return "-";
  const auto number = internal::NumberIn<double>(text);
  if (number && !std::isfinite(*number)) return text;  // differs from a figure without a value
  return number && text.find_first_not_of("+-0123456789") != text.npos ? NumberText(*number) : text;
}

/// Returns the unit of the last part of a dotted key that has one: "m" for foot_error_max_m.front_left.
std::string UnitOf(const std::string& key) {
  const std::size_t dot = key.rfind('.');
  const std::string unit = internal::UnitOfKey(dot == key.npos ? key : key.substr(dot + 1));
  return unit.empty() && dot != key.npos ? UnitOf(key.substr(0, dot)) : unit;
}

std::size_t ColumnWidth(const std::string& head) {
  return std::max(Width(head), kNarrowest) + 2;
}

/// Formats a table of figures that have values for the same names.
std::string Table(const std::vector<std::string>& names, const std::vector<FigureText>& figures,
                  std::size_t key_width) {
  std::string heads = Left("", key_width), lines;
  for (const std::string& name : names) heads += Right(name, ColumnWidth(name));
  for (const FigureText& figure : figures) {
    std::string line = Left(figure.key, key_width);
    for (const auto& [name, value] : figure.values) line += Right(value, ColumnWidth(name));
    lines += Line(line + Behind(figure));
  }
  return "\n" + Line(heads) + lines;
}

}  // namespace

std::string NumberText(double value) {
  if (!std::isfinite(value)) return "-";
  if (value == std::round(value) && std::abs(value) < 1e15) return fmt::format("{:.0f}", value + 0.0);
  const double magnitude = std::abs(value);
  if (magnitude < 1e3 || magnitude >= 1e7) return fmt::format("{:.4g}", value);
  const double step = std::pow(10, std::floor(std::log10(magnitude)) - 3);
  return fmt::format("{:.0f}", std::round(value / step) * step);
}

std::vector<FigureText> FigureTexts(const NamedTexts& flat) {
  const auto parent = [](const std::string& key) { return key.substr(0, key.rfind('.')); };
  std::vector<FigureText> figures;
  for (std::size_t i = 0; i < flat.size();) {
    const std::string& key = flat[i].first;
    std::size_t end = i + 1;  // end of the neighbours with the same parent key
    while (key.find('.') != key.npos && end < flat.size() && parent(flat[end].first) == parent(key)) ++end;
    const bool several = end > i + 1;
    FigureText& figure = figures.emplace_back(FigureText{.key = several ? parent(key) : key, .values = {}});
    for (; i < end; ++i) {
      const auto& [name, text] = flat[i];
      figure.values.emplace_back(several ? name.substr(figure.key.size() + 1) : "", ValueText(text));
      if (IsNumber(text)) figure.unit = UnitOf(figure.key);
    }
  }
  return figures;
}

std::string FigureLines(const std::vector<FigureText>& figures) {
  std::size_t width = 0;
  for (const FigureText& figure : figures) width = std::max(width, figure.key.size() + 2);
  std::string lines;
  std::vector<std::pair<std::vector<std::string>, std::vector<FigureText>>>
      tables;  // by the names of their values
  for (const FigureText& figure : figures) {
    const std::vector<std::string> names = NamesOf(figure);
    std::size_t total = width;
    for (const std::string& name : names) total += ColumnWidth(name);
    if (names.size() == 1 || total > kLongLine) {
      for (const auto& [name, value] : figure.values) {
        const std::string key = name.empty() ? figure.key : figure.key + "." + name;
        lines += Line(Left(key, std::max(width, key.size() + 2)) + value + Behind(figure));
      }
      continue;
    }
    const auto same = std::ranges::find_if(tables, [&](const auto& table) { return table.first == names; });
    if (same == tables.end()) {
      tables.push_back({names, {figure}});
    } else {
      same->second.push_back(figure);
    }
  }
  for (const auto& [names, of_names] : tables) lines += Table(names, of_names, width);
  return lines;
}

std::string FigureColumns(const std::vector<std::pair<std::string, NamedTexts>>& runs) {
  std::vector<FigureText> figures;  // in the order of their first appearance, with a value for each run
  std::vector<std::size_t> widths;
  std::size_t key_width = 0;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    widths.push_back(ColumnWidth(Cut(runs[i].first)));
    for (const auto& [key, text] : runs[i].second) {
      auto figure = std::ranges::find(figures, key, &FigureText::key);
      if (figure == figures.end()) {
        const std::vector missing(runs.size(), std::pair<std::string, std::string>("", "-"));
        figure = figures.insert(figure, FigureText{.key = key, .values = missing});
        key_width = std::max(key_width, key.size());
      }
      const std::string shown = Cut(ValueText(text));
      figure->values[i].second = shown;
      if (IsNumber(text)) figure->unit = UnitOf(key);
      widths[i] = std::max(widths[i], Width(shown) + 2);
    }
  }
  std::string text;
  for (std::size_t begin = 0, end = 0; begin < runs.size(); begin = end) {
    std::size_t width = key_width + widths[end++];
    while (end < runs.size() && width + widths[end] <= kLongLine) width += widths[end++];
    std::string head = Left("", key_width);
    for (std::size_t i = begin; i < end; ++i) head += Right(Cut(runs[i].first), widths[i]);
    text += (begin > 0 ? "\n" : "") + Line(head);
    for (const FigureText& figure : figures) {
      std::string line = Left(figure.key, key_width);
      for (std::size_t i = begin; i < end; ++i) line += Right(figure.values[i].second, widths[i]);
      text += Line(line + Behind(figure));
    }
  }
  return text;
}

std::pair<std::string, std::string> Beside(double value, double limit, int digits) {
  const auto text = [&](double number) { return fmt::format("{:.{}g}", number, digits); };
  while (value != limit && text(value) == text(limit) && digits < std::numeric_limits<double>::max_digits10)
    ++digits;
  return {text(value), text(limit)};
}

}  // namespace tenon::apps
