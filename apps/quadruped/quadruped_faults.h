#pragma once

#include <tenon/apps/common/faults.h>
#include <tenon/diagrams/guide_dog/guide_dog.h>
#include <tenon/diagrams/legged/quadruped_stand.h>
#include <tenon/diagrams/legged/quadruped_walk.h>

#include <array>
#include <vector>

namespace tenon::apps {

/// Where a quadruped can fail.
enum class LeggedFaultPlace {
  kTorque,        ///< the controller's command to the drives [N m], one element per joint
  kJoint,         ///< the joints themselves: stuck, or broken, whose drive gives no torque
  kEncoders,      ///< JointMotion, to the controller that stands or the state estimator
  kTorqueSensor,  ///< [N m], to whatever estimates forces
  kFootForce,     ///< FootForces, to controller and observers, if the feet have sensors
  kImu,           ///< ImuMeasurement, to observers and the state estimator
  kState,         ///< LeggedState, as controller and observers are told it
  kWrench,        ///< WrenchEstimate of the observers, to the controller
  kObstacle,      ///< whether the guide dog sees an obstacle
};
constexpr auto EnumNames(LeggedFaultPlace) {
  using enum LeggedFaultPlace;
  return std::array{Named{kTorque, "torque"},        Named{kJoint, "joint"},
                    Named{kEncoders, "encoders"},    Named{kTorqueSensor, "torque_sensor"},
                    Named{kFootForce, "foot_force"}, Named{kImu, "imu"},
                    Named{kState, "state"},          Named{kWrench, "wrench"},
                    Named{kObstacle, "obstacle"}};
}
using LeggedFault = FaultScenario<LeggedFaultPlace>;

/// Puts faults into a diagram, before it is built, and returns what to log of them. Throw ParameterError with
/// the key of a fault that is not possible there.
std::vector<const Source*> InsertFaults(DiagramBuilder& builder, QuadrupedStand& loop,
                                        const std::vector<LeggedFault>& faults);
std::vector<const Source*> InsertFaults(DiagramBuilder& builder, QuadrupedWalk& loop,
                                        const std::vector<LeggedFault>& faults);
std::vector<const Source*> InsertFaults(DiagramBuilder& builder, GuideDog& loop,
                                        const std::vector<LeggedFault>& faults);

}  // namespace tenon::apps
