#include <tenon/plants/cdpr/cdpr_multibody.h>
#include <tenon/plants/cdpr/extended_platform.h>

namespace tenon {

ExtendedRobot ExtendedPlatform(const CdprDescription& robot, double gravity, const ExtendCdpr& extend,
                               const PlatformState& initial) {
  if (!extend) return {};
  return ExtendedRobot([robot, gravity] { return std::make_unique<CdprMultibody>(robot, gravity); },
                       [extend](RobotMultibody& robot) { extend(static_cast<CdprMultibody&>(robot)); }, 0,
                       {initial});
}

}  // namespace tenon
