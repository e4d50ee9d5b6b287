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
  std::optional<LeggedStateEstimatorParams> estimator;  ///< empty: the controller reads the true state
};

/// Parameters of a walk in `world` whose controller and observers have a `model` of the robot, which may
/// differ from the true one. The path of the walk is empty: set QuadrupedWalkParams::walk.
QuadrupedWalkParams MakeQuadrupedWalk(const QuadrupedWorldParams& world, const QuadrupedDescription& model,
                                      const LocomotionProfile& profile, const FootSchedulerParams& gaits);
/// Parameters of a walk on level ground, from rest in the nominal stance and without disturbances, with the
/// standard profile and gaits. The controller and the observers have the true model of the robot. The path of
/// the walk is empty: set QuadrupedWalkParams::walk. Throws ParameterError.
QuadrupedWalkParams MakeQuadrupedWalk(const QuadrupedDescription& robot);

/// A quadruped that walks a commanded path on its terrain (Morlando 2023, section 2.5).
///
///     walk ──► locomotion ──► world ──┬─► IMU, torque ──┐
///                ▲   ▲                │                 ▼
///                │   └────────────────┴─ state ─────► observer
///                └── wrench, forces on the legs ────────┘
///
/// The foot forces reach locomotion and observer too. With an estimator, both read the state that it computes
/// from inertial unit, encoders and contact schedule; without one, they read the true state. The observer
/// reads the estimated ground plane of the last tick.
class QuadrupedWalk : public Subdiagram {
 public:
  explicit QuadrupedWalk(const QuadrupedWalkParams& params);

  WalkSchedule& walk;
  LeggedLocomotion& locomotion;
  QuadrupedWorld& world;
  DisturbanceObserver& observer;
  TrackingError& errors;
  WalkView& view;
  LeggedStateEstimator* estimator = nullptr;         ///< null without an estimator
  FootForceEstimate* foot_force_estimate = nullptr;  ///< null unless the foot sensors are in the shanks
  FootForcesOfLegs* foot_forces_of_legs = nullptr;   ///< null unless the feet have no sensors
  const OutputPort<LeggedState>& state;              ///< the state that the controller reads

 private:
  const OutputPort<LeggedState>& AddEstimator(const std::optional<LeggedStateEstimatorParams>& params);
  const OutputPort<FootForces>& AddFootForces(const QuadrupedWorldParams& params);
  void ConnectObserver(const OutputPort<FootForces>& foot_forces);
  void ConnectEvaluation();
};

}  // namespace tenon
