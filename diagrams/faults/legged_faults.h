#pragma once

#include <tenon/diagrams/faults/faults.h>

namespace tenon {

class GuideDog;
class QuadrupedStand;
class QuadrupedWalk;

/// A place where a quadruped can fail.
enum class LeggedFaultPlace {
  kTorque,        ///< command of the controller to the drives [N m], one element per joint
  kJoint,         ///< the joints themselves: stuck, or broken, then the drive gives no torque
  kEncoders,      ///< JointMotion, to the PD controller or the state estimator
  kTorqueSensor,  ///< [N m], to all blocks that estimate forces
  kFootForce,     ///< FootForces, to controller and observers, if the feet have sensors
  kImu,           ///< ImuMeasurement, to the observers or the state estimator
  kState,         ///< LeggedState that the controller and the observers read
  kWrench,        ///< WrenchEstimate of the observers, to the controller
  kRope,          ///< the ropes: broken
  kLink,          ///< time of the last state from the robot, to the supervisor of a walk [s]
  kObstacle,      ///< output of the guide dog's obstacle detector
};
using LeggedFault = FaultAt<LeggedFaultPlace>;

/// Adds faults to a diagram before it is built. Returns the signals of the faults to log. Throws FaultError
/// for a fault that is not possible in this diagram, and ParameterError for too many faults.
std::vector<const Source*> InsertFaults(DiagramBuilder& builder, QuadrupedStand& loop,
                                        const std::vector<LeggedFault>& faults);
std::vector<const Source*> InsertFaults(DiagramBuilder& builder, QuadrupedWalk& loop,
                                        const std::vector<LeggedFault>& faults);
std::vector<const Source*> InsertFaults(DiagramBuilder& builder, GuideDog& loop,
                                        const std::vector<LeggedFault>& faults);

}  // namespace tenon
