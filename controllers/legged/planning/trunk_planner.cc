#include <tenon/controllers/legged/planning/trunk_planner.h>
#include <tenon/controllers/legged/planning/wrench_sinusoid.h>
#include <tenon/plants/model/vectors.h>

namespace tenon {

// The acceleration a in the swing of this step, see the header; zero unless two feet stand in it.
Vec<3> TrunkPlanner::FreeAcceleration(const ContactSchedule& schedule, const LeggedState& state,
                                      const WrenchEstimate& wrench) const {
  std::array<Eigen::Vector3d, kNumLegs> feet_B;
  std::size_t count = 0;
  for (int leg = 0; leg < kNumLegs; ++leg)
    if (schedule.timing.step[leg] != schedule.step) feet_B[count++] = params.robot.FootPosition(leg, state.q);
  if (count != 2) return Vec<3>::Zero();
  const Eigen::Matrix3d R = state.R_WB();
  const Eigen::Vector3d n_B = (feet_B[1] - feet_B[0]).normalized();
  const Eigen::Vector3d arm_W = R * (feet_B[0] - stance.com_B);
  const Eigen::Vector3d push_W(wrench.force_W[0], wrench.force_W[1], 0);
  const double torque = (R * n_B).dot(wrench.torque_W - arm_W.cross(push_W));
  return torque / n_B.dot(stance.inertia_B * n_B) * (R * n_B);
}

BodyReference TrunkPlanner::CalcReference(const BodyReference& body, const ContactSchedule& schedule,
                                          const LeggedState& state, const WrenchEstimate& wrench,
                                          double bandwidth, double sway_limit, Memory& memory) const {
  const double S = schedule.timing.stance, T = schedule.timing.span();
  const double blend = -std::expm1(-bandwidth * params.rate.period());
  memory.push.force_W += blend * (wrench.force_W - memory.push.force_W);
  memory.push.torque_W += blend * (wrench.torque_W - memory.push.torque_W);
  BodyReference out = body;
  if (schedule.timing.num_steps == 0) {
    memory.rate.setZero();
    return out;
  }
  const Eigen::Vector3d a =
      Shortened<3>(FreeAcceleration(schedule, state, memory.push), sway_limit * S / (3 * T));
  Eigen::Vector3d angle;
  if (schedule.step_time < S) {
    const double u = schedule.step_time / S;
    const Eigen::Vector3d to = -T / 2 * a;
    angle = S * u * (1 - u) * ((1 - u) * memory.rate - u * to);
    out.w_W += (1 - u) * (1 - 3 * u) * memory.rate + u * (3 * u - 2) * to;
    out.alpha_W += ((6 * u - 4) * memory.rate + (6 * u - 2) * to) / S;
  } else {
    const double s = std::min(schedule.step_time - S, T);
    angle = -s * (T - s) / 2 * a;
    out.w_W += (s - T / 2) * a;
    out.alpha_W += a;
    memory.rate = T / 2 * a;
  }
  out.q_WB = QuaternionProduct(QuaternionFromRotationVector(angle), body.q_WB);
  return out;
}

void WrenchSinusoid::Update(const Vec<6>& wrench, double dt) {
  constexpr double kDamping = 1.4, kOffset = 0.3,
                   kLock = 0.3;                  // k, k_m, g: damped, and found in a few periods
  constexpr double kNoise = 0.01;                // n
  constexpr double kSlowest = 1, kFastest = 25;  // [rad/s]
  const Vec<6> error = wrench - mean - in_phase;
  const double power = in_phase.squaredNorm() + quadrature.squaredNorm() + kNoise * kNoise;
  frequency -= dt * kLock * frequency * frequency * error.dot(quadrature) / power;
  frequency = std::clamp(frequency, kSlowest, kFastest);
  in_phase += dt * frequency * (kDamping * error - quadrature);
  quadrature += dt * frequency * in_phase;
  mean += dt * frequency * kOffset * error;
}

Vec<6> WrenchSinusoid::After(double t) const {
  return mean + std::cos(frequency * t) * in_phase - std::sin(frequency * t) * quadrature;
}

}  // namespace tenon
