#include <tenon/apps/common/beside.h>

#include <fmt/core.h>

#include <limits>

namespace tenon::apps {

std::pair<std::string, std::string> Beside(double value, double limit, int digits) {
  const auto text = [&](double number) { return fmt::format("{:.{}g}", number, digits); };
  while (value != limit && text(value) == text(limit) && digits < std::numeric_limits<double>::max_digits10)
    ++digits;
  return {text(value), text(limit)};
}

}  // namespace tenon::apps
