#pragma once

#include <tenon/controllers/legged/planning/com_planner.h>
#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/signals/disturbance_signals.h>

namespace tenon {

/// Plan of a ThesisPlanner, valid until the next one.
struct ThesisPlan {
  int footsteps = -1;     ///< the schedule's count of footsteps when it was made; -1: no plan yet
  bool swing = false;     ///< whether it is the plan of the swing of this step
  double step_start = 0;  ///< start of the step [s]
  PlanarPath path;        ///< commanded path at the start of the step
  double start = 0;       ///< time when it was made [s]
  PlanarSpline spline;    ///< horizontal motion of the CoM; rests at its end
  double duration = 0;    ///< of the cubics of height and attitude; they rest at their end [s]
  std::array<Vec<4>, 4> cubic{Vec<4>::Zero(), Vec<4>::Zero(), Vec<4>::Zero(), Vec<4>::Zero()};
  ///< coefficients of t^0 ... t^3 of the height [m] and of roll, pitch and yaw [rad]
  ComDiagnostics diagnostics;

  static FieldList Fields() {
    return {{"footsteps", &ThesisPlan::footsteps},        {"swing", &ThesisPlan::swing},
            {"step_start", &ThesisPlan::step_start, "s"}, {"path", &ThesisPlan::path},
            {"start", &ThesisPlan::start, "s"},           {"spline", &ThesisPlan::spline},
            {"duration", &ThesisPlan::duration, "s"},     {"cubic", &ThesisPlan::cubic},
            {"diagnostics", &ThesisPlan::diagnostics}};
  }
};

/// The motion planner of Morlando 2023, section 2.4.1, as its text describes it, in the place of a
/// ComPlanner. Every plan begins at the measured position, velocity and acceleration of the CoM and at the
/// measured attitude, and ends at rest.
///
/// **Stance.** When a step begins, all feet stand. A cubic in time moves the CoM to the centre of their
/// support polygon, at rest, at the end of the stance. **Swing.** When the feet lift off, a spline of cubics
/// (ZmpSpline) is planned over the next `horizon` steps and the stance that follows. It minimises the
/// deviation from a regularised path p(t), the polynomial of degree five that begins at the measured motion
/// and ends at rest at the centre of the last support polygon, so that the ZMP, (2.4) and (2.5), stays in the
/// polygons; two stance feet span a rectangle. If no spline does, the plan is p(t) itself, and the failure is
/// counted. The measured acceleration was that of a robot on four feet: if its ZMP is outside of the support
/// of the swing, the spline begins with the acceleration of the nearest ZMP inside, without which hardly any
/// swing has a solution. **Height and attitude** follow a cubic in each phase to the nominal height above the
/// ground and to the commanded attitude, at rest.
///
/// **Heuristic crawl.** With ComReference::kHeuristic, for comparison, the CoM moves as Focchi et al. plan it
/// (Heuristic planning for rough terrain locomotion in presence of external disturbances and variable
/// perception quality, Springer Tracts in Advanced Robotics 132, 2020): in each stance by a polynomial of
/// degree five to the centre of the feet that stay in the swing that follows, where it rests until the next
/// stance. The estimated wrench (f, t) displaces the centre by -(h f_x + t_y, h f_y - t_x) / (m g - f_z), so
/// that the ZMP of the resting robot is there. Gaits need a stance that is long enough for this motion.
///
/// The measured acceleration is (sum of the foot forces + external force) / m - g. The polygons are those of
/// the footholds below the commanded path, which is integrated from the commanded velocities and never reset.
/// In contrast to ComPlanner's, the reference is reset to the robot at every plan: errors against it hide the
/// deviation from the commanded path, which must be judged by `path`.
class ThesisPlanner final : public LeafSystem<ComPlannerParams> {
 public:
  using LeafSystem::LeafSystem;
  const NominalStance stance{params.robot};

  InputPort<ContactSchedule> schedule{this, {"schedule"}};
  InputPort<WalkCommand> command{this, {"command"}};
  InputPort<GroundPlane> ground{this, {"ground"}};
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<FootForces> foot_forces{this, {"foot_forces"}};
  InputPort<WrenchEstimate> wrench{this, {"wrench"}, WrenchEstimate()};
  Parameter<ZmpPlanParams> zmp{this, {"zmp"}, params.zmp, "planning of the CoM spline in swings"};
  Parameter<double> blend{
      this, {"blend", "s"}, params.blend, "duration of the motion into a stand", Range().Positive()};
  Scratch<ThesisPlan> memory{this, "memory", ThesisPlan()};
  Workspace<ZmpSpline> optimizer{this, "optimizer"};

 private:
  Shared<QuadrupedDynamics> dynamics_{this, "dynamics", Uses(state), QuadrupedModel(params.robot)};

 public:
  OutputPort<ThesisPlan> plan{this,
                              {"plan"},
                              Sampled{params.rate},
                              Uses(time, schedule, command, ground, state, dynamics_, foot_forces, wrench,
                                   zmp, blend, memory, optimizer),
                              &ThesisPlanner::CalcPlan};
  OutputPort<BodyReference> reference{
      this, {"reference"}, Sampled{params.rate}, Uses(time, plan), &ThesisPlanner::CalcReference};
  OutputPort<PlanarPath> path{
      this, {"path"}, Sampled{params.rate}, Uses(time, plan), [](double now, const ThesisPlan& plan_now) {
        return plan_now.path.At(now - plan_now.step_start);
      }};
  OutputPort<ComDiagnostics> diagnostics{
      this, {"diagnostics"}, Uses(plan), [](const ThesisPlan& plan_now) { return plan_now.diagnostics; }};

 private:
  void CalcPlan(double now, const ContactSchedule& schedule, const WalkCommand& command,
                const GroundPlane& ground, const LeggedState& state, const QuadrupedDynamics& dynamics,
                const FootForces& foot_forces, const WrenchEstimate& wrench, const ZmpPlanParams& zmp,
                double blend, ThesisPlan& memory, ZmpSpline& optimizer, ThesisPlan* plan) const;
  BodyReference CalcReference(double now, const ThesisPlan& plan) const;

  void PlanSwing(const ContactSchedule& schedule, const Vec<2>& slope, const PlanarPoint& begin,
                 double height, const ZmpPlanParams& zmp, ZmpSpline& optimizer, ThesisPlan* plan) const;
  const double mass_ = params.robot.mass();
};

/// The polynomial of degree five from `begin` to `end` within `duration` [s].
PlanarSpline QuinticBetween(const PlanarPoint& begin, const PlanarPoint& end, double duration);
/// The cubic from the position and velocity of `begin` to rest at `end` [m] within `duration` [s].
PlanarSpline CubicToRest(const PlanarPoint& begin, const Vec<2>& end, double duration);

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::ThesisPlan);
