#include <tenon/plants/legged/fall_monitor.h>

#include <fmt/core.h>

namespace tenon {

void FallMonitorParams::Validate() const {
  terrain.Validate();
  Demand(max_height > min_height,
         fmt::format("max_height = {} must be above min_height = {}: give metres", max_height, min_height));
}

Verdict FallMonitor::CheckFall(const LeggedState& x, double min_height, double max_tilt) const {
  const double height = Height(x);
  if (height < min_height)
    return fmt::format("the robot fell: its trunk is {:.3f} m above the ground; the limit is {:.3f} m",
                       height, min_height);
  const double tilt = std::acos(std::clamp(x.R_WB()(2, 2), -1.0, 1.0));
  if (tilt > max_tilt)
    return fmt::format("the robot fell: its trunk is tilted by {:.3f} rad; the limit is {:.3f} rad", tilt,
                       max_tilt);
  return {};
}

Verdict FallMonitor::CheckFlight(const LeggedState& x, double max_height) const {
  const double height = Height(x);
  if (height <= max_height) return {};
  return fmt::format("the robot left the ground: its trunk is {:.3f} m above it; the limit is {:.3f} m",
                     height, max_height);
}

}  // namespace tenon
