#include <tenon/controllers/legged/planning/trajectory_planner.h>

#include <Eigen/Geometry>
#include <fmt/core.h>

namespace tenon {
namespace {

using Problem = TrajectoryProblem;
constexpr double kAccuracy = 1e-4;    // of a solve
constexpr double kSameLevel = 0.03;   // difference in height of ground within which a foothold may move [m]
constexpr double kEdgeWeight = 1000;  // of ground that is not flat, see FlatPlace
constexpr double kBlend = 0.5;        // duration of the transition to a stand [s]
constexpr double kAdjustment = 0.15;  // largest displacement of a foothold by the optimization [m]

bool Swings(const ContactSchedule& schedule, int leg, int step) {
  return schedule.timing.step[leg] == (schedule.step + step) % schedule.timing.num_steps;
}

}  // namespace

/// Finds the ground of a landing. False if there is none.
bool TrajectoryPlanner::Land(const Eigen::Vector2d& wanted, double level, const GroundPlane& ground,
                             const ElevationMap& map, Problem::Foothold* foothold) const {
  const MapFootholdProperties choice{params.footing.radius, params.footing.roughness,
                                     params.trajectory.search};
  MapPlace place{wanted, ground.HeightAt(wanted)};
  Eigen::Vector2d lower = wanted.array() - kAdjustment, upper = wanted.array() + kAdjustment;
  if (map.known()) {
    place = FlatPlace(map, wanted, level, choice, {}, params.trajectory.climb, kEdgeWeight);
    const bool climbs = std::abs(place.height - level) > params.trajectory.climb;
    if (climbs || place.deviation > 2 * choice.roughness) return false;
    lower = upper = place.position;
    for (const int axis : {0, 1})
      for (const int side : {-1, 1})
        for (double s = map.cell; s <= kAdjustment; s += map.cell) {
          const Eigen::Vector2d at = place.position + side * s * Eigen::Vector2d::Unit(axis);
          const MapPlace next = Survey(map, at, choice.radius);
          if (next.deviation > 2 * choice.roughness || std::abs(next.height - place.height) > kSameLevel)
            break;
          (side < 0 ? lower : upper)[axis] = at[axis];
        }
  }
  const double h = stance.com_height;
  *foothold = {{place.position[0] / h, place.position[1] / h, place.height / h}, lower / h, upper / h, true};
  return true;
}

/// Sets knots and footholds of the problem; that of leg i is kNumLegs k + i if it is new before step k.
/// Returns why there are none.
std::string TrajectoryPlanner::SetSteps(const ContactSchedule& schedule, const BodyReference& body,
                                        const PlanarPath& path, const LeggedState& state,
                                        const GroundPlane& ground, const ElevationMap& map,
                                        Problem* problem) const {
  const GaitTiming& timing = schedule.timing;
  const int steps = params.trajectory.steps, parts = params.trajectory.parts_per_swing;
  if (timing.stance <= 0 || timing.num_steps > steps)
    return fmt::format(
        "a gait of {} steps with stances of {} s needs a positive stance_s and that many horizon_steps",
        timing.num_steps, timing.stance);
  const double h = stance.com_height;
  const Eigen::Matrix3d R_WB = state.R_WB(), R_ref = RotationFromQuaternion(body.q_WB);
  const Eigen::Vector3d arm = ground.ContactArm(params.robot.foot_radius);
  std::array<int, kNumLegs> foot{0, 1, 2, 3};
  std::array<bool, kNumLegs> all{true, true, true, true}, standing;
  problem->knots.clear();
  problem->feet.assign(kNumLegs * (steps + 1), {});
  for (int i = 0; i < kNumLegs; ++i) {
    problem->feet[i].place = (state.p_WB + R_WB * params.robot.FootPosition(i, state.q) + arm) / h;
    problem->reach[i] = stance.longest[i] / h;
  }
  const auto add_knot = [&](double t, const auto& before, const auto& after) {
    Problem::Knot& knot = problem->knots.emplace_back();
    const Eigen::Matrix3d R = Eigen::AngleAxisd(path.yaw_rate * t, Eigen::Vector3d::UnitZ()) * R_ref;
    knot.time = t / time_unit_;
    knot.foot = foot;
    knot.path << path.At(t).position_W / h, 1;
    for (int i = 0; i < kNumLegs; ++i) {
      knot.carries[i] = before[i] && after[i];
      knot.reaches[i] = before[i] || after[i];
      knot.hip[i] = (R * (params.robot.HipPosition(i, params.robot.stance) - stance.com_B) + arm) / h;
      knot.path[2] += problem->feet[foot[i]].place[2] / kNumLegs;
    }
  };
  double t = 0;
  add_knot(t, all, all);
  for (int k = 0; k < steps; ++k) {
    for (int i = 0; i < kNumLegs; ++i) standing[i] = !Swings(schedule, i, k);
    t += timing.stance;
    add_knot(t, all, standing);
    for (int j = 1; j < parts; ++j) add_knot(t + timing.span() * j / parts, standing, standing);
    t += timing.span();
    for (int i = 0; i < kNumLegs; ++i) {
      if (standing[i]) continue;
      const PlanarPath there = path.At(t + timing.leg_stance() / 2);
      const Eigen::Vector2d wanted =
          there.position_W + FootprintOnSlope(ground.slope, there.yaw) * stance.foot[i] + arm.head<2>();
      const double level = h * problem->feet[foot[i]].place[2];
      foot[i] = kNumLegs * (k + 1) + i;
      if (!Land(wanted, level, ground, map, &problem->feet[foot[i]]))
        return fmt::format("the map has no flat ground for the {} leg within {} m of ({:.2f}, {:.2f}) m",
                           kLegNames[i], params.trajectory.search, wanted[0], wanted[1]);
    }
    add_knot(t, standing, all);
  }
  t += timing.stance;
  add_knot(t, all, all);
  problem->end_velocity << path.At(t).VelocityW() * time_unit_ / h, 0;
  return {};
}

void TrajectoryPlanner::CalcPlan(double now, const ContactSchedule& schedule, const BodyReference& body,
                                 const PlanarPath& path, const LeggedState& state, const GroundPlane& ground,
                                 const ElevationMap& map, TrajectoryPlan& memory, Problem& problem,
                                 TrajectoryPlan* plan) const {
  *plan = memory;
  if (memory.footsteps == schedule.footsteps) return;
  const double h = stance.com_height, speed = h / time_unit_;
  const BodyReference old = memory.footsteps < 0 ? body : CalcReference(now, memory, body);
  const int steps = params.trajectory.steps;
  plan->footsteps = schedule.footsteps;
  plan->footholds.planned = schedule.gait != Gait::kStand;
  if (!plan->footholds.planned) {
    plan->start = now;
    plan->num_knots = 2;
    const double T = plan->time[1] = kBlend / time_unit_;
    const Eigen::RowVector3d off = (old.com_W - body.com_W) / h, zero(0, 0, 0);
    const Eigen::RowVector3d rate = (old.com_velocity_W - body.com_velocity_W) / speed;
    Eigen::Map<Eigen::Matrix<double, 2, 3>>(plan->u.data()) << off, zero;
    Eigen::Map<Eigen::Matrix<double, 2, 3>>(plan->u.data() + 6) << -(6 * off + 4 * T * rate) / (T * T),
        (6 * off + 2 * T * rate) / (T * T);
    memory = *plan;
    return;
  }
  const int passed = memory.footholds.planned ? schedule.footsteps - memory.first_step : steps;
  std::string failure = SetSteps(schedule, body, path, state, ground, map, &problem);
  if (failure.empty()) {
    problem.start = old.com_W / h;
    problem.velocity = old.com_velocity_W / speed;
    problem.friction = params.friction;
    problem.properties = params.trajectory;
    problem.Prepare();
    // The first guess is the last solution as far as it goes.
    std::array<double, TrajectoryPlan::kMaxSize> z{}, u;
    std::ranges::copy(problem.U(z.data()), u.begin());
    const int K = problem.num_knots(), shift = passed * (params.trajectory.parts_per_swing + 1);
    for (int k = 0; k + shift < K && passed < steps; ++k)
      for (int row = 3; row < 6 + kNumLegs; ++row) u[row * K + k] = memory.u[row * K + k + shift];
    for (int f = kNumLegs; f + kNumLegs * passed < kNumLegs * (steps + 1); ++f)
      for (const int axis : {0, 1}) u[problem.P(f, axis)] = memory.u[problem.P(f + kNumLegs * passed, axis)];
    problem.Guess(u.data(), z.data());
    failure = problem.Solve(params.trajectory.max_evaluations, kAccuracy, z.data());
    if (failure.empty()) {
      plan->start = now;
      plan->first_step = schedule.footsteps;
      plan->num_knots = K;
      std::ranges::copy(problem.U(z.data()), plan->u.begin());
      for (int k = 0; k < K; ++k) plan->time[k] = problem.knots[k].time;
    }
  }
  const bool failed = !failure.empty();
  if (failed && passed >= steps)
    throw RunError("there is no trajectory for the walk: " + failure +
                   ". Walk more slowly, or raise trajectory.max_evaluations");
  plan->diagnostics.Count(
      {.status = failed ? QpStatus::kInfeasible : QpStatus::kSolved, .iterations = problem.evaluations});
  const Eigen::Vector3d arm = ground.ContactArm(params.robot.foot_radius);
  const int done = failed ? passed : 0, feet = (6 + kNumLegs) * plan->num_knots;
  for (int i = 0; i < kNumLegs; ++i)
    for (int k = steps - 1; k >= done; --k)  // the next landing is the last one here
      for (int axis = 0; axis < 2 && Swings(schedule, i, k - done); ++axis)
        plan->footholds.position_W[i][axis] =
            h * plan->u[feet + 3 * (kNumLegs * (k + 1) + i) + axis] - arm[axis];
  memory = *plan;
}

BodyReference TrajectoryPlanner::CalcReference(double now, const TrajectoryPlan& plan,
                                               const BodyReference& body) const {
  const double h = stance.com_height, t = (now - plan.start) / time_unit_;
  const Eigen::Map<const Eigen::MatrixX3d> position(plan.u.data(), plan.num_knots, 3);
  const Eigen::Map<const Eigen::MatrixX3d> acceleration(&plan.u[3 * plan.num_knots], plan.num_knots, 3);
  int k = 0;
  while (k + 2 < plan.num_knots && t >= plan.time[k + 1]) ++k;
  const double T = plan.time[k + 1] - plan.time[k], s = std::min(t - plan.time[k], T);
  const Eigen::Vector3d c = position.row(k), a = acceleration.row(k);
  const Eigen::Vector3d jerk = (acceleration.row(k + 1).transpose() - a) / T;
  const Eigen::Vector3d v = (position.row(k + 1).transpose() - c) / T - T * (a / 2 + T * jerk / 6);
  BodyReference reference = body;
  if (plan.footholds.planned)  // else the deviation from `body` is planned
    reference.com_W = reference.com_velocity_W = reference.com_acceleration_W = Vec<3>::Zero();
  reference.com_W += h * (c + s * (v + s * (a / 2 + s * jerk / 6)));
  if (s == T) return reference;
  reference.com_velocity_W += h / time_unit_ * (v + s * (a + s * jerk / 2));
  reference.com_acceleration_W += params.gravity * (a + s * jerk);
  return reference;
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::TrajectoryPlan);
