#pragma once

#include <tenon/diagrams/faults/faults.h>

namespace tenon {

class CdprLoop;

/// A place where a cable robot can fail.
enum class CdprFaultPlace {
  kCommand,    ///< command of the controller to the winches [N], one element per cable
  kWinch,      ///< the winches themselves: stuck
  kCable,      ///< the cables: broken
  kLengths,    ///< CableSignals, to the PD controller and the estimators of pose, load and broken cables
  kReference,  ///< CdprReference, to the PD controller
  kPose,       ///< PoseMeasurement, to the estimator
  kImu,        ///< ImuMeasurement, to the estimators
  kEstimate,   ///< PlatformEstimate, to the MPC and the load estimator
};
using CdprFault = FaultAt<CdprFaultPlace>;

/// Adds faults to a diagram before it is built. Returns the signals of the faults to log. Throws FaultError
/// for a fault that is not possible in this diagram, and ParameterError for too many faults.
std::vector<const Source*> InsertFaults(DiagramBuilder& builder, CdprLoop& loop,
                                        const std::vector<CdprFault>& faults);

}  // namespace tenon
