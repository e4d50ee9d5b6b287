#pragma once

#include <tenon/controllers/legged/planning/com_plan.h>
#include <tenon/controllers/legged/planning/nominal_stance.h>
#include <tenon/controllers/legged/planning/zmp_spline.h>
#include <tenon/plants/signals/gait_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// Horizontal motion of the CoM in a walk.
enum class ComReference {
  kPendulum,    ///< the periodic motion of the linear inverted pendulum, in closed form
  kZmpSpline,   ///< an optimised spline whose ZMP stays in the support polygons
  kThesis,      ///< plans from the measured motion to rest, see ThesisPlanner
  kHeuristic,   ///< rests above the feet that stay in each swing, see ThesisPlanner
  kTrajectory,  ///< optimised together with the footholds, see TrajectoryPlanner; `pendulum` in a ComPlanner
};

/// Parameters of ComReference::kZmpSpline; the defaults are chosen for feet of 0.03 m and steps of 0.25 s.
struct ZmpPlanParams {
  int horizon = 2;           ///< number of planned steps, 1 to 4
  double half_width = 0.03;  ///< half width of the support of two feet, see SupportPolygon [m]
  double margin = 0.01;      ///< distance of the ZMP from the edges of the support [m]
  ZmpSplineParams spline{};

  static FieldList Fields() {
    return {Field("horizon_steps", &ZmpPlanParams::horizon).Between(1, (ZmpSpline::kMaxPhases - 1) / 2),
            Field("half_width_m", &ZmpPlanParams::half_width).Positive(),
            Field("margin_m", &ZmpPlanParams::margin).AtLeast(0),
            {"spline", &ZmpPlanParams::spline}};
  }
};

/// Parameters of ComReference::kTrajectory, see TrajectoryPlanner. Weights are those of squares in the units
/// of TrajectoryProblem, over that of the acceleration.
struct TrajectoryProperties {
  int steps = 4;               ///< number of planned steps; at least those of the gait's cycle
  int parts_per_swing = 3;     ///< parts of a swing between its knots
  int max_evaluations = 200;   ///< largest number of evaluations in a solve
  double least_load = 0.05;    ///< least load of a foot that carries, about its share of the weight
  double search = 0.4;         ///< largest distance of a foothold from its nominal place, along x and y [m]
  double climb = 0.2;          ///< largest difference in height of successive footholds of a leg [m]
  double position_weight = 1;  ///< weight of the horizontal distance of the CoM from the path
  double height_weight = 30;   ///< weight of the error of the CoM's height
  double load_weight = 1;      ///< weight of the difference of a foot's load from an equal share
  double foothold_weight = 1;  ///< weight of the displacement of a foothold
  double final_weight = 10;    ///< weight of the final error of position plus velocity

  static FieldList Fields() {
    using T = TrajectoryProperties;
    return {Field("horizon_steps", &T::steps).Between(1, 6),
            Field("parts_per_swing", &T::parts_per_swing).Between(1, 5),
            Field("max_evaluations", &T::max_evaluations).AtLeast(1),
            Field("least_load", &T::least_load).AtLeast(0).Below(0.25).Because("four feet carry the weight"),
            Field("search_m", &T::search).Between(0, 0.5),
            Field("climb_m", &T::climb).Positive(),
            Field("position_weight", &T::position_weight).AtLeast(0),
            Field("height_weight", &T::height_weight).AtLeast(0),
            Field("load_weight", &T::load_weight).Positive(),
            Field("foothold_weight", &T::foothold_weight).Positive(),
            Field("final_weight", &T::final_weight).AtLeast(0)};
  }
};

struct ComPlannerParams {
  QuadrupedDescription robot;
  ComReference reference = ComReference::kPendulum;
  ZmpPlanParams zmp;                       ///< parameters of kZmpSpline
  TrajectoryProperties trajectory;         ///< parameters of kTrajectory
  Vec<2> start_position = Vec<2>::Zero();  ///< initial position of B [m]
  double start_yaw = 0;                    ///< initial heading [rad]
  double blend = 0.5;         ///< duration of the transition to a new plan, about a cycle of the trot [s]
  double gravity = kGravity;  ///< [m/s^2]
  Rate rate = Hz(1000);
  void Validate() const { CheckGravity(gravity); }  ///< throws ParameterError
};

/// Plans the motion of CoM and trunk (Morlando 2023, section 2.4.1), anew at each footstep of the schedule.
/// The gait of `command` is not used, and a change of a parameter takes effect with the next plan.
///
/// **Path.** At each footstep the commanded path is continued from its present point with the commanded
/// velocities. Footholds are planned at the nominal place below the robot in the middle of each stance.
///
/// **CoM.** The CoM is at the nominal height h above the ground. Its horizontal motion is that of the linear
/// inverted pendulum x'' = (g / h) (x - p), with p the centroid of the stance feet of each phase: the
/// solution that repeats from cycle to cycle (PeriodicPendulum). Thus the ZMP, (2.4) and (2.5) with L' = 0,
/// stays in the middle of the support polygon. On a slope s the pendulum is unchanged, since in (g + z'') (x
/// - p) = x'' (z - z_p), z - z_p = h + s (x - p) and z'' = s x''.
///
/// With ComReference::kZmpSpline the CoM follows a spline (see ZmpSpline) that starts at the present
/// reference, acceleration included, spans the phases of the next `horizon` steps and the stance that
/// follows, and ends on the path with its velocity. If no spline keeps the ZMP in the polygons, the previous
/// plan and its path stay until the next footstep, and the failure is counted.
///
/// When the robot stands, the CoM rests above the path. The commanded height is added at every tick; the ZMP
/// of a spline is computed with the height commanded when it was made. The trunk is parallel to the ground
/// and its heading follows the path.
///
/// **Transition.** Position, velocity, attitude and its rate are continuous at a new plan: their difference
/// to the previous plan decays as a cubic in time within `blend`. A plan equal to the previous one changes
/// nothing. The reference is never reset to the actual state, which would hide tracking errors. A plan
/// depends on time, so it continues while the gait clock waits for a late foot.
class ComPlanner final : public LeafSystem<ComPlannerParams> {
 public:
  using LeafSystem::LeafSystem;
  const NominalStance stance{params.robot};

  InputPort<ContactSchedule> schedule{this, {"schedule"}};
  InputPort<WalkCommand> command{this, {"command"}};
  InputPort<GroundPlane> ground{this, {"ground"}};
  Parameter<ZmpPlanParams> zmp{
      this, {"zmp"}, params.zmp, "planning of the CoM spline, for the reference zmp_spline"};
  Parameter<double> blend{
      this, {"blend", "s"}, params.blend, "duration of the transition to a new plan", Range().Positive()};
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
      this, {"diagnostics"}, Uses(plan), [](const ComPlan& plan_now) { return plan_now.diagnostics; }};

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
