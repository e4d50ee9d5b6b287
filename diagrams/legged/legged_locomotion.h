#pragma once

#include <tenon/controllers/legged/observers/mapped_ground.h>
#include <tenon/diagrams/legged/locomotion_profile.h>
#include <tenon/systems/framework/diagram/diagram_builder.h>

namespace tenon {

class TrajectoryPlanner;

/// A quadruped's walking controller (Morlando 2023, figure 2.2), from a command to joint torques.
///
///     command ──► scheduler ──► com_planner ─┬► swing_planner ──► whole_body ──► torque
///                    ▲               ▲       └► trunk_planner ───────▲
///     foot_forces ───┘     ground_estimator          ▲               │
///     state ────────────────────▲────────────────────┼───────────────┤
///     wrench, leg_forces (disturbances) ─────────────┴───────────────┘
///
/// Connections that the sketch leaves out: a StepTimingAdapter reads `state` and the CoM planner's reference
/// and sets the clock of scheduler and swing planner at the next tick; the schedule feeds all other blocks;
/// `state` and `wrench` feed swing and trunk planner; the estimated ground feeds swing planner and whole-body
/// controller; `foot_forces` feed the swing planner. `wrench` and `leg_forces` are estimates of an observer;
/// if they are not connected, no disturbance is compensated. A `known_wrench`, such as that of ropes, adds to
/// `wrench` in the whole-body controller; `steady_wrench`, the part of it that changes slowly, displaces the
/// swing planner's footholds. With LeggedLocomotionParams::pace, a Pacer adapts `command` and the timing of
/// the scheduler to the speed, and no foot lands early. With ComReference::kThesis and kHeuristic, a
/// ThesisPlanner takes the place of the CoM planner. With ComReference::kTrajectory, a TrajectoryPlanner
/// follows the CoM planner, whose reference it replaces, gives the swing planner its footholds and reads
/// `map`, if any; the CoM planner then reads the estimated ground. With LeggedLocomotionParams::mpc, a
/// CentroidalMpc takes the place of the trunk planner and gives the swing planner its footholds. With
/// LeggedLocomotionParams::mapped, the swing planner reads `map`, and the plane of the planners is that of a
/// MappedGround instead of the estimated one. Each block can be replaced by one with the same ports.
class LeggedLocomotion final : public Subdiagram {
 public:
  explicit LeggedLocomotion(const LeggedLocomotionParams& params);

  InputPort<WalkCommand> command{this, {"command"}};
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<FootForces> foot_forces{this, {"foot_forces"}};
  InputPort<WrenchEstimate> wrench{this, {"wrench"}, WrenchEstimate()};
  InputPort<WrenchEstimate> known_wrench{this, {"known_wrench"}, WrenchEstimate()};
  InputPort<WrenchEstimate> steady_wrench{this, {"steady_wrench"}, WrenchEstimate()};
  InputPort<LegForceEstimate> leg_forces{this, {"leg_forces"}, LegForceEstimate()};

  InputPort<ElevationMap> map{this, {"map"}, ElevationMap()};

  Pacer* pacer = nullptr;          ///< between `command` and all blocks that read it; null without `pace`
  StepTimingAdapter& step_timing;  ///< to the next tick of scheduler and swing planner
  FootScheduler& scheduler;
  GroundEstimator& ground_estimator;
  MappedGround* mapped_ground = nullptr;  ///< null without LeggedLocomotionParams::mapped
  ComPlanner& com_planner;
  TrajectoryPlanner* trajectory_planner = nullptr;  ///< null without ComReference::kTrajectory
  SwingPlanner& swing_planner;
  TrunkPlanner* trunk_planner = nullptr;        ///< null with `mpc`
  CentroidalMpc* mpc = nullptr;                 ///< null without LeggedLocomotionParams::mpc
  const OutputPort<double>* mpc_age = nullptr;  ///< age of its plan [s]; null if plans are there at once
  WholeBodyController& whole_body;

  OutputPort<Vec<12>> torque{this, {"torque", "N m", kJointElements}};
  OutputPort<ContactSchedule> schedule{this, {"schedule"}};
  OutputPort<BodyReference> body{this, {"body"}};
  OutputPort<FeetReference> feet{this, {"feet"}};
  OutputPort<WholeBodyPlan> plan{this, {"plan"}};
  OutputPort<GroundPlane> ground{this, {"ground"}};

 private:
  const OutputPort<GroundPlane>& AddMap(const LeggedLocomotionParams& params);
  const OutputPort<BodyReference>& AddTrajectory(const LeggedLocomotionParams& params);
  void AddMpc(const LeggedLocomotionParams& params, const OutputPort<GroundPlane>& planned_ground);
};

}  // namespace tenon
