#pragma once

#include <tenon/controllers/legged/planning/com_plan.h>
#include <tenon/controllers/legged/planning/nominal_stance.h>
#include <tenon/controllers/legged/planning/zmp_spline.h>
#include <tenon/plants/model/gravity.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/plants/signals/ground_plane.h>
#include <tenon/plants/signals/motion_signals.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

#include <array>
#include <utility>

namespace tenon {

/// How the CoM goes over ground in a walk.
enum class ComReference {
  kPendulum,   ///< the periodic motion of the linear inverted pendulum, in closed form
  kZmpSpline,  ///< an optimised spline whose ZMP stays in the support polygons
};
constexpr auto EnumNames(ComReference) {
  return std::array{Named{ComReference::kPendulum, "pendulum"},
                    Named{ComReference::kZmpSpline, "zmp_spline"}};
}

/// Lengths as in SupportPolygon; choices for feet of 0.03 m and steps of 0.25 s.
struct ZmpPlanParams {
  int horizon = 2;           ///< steps that are planned ahead, at most 4
  double half_width = 0.03;  ///< of the line between two feet [m]
  double margin = 0.01;      ///< of the ZMP to the edges of the support [m]
  ZmpSplineParams spline;

  static FieldList Fields() {
    return {{"horizon_steps", &ZmpPlanParams::horizon},
            {"half_width_m", &ZmpPlanParams::half_width},
            {"margin_m", &ZmpPlanParams::margin},
            {"spline", &ZmpPlanParams::spline}};
  }
  void Validate() const;  ///< throws ParameterError
};

struct ComPlannerParams {
  QuadrupedDescription robot;
  ComReference reference = ComReference::kPendulum;
  ZmpPlanParams zmp;                       ///< of kZmpSpline
  Vec<2> start_position = Vec<2>::Zero();  ///< of B at the beginning [m]
  double start_yaw = 0;                    ///< [rad]
  double blend = 0.5;         ///< time of going over to a new plan: about a cycle of the trot [s]
  double gravity = kGravity;  ///< [m/s^2]
  Rate rate = Hz(1000);
  void Validate() const;  ///< throws ParameterError
};

/// Plans CoM and trunk (Morlando 2023, section 2.4.1), replanning whenever the schedule counts a footstep.
///
///     ports in   schedule     which feet stand and when they will swing
///                command      velocities; the gait is the scheduler's
///                ground       below the robot
///     parameters zmp          ZmpPlanParams, from the next plan on
///                blend        [s], from the next plan on
///     ports out  plan         sampled
///                reference    CoM position, velocity, acceleration; attitude with its rates; sampled
///                path         the commanded path and its twist, for the footholds; sampled
///                diagnostics  of the optimisation
///
/// The commanded path goes on from where the last plan has brought it, with the velocities commanded at the
/// footstep. Along it the feet are planted so that each is at its nominal place below the robot in the middle
/// of its stance. The CoM is at the nominal height h above the ground, straight up, and moves over it as the
/// linear inverted pendulum x'' = (g / h) (x - p) of which p is the centre of the feet that stand in each
/// phase: of all its motions the one that repeats itself from cycle to cycle (PeriodicPendulum). So the ZMP,
/// (2.4) and (2.5) with L' = 0, stays in the middle of the support polygon, on a slope too: there (g + z'')
/// (x - p) = x'' (z - z_p) with z - z_p = h + s (x - p) and z'' = s x'' is the same pendulum. Or else the CoM
/// moves on a spline (see ZmpSpline) from where the reference has brought it, acceleration included, over the
/// phases of the next `horizon` steps and the stance that follows, and ends on the path, with its velocity.
/// If no spline keeps the ZMP in the polygons, the old plan goes on, its path too, until the next footstep: a
/// failure, which is counted. Standing, the CoM rests over the path. The commanded height is added at every
/// tick; a spline's ZMP is that of the height commanded when it was made. The trunk is parallel to the ground
/// and heads along the path.
///
/// Position, velocity, attitude and its rate do not jump at a new plan: what the old one said differently is
/// taken over as a cubic in time that fades within `blend`. A plan that repeats the old one changes nothing.
/// The reference is never restarted at the actual state, or the tracking error would hide itself. A plan is a
/// function of the time, and so goes on through a wait of the gait clock for a late foot.
class ComPlanner final : public LeafSystem<ComPlannerParams> {
 public:
  using LeafSystem::LeafSystem;
  const NominalStance stance{params.robot};

  InputPort<ContactSchedule> schedule{this, {"schedule"}};
  InputPort<WalkCommand> command{this, {"command"}};
  InputPort<GroundPlane> ground{this, {"ground"}};
  Parameter<ZmpPlanParams> zmp{
      this, {"zmp"}, params.zmp, "how a spline is planned, if that is the reference"};
  Parameter<double> blend{this, {"blend", "s"}, params.blend, "time of going over to a new plan"};
  Scratch<ComPlan> memory{this, "memory", ComPlan()};
  Workspace<ZmpSpline> optimizer{this, "optimizer"};
  OutputPort<ComPlan> plan{this,
                           {"plan"},
                           Sampled{params.rate},
                           Uses(time, schedule, command, ground, zmp, blend, memory, optimizer),
                           &ComPlanner::CalcPlan};
  OutputPort<BodyReference> reference{
      this, {"reference"}, Sampled{params.rate}, Uses(time, plan, command), &ComPlanner::CalcReference};
  OutputPort<PlanarPath> path{this, {"path"}, Sampled{params.rate}, Uses(time, plan), &ComPlanner::CalcPath};
  OutputPort<ComDiagnostics> diagnostics{
      this, {"diagnostics"}, Uses(plan), [](const ComPlan& plan) { return plan.diagnostics; }};

 private:
  void CalcPlan(const double& time, const ContactSchedule& schedule, const WalkCommand& command,
                const GroundPlane& ground, const ZmpPlanParams& zmp, double blend, ComPlan& memory,
                ZmpSpline& optimizer, ComPlan* plan) const;
  BodyReference CalcReference(const double& time, const ComPlan& plan, const WalkCommand& command) const;
  PlanarPath CalcPath(const double& time, const ComPlan& plan) const;

  ComPlan FirstPlan(double time, const GroundPlane& ground) const;
  void PlanPendulum(const ContactSchedule& schedule, ComPlan* plan) const;
  bool PlanSpline(const ContactSchedule& schedule, const PlanarPoint& begin, double raised,
                  const ZmpPlanParams& zmp, ZmpSpline& optimizer, ComPlan* plan) const;
};

}  // namespace tenon
