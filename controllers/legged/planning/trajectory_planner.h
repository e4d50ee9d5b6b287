#pragma once

#include <tenon/controllers/legged/planning/foothold_plan.h>
#include <tenon/controllers/legged/planning/map_footholds.h>
#include <tenon/controllers/legged/planning/trajectory_problem.h>
#include <tenon/plants/signals/legged_signals.h>

namespace tenon {

struct TrajectoryPlannerParams {
  QuadrupedDescription robot;
  TrajectoryProperties trajectory{};
  MapFootholdProperties footing{};  ///< which ground counts as flat; its `search` is not used
  double friction = 0.6;            ///< friction coefficient of the planned forces
  double gravity = kGravity;        ///< [m/s^2]
  Rate rate = Hz(1000);
  void Validate() const { CheckRanges(trajectory, "trajectory"); }  ///< throws ParameterError
};

/// Plan of a TrajectoryPlanner.
struct TrajectoryPlan {
  static constexpr int kMaxSteps = 6, kMaxKnots = 2 + 6 * kMaxSteps;
  static constexpr int kMaxSize = (6 + kNumLegs) * kMaxKnots + 3 * kNumLegs * (kMaxSteps + 1);
  int footsteps = -1, first_step = 0;  ///< the schedule's count at the last event, and at the start
  double start = 0;                    ///< [s]
  int num_knots = 0;                   ///< in a stand two, of a cubic that leads from the last plan to `body`
  std::array<double, kMaxKnots> time{};  ///< of the knots [sqrt(h / g)]
  std::array<double, kMaxSize> u{};      ///< positions, accelerations, ..., see TrajectoryProblem
  FootholdPlan footholds;
  ComDiagnostics diagnostics;

  static FieldList Fields() {
    using P = TrajectoryPlan;
    return {{"footsteps", &P::footsteps}, {"first_step", &P::first_step},
            {"start", &P::start, "s"},    {"num_knots", &P::num_knots},
            {"time", &P::time},           {"u", &P::u},
            {"footholds", &P::footholds}, {"diagnostics", &P::diagnostics}};
  }
};

/// Plans the motion of the CoM and the footholds of a walk over the next `steps` steps by trajectory
/// optimization with NLopt (TrajectoryProblem), anew at each footstep.
///
/// `body` and `path` are those of a ComPlanner: attitude, commanded path, and the motion in a stand; squats
/// of a walk have no effect. `footholds` are those of each leg's next landing, for SwingPlanner.
///
/// Knots divide swings, and are where feet lift off and touch down. The CoM is wanted above the path, at the
/// nominal height over the footholds, and a landing below the path in the middle of the coming stance; with a
/// map, on the nearest flat ground at most `climb` above or below the leg's last foothold. A plan continues
/// the reference and starts from the last solution, a step later. If a solve fails, the last plan goes on.
/// Throws RunError if that one has no steps left, and for gaits with flight or of more steps than the
/// horizon.
class TrajectoryPlanner final : public LeafSystem<TrajectoryPlannerParams> {
 public:
  using LeafSystem::LeafSystem;
  const NominalStance stance{params.robot};

  InputPort<ContactSchedule> schedule{this, {"schedule"}};
  InputPort<BodyReference> body{this, {"body"}};
  InputPort<PlanarPath> path{this, {"path"}};
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<GroundPlane> ground{this, {"ground"}};
  InputPort<ElevationMap> map{this, {"map"}, ElevationMap()};
  Scratch<TrajectoryPlan> memory{this, "memory", TrajectoryPlan()};
  Workspace<TrajectoryProblem> problem{this, "problem"};
  OutputPort<TrajectoryPlan> plan{this,
                                  {"plan"},
                                  Sampled{params.rate},
                                  Uses(time, schedule, body, path, state, ground, map, memory, problem),
                                  &TrajectoryPlanner::CalcPlan};
  OutputPort<BodyReference> reference{
      this, {"reference"}, Sampled{params.rate}, Uses(time, plan, body), &TrajectoryPlanner::CalcReference};
  OutputPort<FootholdPlan> footholds{
      this, {"footholds"}, Uses(plan), [](const TrajectoryPlan& plan_now) { return plan_now.footholds; }};

 private:
  void CalcPlan(double now, const ContactSchedule& schedule, const BodyReference& body,
                const PlanarPath& path, const LeggedState& state, const GroundPlane& ground,
                const ElevationMap& map, TrajectoryPlan& memory, TrajectoryProblem& problem,
                TrajectoryPlan* plan) const;
  BodyReference CalcReference(double now, const TrajectoryPlan& plan, const BodyReference& body) const;
  std::string SetSteps(const ContactSchedule& schedule, const BodyReference& body, const PlanarPath& path,
                       const LeggedState& state, const GroundPlane& ground, const ElevationMap& map,
                       TrajectoryProblem* problem) const;
  bool Land(const Eigen::Vector2d& wanted, double level, const GroundPlane& ground, const ElevationMap& map,
            TrajectoryProblem::Foothold* foothold) const;

  const double time_unit_ = std::sqrt(stance.com_height / params.gravity);  // [s]
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::TrajectoryPlan);
