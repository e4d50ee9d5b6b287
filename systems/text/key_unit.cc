#include <tenon/systems/text/key_unit.h>

#include <algorithm>
#include <cctype>

namespace tenon::internal {
namespace {

bool IsUnit(std::string_view word) {
  constexpr std::string_view kUnits[] = {
      "m",  "mm", "cm",   "km",  "um",  "g",   "kg",   "t",   "lb",  "s",   "ms",  "us",      "ns",
      "h",  "Hz", "sqrt", "kHz", "rpm", "rad", "mrad", "deg", "N",   "mN",  "kN",  "Nm",      "J",
      "kJ", "W",  "kW",   "V",   "mV",  "A",   "mA",   "Pa",  "kPa", "MPa", "GPa", "percent", "per"};
  while (word.size() > 1 && word.back() >= '2' && word.back() <= '4') word.remove_suffix(1);
  return std::ranges::count(kUnits, word) > 0;
}

}  // namespace

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
