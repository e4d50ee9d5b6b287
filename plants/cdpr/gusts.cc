#include <tenon/plants/cdpr/gusts.h>

#include <fmt/core.h>

#include <cmath>
#include <numbers>

namespace tenon {

void GustsParams::Validate() const {
  for (const Gust& gust : gusts) {
    Demand(gust.force_W.allFinite() && std::isfinite(gust.start), "a gust's force or start is not finite");
    Demand(std::isfinite(gust.duration) && gust.duration > 0,
           fmt::format("a gust's duration = {} s must be positive", gust.duration));
  }
}

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
