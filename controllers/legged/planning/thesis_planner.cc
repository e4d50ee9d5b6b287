#include <tenon/controllers/legged/planning/planned_phases.h>
#include <tenon/controllers/legged/planning/thesis_planner.h>
#include <tenon/plants/signals/euler.h>

#include <Eigen/LU>

#include <numbers>

namespace tenon {
namespace {

PlanarSpline OneSegment(const PlanarPoint& begin, double duration) {
  PlanarSpline spline;
  spline.origin = begin.position;
  spline.duration = duration;
  spline.num_segments = 1;
  spline.segments[0].duration = duration;
  spline.segments[0].coefficients[1] = duration * begin.velocity;
  return spline;
}

/// The acceleration whose ZMP is about the point of the polygon nearest to that of `point`. `ratio` is the
/// height of the CoM over gravity.
Vec<2> Realisable(const PlanarPoint& point, const SupportPolygon& polygon, double ratio) {
  Vec<2> zmp = point.position - ratio * point.acceleration;
  bool moved = false;
  for (int pass = 0; pass < 3; ++pass)  // once suffices for a rectangle
    for (const SupportPolygon::Edge& edge : polygon.edges()) {
      const double depth = edge.a * zmp[0] + edge.b * zmp[1] + edge.c;
      if (depth >= 0) continue;
      zmp -= depth * Vec<2>(edge.a, edge.b);
      moved = true;
    }
  return moved ? Vec<2>((point.position - zmp) / ratio) : point.acceleration;
}

}  // namespace

PlanarSpline QuinticBetween(const PlanarPoint& begin, const PlanarPoint& end, double duration) {
  PlanarSpline spline = OneSegment(begin, duration);
  spline.segments[0].coefficients = QuinticCoefficients(begin, end, duration);
  spline.segments[0].coefficients[0].setZero();  // it is the origin
  return spline;
}

PlanarSpline CubicToRest(const PlanarPoint& begin, const Vec<2>& end, double duration) {
  PlanarSpline spline = OneSegment(begin, duration);
  auto& c = spline.segments[0].coefficients;
  const Vec<2> way = end - begin.position;
  c[2] = 3 * way - 2 * c[1];
  c[3] = c[1] - 2 * way;
  return spline;
}

void ThesisPlanner::CalcPlan(double now, const ContactSchedule& schedule, const WalkCommand& command,
                             const GroundPlane& ground, const LeggedState& state,
                             const QuadrupedDynamics& dynamics, const FootForces& foot_forces,
                             const WrenchEstimate& wrench, const ZmpPlanParams& zmp, double blend,
                             ThesisPlan& memory, ZmpSpline& optimizer, ThesisPlan* plan) const {
  *plan = memory;
  const bool steps = memory.footsteps != schedule.footsteps;
  const bool walks = schedule.gait != Gait::kStand;
  const bool lifts_off = walks && (steps || !memory.swing) && schedule.Count(ContactState::kSwing) > 0;
  const bool heuristic = params.reference == ComReference::kHeuristic;
  if (heuristic && walks && schedule.timing.stance <= 0)
    throw RunError("a heuristic walk moves its CoM while all feet stand: give the gait a longer stance_s");
  if (!steps && (!lifts_off || heuristic)) return;
  if (memory.footsteps < 0) {
    plan->path.yaw = params.start_yaw;
    plan->path.position_W =
        params.start_position + FootprintOnSlope(ground.slope, params.start_yaw) * stance.center_B;
    plan->step_start = now;
  }
  if (steps) {
    plan->path = plan->path.At(now - plan->step_start);
    plan->step_start = now;
    plan->path.velocity = walks ? Vec<2>(command.forward, command.left) : Vec<2>(0, 0);
    plan->path.yaw_rate = walks ? command.yaw_rate : 0;
    plan->footsteps = schedule.footsteps;
  }
  plan->swing = lifts_off;
  plan->start = now;

  Vec<3> force = wrench.force_W;
  for (int leg = 0; leg < kNumLegs; ++leg) force += foot_forces[leg];
  const PlanarPoint begin{dynamics.com_W.head<2>(), dynamics.com_velocity_W.head<2>(),
                          force.head<2>() / mass_};
  const double raised = stance.com_height + command.height[0];
  if (lifts_off && !heuristic) {
    plan->duration = schedule.timing.span();
    PlanSwing(schedule, ground.slope, begin, raised, zmp, optimizer, plan);
  } else {
    plan->duration = walks ? std::max(schedule.timing.stance, params.rate.period()) : blend;
    Vec<2> centre = plan->path.position_W;
    int visited = 0;
    if (walks)
      ForEachPlannedPhase(plan->path, ground.slope, schedule, stance, 1,
                          [&](double, std::span<const Eigen::Vector2d> feet) {
                            if (visited++ == 0 || (heuristic && !feet.empty())) centre = CentreOf(feet);
                          });
    if (heuristic) {
      const Vec<3>& f = wrench.force_W;
      const Vec<2> moment(wrench.torque_W[1] + raised * f[0], raised * f[1] - wrench.torque_W[0]);
      const double weight = mass_ * params.gravity, load = std::max(weight - f[2], weight / 10);
      plan->spline = QuinticBetween(begin, {.position = centre - moment / load}, plan->duration);
    } else {
      plan->spline = CubicToRest(begin, centre, plan->duration);
    }
  }

  // Height and attitude, as a cubic from the measured ones to rest.
  const double T = plan->duration;
  const PlanarPoint end = plan->spline.At(std::min(T, plan->spline.duration));
  const Vec<3> euler = EulerFromRotation(state.R_WB());
  Vec<4> from, rate, to;
  from << dynamics.com_W[2], euler;
  rate << dynamics.com_velocity_W[2], EulerRateMatrix(euler).inverse() * state.w_W;
  to << ground.HeightAt(end.position) + raised,
      EulerOnSlope(ground.slope, plan->path.At(now + T - plan->step_start).yaw);
  for (int i = 1; i < 4; ++i) to[i] = from[i] + std::remainder(to[i] - from[i], 2 * std::numbers::pi);
  plan->cubic = {from, rate, (3 * (to - from) - 2 * T * rate) / (T * T),
                 (T * rate - 2 * (to - from)) / (T * T * T)};
  memory = *plan;
}

void ThesisPlanner::PlanSwing(const ContactSchedule& schedule, const Vec<2>& slope, const PlanarPoint& begin,
                              double height, const ZmpPlanParams& zmp, ZmpSpline& optimizer,
                              ThesisPlan* plan) const {
  std::array<SupportPhase, ZmpSpline::kMaxPhases> phases;
  std::size_t count = 0;
  int visited = 0;
  double duration = 0;
  PlanarPoint end;
  ForEachPlannedPhase(plan->path, slope, schedule, stance, zmp.horizon + 1,
                      [&](double seconds, std::span<const Eigen::Vector2d> feet) {
                        ++visited;  // the first phase is the stance that has passed
                        if (visited == 1 || visited > 2 * zmp.horizon + 1 || seconds <= 0 || feet.empty())
                          return;
                        phases[count++] = {seconds, SupportPolygon(feet, zmp.half_width, zmp.margin)};
                        duration += seconds;
                        end.position = CentreOf(feet);
                      });
  const PlanarSpline regularized = QuinticBetween(begin, end, duration);
  PlanarPoint start = begin;
  start.acceleration = Realisable(begin, phases[0].polygon, height / params.gravity);
  const QpReport report = optimizer.Solve({.phases = {phases.data(), count},
                                           .begin = start,
                                           .end = end,
                                           .regularized = &regularized,
                                           .height = {.rest = height},
                                           .gravity = params.gravity},
                                          zmp.spline, &plan->spline);
  if (!report.ok()) plan->spline = regularized;
  plan->diagnostics.Count(report);
}

BodyReference ThesisPlanner::CalcReference(double now, const ThesisPlan& plan) const {
  const double t = now - plan.start;
  PlanarPoint planar = plan.spline.At(std::min(t, plan.spline.duration));
  if (t >= plan.spline.duration) planar.velocity = planar.acceleration = Vec<2>::Zero();
  const auto& c = plan.cubic;
  const double s = std::min(t, plan.duration);
  const Vec<4> pose = c[0] + s * (c[1] + s * (c[2] + s * c[3]));
  const bool moves = t < plan.duration;
  const Vec<4> rate = moves ? Vec<4>(c[1] + s * (2 * c[2] + 3 * s * c[3])) : Vec<4>(Vec<4>::Zero());
  const Vec<4> bend = moves ? Vec<4>(2 * c[2] + 6 * s * c[3]) : Vec<4>(Vec<4>::Zero());
  BodyReference reference;
  reference.com_W << planar.position, pose[0];
  reference.com_velocity_W << planar.velocity, rate[0];
  reference.com_acceleration_W << planar.acceleration, bend[0];
  const Vec<3> euler = pose.tail<3>();
  reference.q_WB = QuaternionFromEuler(euler);
  reference.w_W = EulerRateMatrix(euler) * rate.tail<3>();
  reference.alpha_W = EulerRateMatrix(euler) * bend.tail<3>();  // neglects the rate of the matrix
  return reference;
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::ThesisPlan);
