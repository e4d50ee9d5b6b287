#include <tenon/plants/cdpr/gusts.h>

#include <fmt/core.h>

#include <numbers>

namespace tenon {

PlatformWrench Gusts::CalcWrench(double time) const {
  PlatformWrench wrench;
  for (const Gust& gust : params.gusts) {
    const double phase = (time - gust.start) / gust.duration;
    if (phase >= 0 && phase < 1)
      wrench.force_W += (1 - std::cos(2 * std::numbers::pi * phase)) / 2 * gust.force_W;
  }
  return wrench;
}

}  // namespace tenon
