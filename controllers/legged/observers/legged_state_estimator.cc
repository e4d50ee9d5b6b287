#include <tenon/controllers/legged/observers/legged_state_estimator.h>

#include <Eigen/Geometry>
#include <fmt/core.h>

namespace tenon {
namespace {

constexpr double kSettleTolerance = 1e-9;  // [s]

}  // namespace

void LeggedStateEstimatorParams::Validate() const {
  const auto check = [](const char* name, double value) {
    Demand(std::isfinite(value) && value > 0,
           fmt::format("{} = {} must be finite and positive; give a standard deviation", name, value));
  };
  check("start.position", start.position);
  check("start.velocity", start.velocity);
  check("start.attitude", start.attitude);
  check("start.specific_force_bias", start.specific_force_bias);
  check("start.angular_velocity_bias", start.angular_velocity_bias);
  Demand(robot.contact.stiffness > 0,
         fmt::format("robot.contact.stiffness = {} N/m must be positive: read the robot by LoadQuadruped",
                     robot.contact.stiffness));
  Demand(std::isfinite(gravity), fmt::format("gravity = {} is not finite; give m/s^2", gravity));
  Demand(initial.q_WB.allFinite() && initial.q_WB.norm() > 0.5,
         "initial.q_WB is not a rotation; give a unit quaternion (w, x, y, z), 1 0 0 0 for the identity");
  Demand(initial.p_WB.allFinite() && initial.v_W.allFinite() && initial.w_W.allFinite(),
         "initial is not finite; give the pose and velocity at which the robot starts");
}

void LeggedStateEstimator::Start(const JointMotion& joints, double settle_time, Memory& memory) const {
  const LeggedState& x = params.initial;
  const Vec<3> arm_W = x.R_WB() * params.robot.imu_B;
  ContactAidedMean mean;
  mean.p_WI = x.p_WB + arm_W;
  mean.v_WI = x.v_W + x.w_W.cross(arm_W);
  mean.q_WB = x.q_WB.normalized();
  const LeggedStartDeviation& start = params.start;
  memory.filter.Start(mean, (Vec<5>() << start.position, start.velocity, start.attitude,
                             start.specific_force_bias, start.angular_velocity_bias)
                                .finished());
  memory.stance_time.fill(settle_time);  // stance feet at the start have settled
  memory.q = joints.q;
  memory.started = true;
}

double LeggedStateEstimator::RollingRadius(const std::array<bool, kNumLegs>& anchored) const {
  const auto feet = std::max<std::ptrdiff_t>(1, std::count(anchored.begin(), anchored.end(), true));
  const ContactProperties& contact = params.robot.contact;
  const double load = model_.mass() * params.gravity / static_cast<double>(feet);
  return std::max(0.0, params.robot.foot_radius - load / contact.stiffness - contact.blend / 2);
}

void LeggedStateEstimator::CalcLegs(const JointMotion& joints, QuadrupedDynamics* legs) const {
  LeggedState at_origin;  // makes W coincide with B
  at_origin.q = joints.q;
  model_.Calc(at_origin, legs);
}

LeggedEstimate LeggedStateEstimator::CalcEstimate(const ImuMeasurement& last_imu,
                                                  const QuadrupedDynamics& legs, const JointMotion& joints,
                                                  const ContactSchedule& schedule, const GroundPlane& ground,
                                                  const ContactAidedNoise& noise, double settle_time,
                                                  double outlier, Memory& memory) const {
  const double T = params.rate.period();
  ContactAidedFilter& filter = memory.filter;
  const bool first = !memory.started;
  ContactAidedInput input{last_imu, {}, ground.Normal()};
  if (first) {
    Start(joints, settle_time, memory);
    input.inertial.angular_velocity_B = params.initial.R_WB().transpose() * params.initial.w_W;
  } else {
    for (int leg = 0; leg < kNumLegs; ++leg) {
      Vec<3>& turn = input.turn_B[leg];
      turn.setZero();
      for (int j = kJointsPerLeg * leg; j < kJointsPerLeg * (leg + 1); ++j)
        turn += (joints.q[j] - memory.q[j]) * legs.axis_W[j];
    }
    filter.Predict(input, noise, T, RollingRadius(filter.anchored), params.gravity);
    memory.q = joints.q;
  }

  std::array<FootMeasurement, kNumLegs> feet;
  for (std::size_t leg = 0; leg < kNumLegs; ++leg) {
    const QuadrupedDynamics::Foot& foot = legs.feet[leg];
    feet[leg].p_IF_B = foot.p_W - params.robot.imu_B;
    feet[leg].covariance = std::pow(noise.encoder, 2) * foot.J_leg * foot.J_leg.transpose();
    feet[leg].covariance.diagonal().array() += std::pow(noise.foot, 2);
  }
  // Feet that no longer stand are released before the prediction, new stance feet are anchored at the end.
  std::array<bool, kNumLegs> counts{};
  for (int leg = 0; leg < kNumLegs; ++leg) {
    double& time = memory.stance_time[leg];
    const bool stance = schedule.legs[leg].stance();
    if (!first) time += T;
    if (!stance) time = 0;
    counts[leg] = stance && time >= settle_time - kSettleTolerance;
    if (!counts[leg] && filter.anchored[leg]) filter.Release(leg);
  }
  memory.moved_feet += filter.Correct(feet, outlier);
  for (int leg = 0; leg < kNumLegs; ++leg)
    if (counts[leg] && !filter.anchored[leg]) filter.Anchor(leg, feet[leg]);
  return Output(input.inertial, joints, memory);
}

ImuMeasurement LeggedStateEstimator::CalcInertial(const ImuMeasurement& imu,
                                                  const LeggedEstimatorDiagnostics& diagnostics) const {
  return {imu.angular_velocity_B - diagnostics.angular_velocity_bias_B,
          imu.specific_force_B - diagnostics.specific_force_bias_B};
}

LeggedEstimate LeggedStateEstimator::Output(const ImuMeasurement& imu_B, const JointMotion& joints,
                                            const Memory& memory) const {
  const ContactAidedMean& mean = memory.filter.mean;
  LeggedEstimate out;
  LeggedState& x = out.state;
  const Eigen::Matrix3d R = mean.R_WB();
  x.q_WB = mean.q_WB;
  x.w_W = R * (imu_B.angular_velocity_B - mean.angular_velocity_bias_B);
  x.p_WB = mean.p_WI - R * params.robot.imu_B;
  x.v_W = mean.v_WI - x.w_W.cross(R * params.robot.imu_B);
  x.q = joints.q;
  x.qd = joints.qd;

  LeggedEstimatorDiagnostics& diagnostics = out.diagnostics;
  const auto deviation = [](const Eigen::Matrix3d& covariance) -> Vec<3> {
    return covariance.diagonal().cwiseMax(0).cwiseSqrt();
  };
  diagnostics.position_deviation = deviation(memory.filter.PositionCovariance());
  diagnostics.velocity_deviation = deviation(memory.filter.VelocityCovariance());
  constexpr int attitude = ContactAidedFilter::kAttitude;
  diagnostics.attitude_deviation = deviation(memory.filter.covariance.block<3, 3>(attitude, attitude));
  diagnostics.specific_force_bias_B = mean.specific_force_bias_B;
  diagnostics.angular_velocity_bias_B = mean.angular_velocity_bias_B;
  for (const bool anchored : memory.filter.anchored) diagnostics.feet += anchored;
  diagnostics.moved_feet = memory.moved_feet;
  return out;
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::LeggedEstimate);
TENON_DEFINE_SIGNAL(tenon::LeggedEstimatorDiagnostics);
