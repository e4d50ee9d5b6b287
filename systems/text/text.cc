#include <tenon/systems/text/text.h>

#include <fmt/format.h>
#include <utf8.h>

#include <algorithm>
#include <cctype>
#include <numeric>

namespace tenon::internal {
namespace {

std::string Escaped(std::string_view text, int max_characters, bool keep_lines) {
  std::string excerpt;
  int characters = 0;
  const char* bad = utf8::find_invalid(text.begin(), text.end());
  for (const char* at = text.begin(); at != text.end(); ++at) {
    const char c = *at;
    const auto byte = static_cast<unsigned char>(c);
    const bool is_text = at != bad;
    const bool continues = is_text && (byte & 0xC0) == 0x80;  // belongs to the character of the previous byte
    if (!continues && ++characters > max_characters) return excerpt + "…";
    if (!is_text) {
      excerpt += fmt::format("\\x{:02x}", byte);
      bad = utf8::find_invalid(at + 1, text.end());
    } else if (c == '\n' && !keep_lines) {
      excerpt += "\\n";
    } else if (byte == 0xC2 && static_cast<unsigned char>(at[1]) < 0xA0) {
      excerpt += fmt::format("\\x{:02x}", static_cast<unsigned char>(*++at));  // U+0080 to U+009F
    } else if ((byte < 0x20 && c != '\n') || byte == 0x7F) {
      excerpt += fmt::format("\\x{:02x}", byte);
    } else {
      excerpt += c;
    }
  }
  return excerpt;
}

std::size_t EditDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substitute = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substitute});
    }
  }
  return row.back();
}

bool IsUnit(std::string_view word) {
  constexpr std::string_view kUnits[] = {
      "m",  "mm", "cm",   "km",  "um",  "g",   "kg",   "t",   "lb",  "s",   "ms",  "us",      "ns",
      "h",  "Hz", "sqrt", "kHz", "rpm", "rad", "mrad", "deg", "N",   "mN",  "kN",  "Nm",      "J",
      "kJ", "W",  "kW",   "V",   "mV",  "A",   "mA",   "Pa",  "kPa", "MPa", "GPa", "percent", "per"};
  while (word.size() > 1 && word.back() >= '2' && word.back() <= '4') word.remove_suffix(1);
  return std::ranges::count(kUnits, word) > 0;
}

}  // namespace

std::string Excerpt(std::string_view text) {
  return Escaped(text, 80, false);
}

std::string Printable(std::string_view message) {
  return Escaped(message, 4000, true);
}

std::string NearestName(std::string_view wanted, const std::vector<std::string>& names) {
  const auto distance = [&](const std::string& name) { return EditDistance(wanted, name); };
  const auto nearest = std::ranges::min_element(names, {}, distance);
  return nearest == names.end() ? "" : *nearest;
}

std::pair<std::string_view, std::string_view> SplitUnit(std::string_view key) {
  std::size_t end = key.size();
  while (true) {
    const std::size_t bar = key.substr(0, end).rfind('_');
    if (bar == std::string_view::npos || bar == 0 || !IsUnit(key.substr(bar + 1, end - bar - 1))) break;
    end = bar;
  }
  return {key.substr(0, end), end == key.size() ? "" : key.substr(end + 1)};
}

std::string UnitOfKey(std::string_view key) {
  if (key.ends_with("_hz")) return "Hz";
  std::string_view rest = SplitUnit(key).second;
  std::string unit;
  bool gap = false, below = false;
  while (!rest.empty()) {
    const std::size_t bar = std::min(rest.find('_'), rest.size());
    std::string word(rest.substr(0, bar));
    rest.remove_prefix(std::min(bar + 1, rest.size()));
    if (word == "per") {
      unit += unit.empty() ? "1/" : "/";
      gap = false;
      below = true;
      continue;
    }
    if (word == "sqrt") {
      unit += "√";
      gap = false;
      continue;
    }
    if (gap) unit += " ";
    for (const char c : word)
      unit += std::isdigit(static_cast<unsigned char>(c)) ? std::string{'^', c} : std::string{c};
    gap = true;
  }
  return below && unit.find(' ', unit.find('/')) != unit.npos
             ? unit.substr(0, unit.find('/') + 1) + "(" + unit.substr(unit.find('/') + 1) + ")"
             : unit;
}

}  // namespace tenon::internal
