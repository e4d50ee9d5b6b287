#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/live/internal/parameter_ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>

namespace tenon::internal {
namespace {

constexpr double kFar = 1e9;    // relative distance treated as unbounded
constexpr double kNear = 1e-7;  // relative distance treated as at the bound

/// Returns the last value in direction `sign` from `value` for which `accepts` is true.
template <class Accepts>
double Bound(double value, double sign, const Accepts& accepts) {
  const double size = std::max(std::abs(value), 1e-3);
  double good = value, bad = value;
  for (double step = size;; step *= 10) {
    if (step > kFar * size) return sign * std::numeric_limits<double>::infinity();
    bad = value + sign * step;
    if (!accepts(bad)) break;
    good = bad;
  }
  while (std::abs(bad - good) > kNear * std::max(std::abs(good), 1e-3 * size)) {
    const double middle = (good + bad) / 2;
    (accepts(middle) ? good : bad) = middle;
  }
  if (std::abs(bad) < 1e-5 * size) return 0;
  const double digits = std::pow(10, 5 - std::floor(std::log10(std::abs(bad))));
  return std::round(bad * digits) / digits;
}

}  // namespace

std::vector<ParameterRange> RangesOf(const ParameterSource& parameter, Context& context) {
  using Clock = std::chrono::steady_clock;
  constexpr auto kLongest = std::chrono::milliseconds(1);
  const std::vector<double> present = context.EvalDoubles(parameter);
  const std::vector<Element> elements = context.Elements(parameter);
  std::vector<ParameterRange> ranges(present.size());
  std::vector<double> values = present;
  for (std::size_t i = 0; i < present.size(); ++i) {
    if (!elements[i].is_real || !std::isfinite(present[i])) continue;
    const auto accepts = [&](double value) {
      values[i] = value;
      try {
        context.SetDoubles(parameter, values);
        return true;
      } catch (const Error&) {
        return false;
      }
    };
    const auto begin = Clock::now();
    if (!accepts(present[i])) continue;
    if (Clock::now() - begin > kLongest) break;
    ranges[i] = {Bound(present[i], -1, accepts), Bound(present[i], 1, accepts)};
    values[i] = present[i];
  }
  context.SetDoubles(parameter, present);
  return ranges;
}

}  // namespace tenon::internal
