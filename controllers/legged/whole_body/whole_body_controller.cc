#include <tenon/controllers/legged/whole_body/whole_body_controller.h>
#include <tenon/plants/model/vectors.h>
#include <tenon/systems/analysis/internal/small_matrices.h>

#include <fmt/core.h>

#include <chrono>

namespace tenon {
namespace {

constexpr double kClockTolerance = 1e-9;  // above the rounding errors of the gait clock [s]

// Drops A' nu from L' = A nu' + A' nu, and leaves the legs' rows of (2.3) unchanged.
void NeglectAngularMomentumBias(QuadrupedDynamics* dynamics) {
  Vec<6> bias = Vec<6>::Zero();
  bias.tail<3>() = dynamics->angular_momentum_bias_W;
  const internal::Cholesky<6> trunk(dynamics->M.topLeftCorner<6, 6>());
  dynamics->coriolis.head<6>() -= bias;
  dynamics->coriolis.tail<12>().noalias() -= dynamics->M.bottomLeftCorner<12, 6>() * trunk.Solve<1>(bias);
  dynamics->angular_momentum_bias_W.setZero();
}

// Replaces the dynamics by those of one rigid body and of legs on a trunk at rest.
void NeglectCoupling(QuadrupedDynamics* dynamics) {
  dynamics->coriolis.setZero();
  dynamics->M.topRightCorner<6, 12>().setZero();
  dynamics->M.bottomLeftCorner<12, 6>().setZero();
}

/// Rotation vectors [rad] from an attitude to its reference: the tilt aligns the z axes by the shortest
/// rotation, the turn then rotates about the reference's z axis. A single rotation vector would correct the
/// tilt in a wrong direction when the heading error is large.
struct TiltAndTurn {
  Eigen::Vector3d tilt, turn;
};
TiltAndTurn AttitudeError(const Eigen::Matrix3d& R_WB, const Eigen::Matrix3d& reference) {
  const Eigen::AngleAxisd upright(RotationBetween(R_WB.col(2), reference.col(2)));
  const Eigen::Vector3d ahead = reference.transpose() * (upright * R_WB.col(0));
  return {upright.angle() * upright.axis(), -std::atan2(ahead[1], ahead[0]) * reference.col(2)};
}

/// The ground force with its tangential components clamped to the friction pyramid.
Eigen::Vector3d WithinFriction(const Eigen::Vector3d& force, const Eigen::Vector3d& normal, double friction) {
  const double pressing = std::max(0.0, force.dot(normal)), most = friction * pressing;
  const Eigen::Vector3d t_1 = FirstTangent(normal), t_2 = normal.cross(t_1);
  return force.dot(normal) * normal + std::clamp(force.dot(t_1), -most, most) * t_1 +
         std::clamp(force.dot(t_2), -most, most) * t_2;
}

/// The desired ground force on a robot with two stance feet, reduced as `tip_limit` demands: see **Tipping**
/// in the header. `tilt` and `rate` are those of the robot relative to its reference, `torque` is external.
Eigen::Vector3d WithoutTipping(const Eigen::Vector3d& force, const Eigen::Vector3d& torque,
                               const Eigen::Vector3d& tilt, const Eigen::Vector3d& rate,
                               const Eigen::Vector3d& reference_acceleration,
                               const QuadrupedDynamics& dynamics, const ContactSchedule& schedule,
                               const Eigen::Vector3d& normal, const WholeBodyGains& gains) {
  if (schedule.num_stance() != 2) return force;
  std::array<Eigen::Vector3d, 2> feet;
  std::size_t count = 0;
  double to_touchdown = 0;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const LegContact& contact = schedule.legs[leg];
    if (contact.stance())
      feet[count++] = dynamics.foot(leg).p_W;
    else
      to_touchdown = std::max(to_touchdown, contact.time_to_touchdown);
  }
  const double time = to_touchdown + gains.tip_margin;
  const Eigen::Vector3d line = (feet[1] - feet[0]).normalized(), across = normal.cross(line).normalized();
  const Eigen::Vector3d arm = feet[0] - dynamics.com_W;
  const double inertia = line.dot(dynamics.centroidal_inertia_W * line);
  const double acceleration =
      line.dot(arm.cross(force) + torque) / inertia - line.dot(reference_acceleration);
  const double predicted = line.dot(tilt + time * rate) + time * time / 2 * acceleration;
  const double excess = predicted - std::clamp(predicted, -gains.tip_limit, gains.tip_limit);
  if (excess == 0) return force;
  const double moment = inertia * excess / (time * time / 2);
  return WithinFriction(force - moment / line.dot(arm.cross(across)) * across, normal,
                        gains.grip_limit * gains.qp.friction);
}

}  // namespace

Vec<12> WholeBodyController::TorqueLimit(const QuadrupedDescription& robot) {
  Vec<12> limit;
  for (int j = 0; j < kNumJoints; ++j) limit[j] = robot.joint(j).torque_limit;
  return limit;
}

std::array<double, kNumLegs> WholeBodyController::Extensions(const QuadrupedDescription& robot) {
  std::array<double, kNumLegs> extension;
  for (int leg = 0; leg < kNumLegs; ++leg) extension[leg] = robot.LongestExtension(leg);
  return extension;
}

void WholeBodyController::CalcDynamics(const QuadrupedDynamics& of_model, const ContactSchedule& schedule,
                                       const GroundPlane& ground, const WholeBodyGains& gains,
                                       QuadrupedDynamics* dynamics) const {
  *dynamics = of_model;
  const Vec<3> arm = ground.ContactArm(params.robot.foot_radius);
  for (int leg = 0; leg < kNumLegs; ++leg)
    if (schedule.legs[leg].stance()) dynamics->feet[leg] = dynamics->Contact(leg, arm);
  if (gains.dynamics == BodyDynamics::kDecoupled) NeglectAngularMomentumBias(dynamics);
  if (gains.dynamics == BodyDynamics::kQuasiStatic) NeglectCoupling(dynamics);
}

/// The estimate without what an end stop may exert: the torque that pushes a joint back into its range. A
/// controller that compensated it would press the joint against the stop.
void WholeBodyController::CalcFreeOfStops(const LegForceEstimate& leg_forces, const LeggedState& state,
                                          LegForceEstimate* free_of_stops) const {
  *free_of_stops = leg_forces;
  for (int j = 0; j < kNumJoints; ++j) {
    double& torque = free_of_stops->joint_torque[j];
    if (state.q[j] > params.robot.joint(j).upper) torque = std::max(torque, 0.0);
    if (state.q[j] < params.robot.joint(j).lower) torque = std::min(torque, 0.0);
  }
}

WholeBodyTask WholeBodyController::MakeTask(const QuadrupedDynamics& dynamics, const LeggedState& state,
                                            const ContactSchedule& schedule, const BodyReference& body,
                                            const FeetReference& feet, const WrenchEstimate& wrench,
                                            const LegForceEstimate& leg_forces, const GroundPlane& ground,
                                            const WholeBodyGains& gains) const {
  WholeBodyTask task;
  task.normal_W = ground.Normal();
  const Eigen::Vector3d up(0, 0, model_.gravity());
  const Eigen::Matrix3d R_WB = state.R_WB();
  const Eigen::Matrix3d reference = RotationFromQuaternion(body.q_WB);
  const auto [tilt, turn] = AttitudeError(R_WB, reference);
  const Eigen::Vector3d off = Shortened<3>(body.com_W - dynamics.com_W, gains.com_limit),
                        slow = body.com_velocity_W - dynamics.com_velocity_W,
                        tilted = tilt + Shortened<3>(turn, gains.turn_limit),
                        slow_turn = body.w_W - state.w_W;
  Eigen::Vector3d pull = gains.com_stiffness * off + gains.com_damping * slow;
  Eigen::Vector3d angular = gains.trunk_stiffness * tilted + gains.trunk_damping * slow_turn;
  if (gains.sliding) {
    pull = model_.mass() * gains.sliding->com.Acceleration(off, slow);
    angular = gains.sliding->trunk.Acceleration(tilted, slow_turn);
  }
  task.wrench.head<3>() = pull + model_.mass() * (body.com_acceleration_W + up);
  task.wrench.tail<3>() = dynamics.centroidal_inertia_W * (angular + body.alpha_W);
  task.tilt = tilt.norm();
  task.turn =
      std::abs((turn + gains.trunk_damping / gains.trunk_stiffness * slow_turn).dot(reference.col(2)));
  Vec<6> disturbance;
  disturbance << wrench.force_W, wrench.torque_W;
  if (gains.dynamics != BodyDynamics::kDecoupled)
    task.disturbance = disturbance;
  else
    task.wrench -= disturbance;
  const Vec<3> by_others = task.disturbance.head<3>();
  const Vec<3> by_ground =
      WithinFriction(task.wrench.head<3>() - by_others, task.normal_W, gains.grip_limit * gains.qp.friction);
  task.wrench.head<3>() =
      by_others + WithoutTipping(by_ground, task.disturbance.tail<3>(), -tilt, state.w_W - body.w_W,
                                 body.alpha_W, dynamics, schedule, task.normal_W, gains);
  for (int leg = 0; leg < kNumLegs; ++leg) {
    const FootReference& foot = feet[leg];
    task.stance[leg] = schedule.legs[leg].stance();
    const Vec<3>& v_W = dynamics.feet[leg].v_W;
    if (task.stance[leg]) {
      const Eigen::Vector3d to_hip =
          R_WB * (params.robot.HipPosition(leg, state.q) - params.robot.FootPosition(leg, state.q));
      const double length = to_hip.norm();
      const double excess = length - gains.stretch_limit * extension_[leg];
      task.foot_acceleration[leg] = -gains.stance_damping * v_W;
      if (excess > 0) task.foot_acceleration[leg] += gains.stretch_stiffness * excess / length * to_hip;
    } else {
      const Eigen::Vector3d away = foot.p_W - dynamics.feet[leg].p_W, slower = foot.v_W - v_W;
      const Eigen::Vector3d correction =
          gains.sliding ? gains.sliding->swing.Acceleration(away, slower)
                        : Eigen::Vector3d(gains.swing_damping * slower + gains.swing_stiffness * away);
      task.foot_acceleration[leg] = foot.a_W + Shortened<3>(correction, gains.swing_limit);
    }
  }
  if (gains.compensation == LegCompensation::kExact) {
    task.joint_disturbance = leg_forces.joint_torque;
  } else {
    const auto pushed = SwingFootAcceleration(dynamics, task.stance, leg_forces.foot_force);
    for (std::size_t i = 0; i < pushed.size(); ++i) task.foot_acceleration[i] -= pushed[i];
  }
  return task;
}

void WholeBodyController::LimitLoads(const ContactSchedule& schedule, double load_ramp, Vec<4>* loading,
                                     WholeBodyTask* task) const {
  const bool walks = schedule.timing.num_steps > 0;
  const double ramp = walks ? std::min(load_ramp, schedule.timing.stance / 2) : load_ramp;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    double& share = (*loading)[leg];
    if (!task->stance[leg]) share = 0;
    if (!task->stance[leg] || ramp <= 0) continue;
    share = std::min(1.0, share + params.qp_rate.period() / ramp);
    const double left = schedule.legs[leg].time_to_lift_off;  // 0 or less while the lift-off waits
    const double largest = left > kClockTolerance ? std::min(share, left / ramp) : share;
    if (largest < 1) task->largest_load[leg] = largest * model_.mass() * model_.gravity();
  }
}

void WholeBodyController::CalcPlan(const QuadrupedDynamics& dynamics, const LeggedState& state,
                                   const ContactSchedule& schedule, const BodyReference& body,
                                   const FeetReference& feet, const WrenchEstimate& wrench,
                                   const WrenchEstimate& known_wrench, const LegForceEstimate& leg_forces,
                                   const GroundPlane& ground, const WholeBodyGains& gains,
                                   WholeBodyPlan& last, Vec<4>& loading, WholeBodyQp& qp,
                                   WholeBodyPlan* plan) const {
  const auto begin = std::chrono::steady_clock::now();
  const WrenchEstimate total{wrench.force_W + known_wrench.force_W, wrench.torque_W + known_wrench.torque_W};
  WholeBodyTask task = MakeTask(dynamics, state, schedule, body, feet, total, leg_forces, ground, gains);
  if (gains.load_ramp > 0) LimitLoads(schedule, gains.load_ramp, &loading, &task);
  const QpReport report = qp.Solve(dynamics, task, gains.qp, &last.solution);
  const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - begin;
  WholeBodyDiagnostics& diagnostics = last.diagnostics;
  ++diagnostics.solves;
  diagnostics.failures += !report.ok();
  diagnostics.failures_in_a_row = report.ok() ? 0 : diagnostics.failures_in_a_row + 1;
  diagnostics.iterations = report.iterations;
  diagnostics.status = report.status;
  diagnostics.constraint = report.constraint;
  *plan = last;
  plan->diagnostics.solve_time = elapsed.count();  // not in `last`: the memory must be equal in every run
}

Verdict WholeBodyController::CheckSolves(const WholeBodyPlan& plan, long max_failures_in_a_row) const {
  const WholeBodyDiagnostics& last = plan.diagnostics;
  if (last.failures_in_a_row <= max_failures_in_a_row) return {};
  return fmt::format(
      "the whole-body optimisation failed {} times in a row, last with status {}: the command exceeds what "
      "friction and torque limits allow; lower the speed, or check `friction` and the torque limits",
      last.failures_in_a_row, EnumName(last.status));
}

Vec<12> WholeBodyController::CalcTorque(const QuadrupedDynamics& dynamics, const WholeBodyPlan& plan,
                                        const LegForceEstimate& leg_forces, const WholeBodyGains& gains,
                                        Vec<12>& last) const {
  if (plan.diagnostics.failures_in_a_row > 0) return last;
  const Vec<12> disturbance =
      gains.compensation == LegCompensation::kExact ? leg_forces.joint_torque : Vec<12>(Vec<12>::Zero());
  const Vec<12> limit = TorqueLimit(params.robot);
  last = JointTorque(dynamics, plan.solution, disturbance).cwiseMin(limit).cwiseMax(-limit);
  return last;
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::WholeBodyPlan);
TENON_DEFINE_SIGNAL(tenon::WholeBodyDiagnostics);
