#pragma once

#include <tenon/controllers/legged/deployment/deployment.h>
#include <tenon/controllers/legged/observers/foot_force_estimate.h>
#include <tenon/controllers/legged/observers/legged_state_estimator.h>
#include <tenon/controllers/legged/planning/walk_schedule.h>
#include <tenon/controllers/legged/whole_body/rope_tensions.h>
#include <tenon/diagrams/legged/disturbance_observer.h>
#include <tenon/diagrams/legged/legged_locomotion.h>
#include <tenon/diagrams/legged/quadruped_world.h>
#include <tenon/plants/legged/joint_drives.h>
#include <tenon/plants/legged/ropes.h>
#include <tenon/plants/sensors/terrain_mapper.h>
#include <tenon/systems/primitives/unit_delay.h>

namespace tenon {

class FootForcesOfLegs;
class TrackingError;
class WalkView;

/// Ropes of a QuadrupedWalk, see AddRopes.
struct QuadrupedRopesParams {
  std::vector<Rope> ropes;
  CableVector initial_tension;  ///< [N]
  double winch_lag = 0.05;      ///< time constant of the tension's response to its command [s]
};

struct QuadrupedWalkParams {
  QuadrupedWorldParams world;
  WalkScheduleParams walk;
  LeggedLocomotionParams locomotion;
  DisturbanceObserverParams observer;
  std::optional<LeggedStateEstimatorParams> estimator;  ///< empty: the controller reads the true state
  TerrainMapperParams map;                     ///< elevation map, with LeggedLocomotionParams::mapped
  std::optional<QuadrupedRopesParams> ropes;   ///< empty: no ropes
  std::optional<DeploymentParams> deployment;  ///< supervisor between controller and drives; empty: none
  bool known_additions = false;          ///< the controller measures the wrench of additions to the robot
  double additions_lag = 0.003;          ///< time constant of this measurement [s]
  double additions_planning_lag = 0.25;  ///< further time constant of the part that the planners read [s]
};

/// Parameters of a walk in `world` whose controller and observers have a `model` of the robot, which may
/// differ from the true one. The path of the walk is empty: set QuadrupedWalkParams::walk.
QuadrupedWalkParams MakeQuadrupedWalk(const QuadrupedWorldParams& world, const QuadrupedDescription& model,
                                      const LocomotionProfile& profile, const FootSchedulerParams& gaits);
/// Parameters of a walk on level ground, from rest in the nominal stance and without disturbances, with the
/// standard profile and gaits. The controller and the observers have the true model of the robot. The path of
/// the walk is empty: set QuadrupedWalkParams::walk. Throws ParameterError.
QuadrupedWalkParams MakeQuadrupedWalk(const QuadrupedDescription& robot);

/// Adds ropes to the robot of `params`, which stands on a plane at the start. The ropes then carry the
/// weight's component along the slope, and the centre of the feet is below the CoM along the plane's normal.
/// If the robot starts with its feet at a `height` [m] above the plane, it hangs by the ropes. Throws
/// ParameterError.
void AddRopes(const std::vector<Rope>& ropes, QuadrupedWalkParams* params, double height = 0);

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
///
/// With ropes, `tensions` commands the `winches` of the `ropes`, which pull at world.pull, and locomotion and
/// observer know the wrench of the measured tensions. If a rope is lost, the robot stops and stands from then
/// on, since the others may not hold it while it steps.
///
/// With a `deployment`, the controller's torques pass this supervisor, whose commands the loops of the
/// `drives` follow, and the controller stands unless the supervisor lets it walk.
///
/// With `known_additions` the observer knows world.plant's `added_wrench`, sampled and behind a first-order
/// lag, as a force sensor without errors under the base of an arm measures it, and estimates the other
/// disturbances alone. The lag keeps the loop through the reaction of the arm to the acceleration of the
/// trunk stable. The whole-body controller balances the whole measurement; the planners of trunk and
/// footholds read it behind a further lag, about a step long. They must balance a heavy arm, but not its
/// reaction to the acceleration that they plan.
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
  HeldLag<Vec<6>>* known_additions = nullptr;        ///< their force and torque; null unless known
  TerrainMapper* map = nullptr;                      ///< null without a map
  RopeTensions* tensions = nullptr;                  ///< null without ropes
  HeldLag<CableVector>* winches = nullptr;           ///< null without ropes
  Ropes* ropes = nullptr;                            ///< null without ropes
  Deployment* deployment = nullptr;                  ///< null without a supervisor
  const OutputPort<double>* heartbeat = nullptr;     ///< time of the last state, to `deployment` [s]
  JointDrives* drives = nullptr;                     ///< null without a supervisor
  const OutputPort<LeggedState>& state;              ///< the state that the controller reads

 private:
  const OutputPort<LeggedState>& AddEstimator(const std::optional<LeggedStateEstimatorParams>& params);
  const OutputPort<FootForces>& AddFootForces(const QuadrupedWorldParams& params);
  const OutputPort<WrenchEstimate>& AddRopes(const QuadrupedRopesParams& params,
                                             const OutputPort<WrenchEstimate>& external);
  const OutputPort<WalkCommand>& AddStop();
  const OutputPort<WalkCommand>& AddDeployment(const DeploymentParams& params,
                                               const OutputPort<WalkCommand>& command);
  void ConnectWrenches(const QuadrupedWalkParams& params);
  void ConnectObserver(const OutputPort<FootForces>& foot_forces);
  void ConnectEvaluation();
};

}  // namespace tenon
