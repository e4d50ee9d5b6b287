#pragma once

#include <tenon/apps/common/faults.h>
#include <tenon/diagrams/cdpr/cdpr_loop.h>

#include <array>
#include <vector>

namespace tenon::apps {

/// Places of faults in a cable robot's loop.
enum class CdprFaultPlace {
  kCommand,    ///< command to the winches [N], one element per cable
  kWinch,      ///< the winches themselves: stuck
  kCable,      ///< the cables: broken
  kLengths,    ///< CableSignals, to the PD and to the observers
  kReference,  ///< CdprReference, to the PD
  kPose,       ///< PoseMeasurement, to the estimator
  kImu,        ///< ImuMeasurement, to the estimators
  kEstimate,   ///< PlatformEstimate, to the MPC and to the load estimator
};
constexpr auto EnumNames(CdprFaultPlace) {
  using enum CdprFaultPlace;
  return std::array{Named{kCommand, "command"}, Named{kWinch, "winch"},         Named{kCable, "cable"},
                    Named{kLengths, "lengths"}, Named{kReference, "reference"}, Named{kPose, "pose"},
                    Named{kImu, "imu"},         Named{kEstimate, "estimate"}};
}
using CdprFault = FaultScenario<CdprFaultPlace>;

/// Inserts faults into a diagram that is not built yet, and returns the signals of theirs to log. Throws
/// ParameterError with the key of a fault that is not possible at its place.
std::vector<const Source*> InsertFaults(DiagramBuilder& builder, CdprLoop& loop,
                                        const std::vector<CdprFault>& faults);

}  // namespace tenon::apps
