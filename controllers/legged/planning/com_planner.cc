#include <tenon/controllers/legged/planning/com_planner.h>
#include <tenon/controllers/legged/planning/planned_phases.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/plants/signals/quaternion.h>

namespace tenon {
namespace {

/// (x, y, z, yaw, slope of the ground) and two derivatives.
struct Pose {
  Vec<6> position, velocity, acceleration;
};

PlanarPoint OnPath(const PlanarPath& path) {
  const Eigen::Vector2d v = path.VelocityW();
  return {path.position_W, v, path.yaw_rate * Eigen::Vector2d(-v[1], v[0])};
}

Pose PoseAt(const ComPlan& plan, double com_height, double time) {
  const double t = time - plan.start;
  const PlanarPath path = plan.path.At(t);
  const PlanarPoint over_ground = plan.spline.num_segments == 0 ? plan.pendulum.At(t)
                                  : t < plan.spline.duration    ? plan.spline.At(t)
                                                                : OnPath(path);
  Pose pose;
  const Vec<2>& slope = plan.ground.slope;
  pose.position << over_ground.position, plan.ground.HeightAt(over_ground.position) + com_height, path.yaw,
      slope;
  pose.velocity << over_ground.velocity, slope.dot(over_ground.velocity), path.yaw_rate, 0, 0;
  pose.acceleration << over_ground.acceleration, slope.dot(over_ground.acceleration), 0, 0, 0;
  if (t < plan.blend) {
    const auto& c = plan.remainder;
    pose.position += c[0] + t * (c[1] + t * (c[2] + t * c[3]));
    pose.velocity += c[1] + t * (2 * c[2] + 3 * t * c[3]);
    pose.acceleration += 2 * c[2] + 6 * t * c[3];
  }
  return pose;
}

/// The cubic that begins at `offset` with `rate` and ends at rest at 0 after the time `blend`.
void Fade(const Vec<6>& offset, const Vec<6>& rate, double blend, ComPlan* plan) {
  plan->blend = blend;
  plan->remainder = {offset, rate, -(3 * offset + 2 * blend * rate) / (blend * blend),
                     (2 * offset + blend * rate) / (blend * blend * blend)};
}

}  // namespace

/// The initial plan: at rest in the nominal stance, in which the CoM need not be above the centre of the
/// feet.
ComPlan ComPlanner::FirstPlan(double time, const GroundPlane& ground) const {
  ComPlan plan;
  plan.start = time;
  plan.path.yaw = params.start_yaw;
  plan.ground = ground;
  const Eigen::Matrix2d R = FootprintOnSlope(ground.slope, params.start_yaw);
  plan.path.position_W = params.start_position + R * stance.center_B;
  plan.pendulum.Begin(plan.path, 1);
  plan.blend = std::numeric_limits<double>::infinity();
  plan.remainder[0].head<2>() = R * (stance.com_B.head<2>() - stance.center_B);
  return plan;
}

void ComPlanner::CalcPlan(const double& time, const ContactSchedule& schedule, const WalkCommand& command,
                          const GroundPlane& ground, const ZmpPlanParams& zmp, double blend, ComPlan& memory,
                          ZmpSpline& optimizer, ComPlan* plan) const {
  *plan = memory;
  if (memory.footsteps == schedule.footsteps) return;
  if (memory.footsteps < 0) *plan = FirstPlan(time, ground);
  const Pose old = PoseAt(*plan, stance.com_height, time);
  memory = *plan;
  plan->path = plan->path.At(time - plan->start);
  plan->start = time;
  const bool walks = schedule.gait != Gait::kStand;
  plan->path.velocity = walks ? Vec<2>(command.forward, command.left) : Vec<2>(0, 0);
  plan->path.yaw_rate = walks ? command.yaw_rate : 0;
  plan->ground = ground;
  plan->blend = 0;
  plan->spline.num_segments = 0;
  PlanPendulum(schedule, plan);
  const Pose next = PoseAt(*plan, stance.com_height, time);
  Fade(old.position - next.position, old.velocity - next.velocity, blend, plan);
  if (walks && params.reference == ComReference::kZmpSpline) {
    const PlanarPoint begin{old.position.head<2>(), old.velocity.head<2>(), old.acceleration.head<2>()};
    if (PlanSpline(schedule, begin, command.height[0], zmp, optimizer, plan)) {
      for (Vec<6>& c : plan->remainder) c.head<2>().setZero();  // the spline itself starts at the reference
    } else {
      memory.diagnostics = plan->diagnostics;
      *plan = memory;
    }
  }
  plan->footsteps = schedule.footsteps;
  memory = *plan;
}

/// Plans one cycle from the start of the present step.
void ComPlanner::PlanPendulum(const ContactSchedule& schedule, ComPlan* plan) const {
  plan->pendulum.Begin(plan->path, std::sqrt(params.gravity / stance.com_height));
  double t = 0;
  ForEachPlannedPhase(plan->path, plan->ground.slope, schedule, stance, schedule.timing.num_steps,
                      [&](double duration, std::span<const Eigen::Vector2d> feet) {
                        // Without a foot on the ground the CoM moves evenly above the path.
                        Eigen::Vector2d zmp = plan->path.At(t + duration / 2).position_W;
                        if (!feet.empty()) zmp = CentreOf(feet);
                        plan->pendulum.Add(duration, zmp);
                        t += duration;
                      });
  plan->pendulum.Solve();
}

bool ComPlanner::PlanSpline(const ContactSchedule& schedule, const PlanarPoint& begin, double raised,
                            const ZmpPlanParams& zmp, ZmpSpline& optimizer, ComPlan* plan) const {
  std::array<SupportPhase, ZmpSpline::kMaxPhases> phases;
  std::size_t count = 0, visited = 0;
  double duration = 0;
  ForEachPlannedPhase(plan->path, plan->ground.slope, schedule, stance, zmp.horizon + 1,
                      [&](double seconds, std::span<const Eigen::Vector2d> feet) {
                        if (++visited > 2 * static_cast<std::size_t>(zmp.horizon) + 1) return;
                        if (seconds <= 0) return;
                        phases[count++] = {seconds, SupportPolygon(feet, zmp.half_width, zmp.margin)};
                        duration += seconds;
                      });
  HeightProfile height{.rest = stance.com_height + raised, .fade_duration = plan->blend};
  for (std::size_t i = 0; i < height.fade.size(); ++i) height.fade[i] = plan->remainder[i][2];
  const QpReport report = optimizer.Solve({.phases = {phases.data(), count},
                                           .begin = begin,
                                           .end = OnPath(plan->path.At(duration)),
                                           .path = plan->path,
                                           .height = height,
                                           .gravity = params.gravity},
                                          zmp.spline, &plan->spline);
  plan->diagnostics.Count(report);
  return report.ok();
}

BodyReference ComPlanner::CalcReference(const double& time, const ComPlan& plan,
                                        const WalkCommand& command) const {
  const Pose pose = PoseAt(plan, stance.com_height, time);
  BodyReference reference;
  reference.com_W = pose.position.head<3>();
  reference.com_velocity_W = pose.velocity.head<3>();
  reference.com_acceleration_W = pose.acceleration.head<3>();
  reference.com_W[2] += command.height[0];
  reference.com_velocity_W[2] += command.height[1];
  reference.com_acceleration_W[2] += command.height[2];
  const Vec<2> slope = pose.position.tail<2>(), slope_rate = pose.velocity.tail<2>();
  const double yaw = pose.position[3], yaw_rate = pose.velocity[3];
  const Vec<3> euler = EulerOnSlope(slope, yaw);
  reference.q_WB = QuaternionFromEuler(euler);
  reference.w_W = EulerRateMatrix(euler) * EulerRateOnSlope(slope, slope_rate, yaw, yaw_rate);
  reference.alpha_W[2] = pose.acceleration[3];  // neglects the rate of the slope
  return reference;
}

PlanarPath ComPlanner::CalcPath(const double& time, const ComPlan& plan) const {
  return plan.path.At(time - plan.start);
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::ComPlan);
TENON_DEFINE_SIGNAL(tenon::ComDiagnostics);
