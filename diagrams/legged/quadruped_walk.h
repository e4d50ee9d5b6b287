#pragma once

#include <tenon/controllers/legged/observers/foot_force_estimate.h>
#include <tenon/controllers/legged/observers/legged_state_estimator.h>
#include <tenon/controllers/legged/planning/walk_schedule.h>
#include <tenon/diagrams/legged/disturbance_observer.h>
#include <tenon/diagrams/legged/legged_locomotion.h>
#include <tenon/diagrams/legged/locomotion_profile.h>
#include <tenon/diagrams/legged/quadruped_world.h>

#include <optional>

namespace tenon {

class FootForcesOfLegs;
class TrackingError;
class WalkView;

struct QuadrupedWalkParams {
  QuadrupedWorldParams world;
  WalkScheduleParams walk;
  LeggedLocomotionParams locomotion;
  DisturbanceObserverParams observer;
  std::optional<LeggedStateEstimatorParams> estimator;  ///< without, the controller is told the true state
};

/// A walk in this world, of a robot whose controller and observers believe in `believed`; the walk's path is
/// left to give. The gaits are the standard ones, for the robot as it is.
QuadrupedWalkParams MakeQuadrupedWalk(const QuadrupedWorldParams& world, const LocomotionProfile& profile,
                                      const QuadrupedDescription& believed);
/// A robot on level ground, at rest in its nominal stance, whose controller and observers know its masses.
/// Left to give are the walk's path and the forces that disturb it.
QuadrupedWalkParams MakeQuadrupedWalk(const QuadrupedDescription& robot, const LocomotionProfile& profile);
/// With the standard profile for this robot.
QuadrupedWalkParams MakeQuadrupedWalk(const QuadrupedDescription& robot);

/// A quadruped that walks a commanded path on its terrain (Morlando 2023, section 2.5).
///
///     walk ──► locomotion ──► world ──┬─► IMU, torque ──┐
///                ▲   ▲                │                 ▼
///                │   └────────────────┴─ state ─────► observer
///                └── wrench, forces on the legs ────────┘
///
/// The foot forces go to locomotion and observer too. With an estimator, the state that both are told is the
/// one that it finds from IMU, encoders and the schedule; without, it is the true one.
class QuadrupedWalk final : public Subdiagram {
 public:
  explicit QuadrupedWalk(const QuadrupedWalkParams& params);

  WalkSchedule& walk;
  LeggedLocomotion& locomotion;
  QuadrupedWorld& world;
  DisturbanceObserver& observer;
  LeggedStateEstimator* estimator = nullptr;         ///< if there is one
  FootForceEstimate* foot_force_estimate = nullptr;  ///< if the sensors of the feet are in the shanks
  FootForcesOfLegs* foot_forces_of_legs = nullptr;   ///< if the feet have none
  TrackingError& errors;
  WalkView& view;
};

}  // namespace tenon
