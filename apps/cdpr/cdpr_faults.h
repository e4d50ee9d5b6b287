#pragma once

#include <tenon/apps/common/faults.h>
#include <tenon/diagrams/cdpr/cdpr_loop.h>

#include <array>
#include <vector>

namespace tenon::apps {

/// Where a cable robot can fail.
enum class CdprFaultPlace {
  kCommand,    ///< of the controller to the winches [N], one element per cable
  kWinch,      ///< the winches themselves: stuck
  kCable,      ///< the cables: broken
  kLengths,    ///< CableSignals, to the PD and to what estimates pose, load and broken cables
  kReference,  ///< CdprReference, to the PD
  kPose,       ///< PoseMeasurement, to the estimator
  kImu,        ///< ImuMeasurement, to the estimators
  kEstimate,   ///< PlatformEstimate, to the MPC and to what estimates the load
};
constexpr auto EnumNames(CdprFaultPlace) {
  using enum CdprFaultPlace;
  return std::array{Named{kCommand, "command"}, Named{kWinch, "winch"},         Named{kCable, "cable"},
                    Named{kLengths, "lengths"}, Named{kReference, "reference"}, Named{kPose, "pose"},
                    Named{kImu, "imu"},         Named{kEstimate, "estimate"}};
}
using CdprFault = FaultScenario<CdprFaultPlace>;

/// Puts faults into a diagram, before it is built, and returns what to log of them. Throws ParameterError
/// with the key of a fault that is not possible there.
std::vector<const Source*> InsertFaults(DiagramBuilder& builder, CdprLoop& loop,
                                        const std::vector<CdprFault>& faults);

}  // namespace tenon::apps
