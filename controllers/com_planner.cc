#include "tenon/controllers/com_planner.h"

#include <fmt/core.h>

#include <cmath>

namespace tenon {
namespace {

/// (x, y, z, yaw) and two derivatives.
struct Pose {
  Vec<4> position, velocity, acceleration;
};

Pose PoseAt(const ComPlan& plan, double com_height, double time) {
  const double t = time - plan.start;
  const PendulumPoint over_ground = plan.pendulum.At(t);
  const PlanarPath path = plan.path.At(t);
  Pose pose;
  pose.position << over_ground.position, plan.ground + com_height, path.yaw;
  pose.velocity << over_ground.velocity, 0, path.yaw_rate;
  pose.acceleration << over_ground.acceleration, 0, 0;
  if (t < plan.blend) {
    const auto& c = plan.remainder;
    pose.position += c[0] + t * (c[1] + t * (c[2] + t * c[3]));
    pose.velocity += c[1] + t * (2 * c[2] + 3 * t * c[3]);
    pose.acceleration += 2 * c[2] + 6 * t * c[3];
  }
  return pose;
}

/// The cubic that begins at `offset` with `rate` and ends at rest at 0 after the time `blend`.
void Fade(const Vec<4>& offset, const Vec<4>& rate, double blend, ComPlan* plan) {
  plan->blend = blend;
  plan->remainder = {offset, rate, -(3 * offset + 2 * blend * rate) / (blend * blend),
                     (2 * offset + blend * rate) / (blend * blend * blend)};
}

}  // namespace

void ComPlannerParams::Validate() const {
  Demand(blend > 0, fmt::format("a plan is blended in within {} s: it must be positive", blend));
  Demand(gravity > 0, fmt::format("gravity is {} m/s^2: it must be positive", gravity));
}

/// At rest where the robot stands in its nominal stance; its CoM need not be over the centre of its feet.
ComPlan ComPlanner::FirstPlan(double time) const {
  ComPlan plan;
  plan.start = time;
  plan.path.yaw = params.start_yaw;
  const Eigen::Matrix2d R = plan.path.Heading();
  plan.path.position_W = params.start_position + R * stance.center_B;
  plan.pendulum.Begin(plan.path, 1);
  plan.blend = params.blend;
  plan.remainder[0].head<2>() = R * (stance.com_B.head<2>() - stance.center_B);
  return plan;
}

void ComPlanner::CalcPlan(const double& time, const ContactSchedule& schedule, const WalkCommand& command,
                          const LeggedState& state, ComPlan& memory, ComPlan* plan) const {
  if (memory.footsteps != schedule.footsteps) {
    const bool first = memory.footsteps < 0;
    if (first) {
      memory = FirstPlan(time);
      memory.ground = GroundHeight(schedule, state, 0);
    }
    const Pose old = PoseAt(memory, stance.com_height, time);
    memory.path = memory.path.At(time - memory.start);
    memory.start = time;
    memory.footsteps = schedule.footsteps;
    const bool walks = schedule.gait != Gait::kStand;
    memory.path.velocity = walks ? Vec<2>(command.forward, command.left) : Vec<2>(0, 0);
    memory.path.yaw_rate = walks ? command.yaw_rate : 0;
    memory.ground = GroundHeight(schedule, state, memory.ground);
    PlanPendulum(schedule, &memory);
    memory.blend = 0;
    const Pose next = PoseAt(memory, stance.com_height, time);
    Fade(old.position - next.position, old.velocity - next.velocity, params.blend, &memory);
  }
  *plan = memory;
}

/// The cycle from the beginning of the present step on. A foot is planted where the path has it at its
/// nominal place in the middle of its stance.
void ComPlanner::PlanPendulum(const ContactSchedule& schedule, ComPlan* plan) const {
  plan->pendulum.Begin(plan->path, std::sqrt(params.gravity / stance.com_height));
  const GaitTiming& timing = schedule.timing;
  std::array<Eigen::Vector2d, kNumLegs> foot;
  const auto plant = [&](std::size_t leg, double mid_stance) {
    const PlanarPath there = plan->path.At(mid_stance);
    foot[leg] = there.position_W + there.Heading() * stance.foot[leg];
  };
  const auto steps_ahead = [&](std::size_t leg) {
    return (timing.step[leg] - schedule.step + timing.num_steps) % timing.num_steps;
  };
  for (std::size_t i = 0; i < kNumLegs && timing.num_steps > 0; ++i) {
    const double lift_off = steps_ahead(i) * timing.step_duration() + timing.stance;
    plant(i, lift_off - timing.leg_stance() / 2);
  }
  for (int k = 0; k < timing.num_steps; ++k) {
    Eigen::Vector2d all = Eigen::Vector2d::Zero(), standing = Eigen::Vector2d::Zero();
    int count = 0;
    for (std::size_t i = 0; i < kNumLegs; ++i) {
      all += foot[i] / kNumLegs;
      if (steps_ahead(i) == k) continue;
      standing += foot[i];
      ++count;
    }
    plan->pendulum.Add(timing.stance, all);
    plan->pendulum.Add(timing.swing, standing / count);
    for (std::size_t i = 0; i < kNumLegs; ++i) {
      if (steps_ahead(i) == k) plant(i, (k + 1) * timing.step_duration() + timing.leg_stance() / 2);
    }
  }
  plan->pendulum.Solve();
}

double ComPlanner::GroundHeight(const ContactSchedule& schedule, const LeggedState& state,
                                double otherwise) const {
  const Eigen::Matrix3d R = state.R_WB();
  double sum = 0;
  for (int i = 0; i < kNumLegs; ++i) {
    if (!schedule.legs[static_cast<std::size_t>(i)].stance()) continue;
    sum += (state.p_WB + R * params.robot.FootPosition(i, state.q))[2] - params.robot.foot_radius;
  }
  const int count = schedule.num_stance();
  return count > 0 ? sum / count : otherwise;
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
  reference.q_WB << std::cos(pose.position[3] / 2), 0, 0, std::sin(pose.position[3] / 2);
  reference.w_W[2] = pose.velocity[3];
  reference.alpha_W[2] = pose.acceleration[3];
  return reference;
}

PlanarPath ComPlanner::CalcPath(const double& time, const ComPlan& plan) const {
  return plan.path.At(time - plan.start);
}

}  // namespace tenon
