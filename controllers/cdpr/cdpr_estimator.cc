#include <tenon/controllers/cdpr/cdpr_estimator.h>
#include <tenon/controllers/cdpr/cdpr_kinematics.h>
#include <tenon/plants/model/vectors.h>
#include <tenon/systems/analysis/internal/small_matrices.h>

namespace tenon {
namespace {

using Vector9d = Eigen::Matrix<double, 9, 1>;

constexpr double kBiasTime = 0.2;  // t_b [s]

Eigen::Vector3d RotationVector(const Vec<4>& q) {
  const Eigen::Vector3d v = (q[0] < 0 ? -1 : 1) * q.tail<3>();
  const double sine = v.norm();
  return sine < 1e-9 ? Eigen::Vector3d(2 * v)
                     : Eigen::Vector3d(2 * std::atan2(sine, std::abs(q[0])) / sine * v);
}

/// Applies the correction (dp, dv, dtheta) to the mean.
void Apply(const Vector9d& error, PlatformState& platform) {
  platform.p_WB += error.head<3>();
  platform.v_W += error.segment<3>(3);
  platform.q_WB =
      QuaternionProduct(platform.q_WB, QuaternionFromRotationVector(error.tail<3>())).normalized();
}

}  // namespace

CdprEstimator::Memory CdprEstimator::FirstMemory(const CdprEstimatorParams& params) {
  Memory memory;
  memory.length.setZero(params.robot.num_cables());
  memory.bias.setZero(params.robot.num_cables());
  return memory;
}

PlatformEstimate CdprEstimator::CalcEstimate(const double& time, const PoseMeasurement& pose,
                                             const ImuMeasurement& inertial, const CableSignals& cables,
                                             const CdprNoise& noise, Memory& memory) const {
  const bool lengths = cables.length.size() > 0;
  if (lengths) CheckNumCables(params.robot.num_cables(), cables.length.size(), "CdprEstimator");
  if (memory.started) {
    const Step mean = Predict(inertial, noise, memory);
    if (lengths) CorrectByLengths(time, cables.length, noise, mean, memory);
    Correct(pose, noise, memory);
  } else {
    memory.started = true;
    memory.platform = {pose.p_WB, pose.q_WB, Vec<3>::Zero(), Vec<3>::Zero()};
    memory.covariance.setZero();
    memory.covariance.diagonal() << Vec<3>::Constant(std::pow(noise.position, 2)),
        Vec<3>::Constant(std::pow(params.initial_velocity, 2)), Vec<3>::Constant(std::pow(noise.attitude, 2));
  }
  memory.platform.w_W = memory.platform.R_WB() * inertial.angular_velocity_B;
  memory.inertial = inertial;
  if (lengths) memory.length = cables.length;
  return {time, memory.platform};
}

CdprEstimator::Step CdprEstimator::Predict(const ImuMeasurement& inertial, const CdprNoise& noise,
                                           Memory& memory) const {
  const double T = params.rate.period();
  const Vec<3> w = (memory.inertial.angular_velocity_B + inertial.angular_velocity_B) / 2;
  const Vec<3> f = (memory.inertial.specific_force_B + inertial.specific_force_B) / 2;
  PlatformState& platform = memory.platform;
  // Attitude at the middle of the interval.
  const Eigen::Matrix3d R_WB =
      RotationFromQuaternion(QuaternionProduct(platform.q_WB, QuaternionFromRotationVector(T / 2 * w)));
  const Vec<3> a_W = R_WB * f - Vec<3>(0, 0, params.gravity);
  const Step mean{platform.p_WB + T / 2 * platform.v_W, platform.v_W + T / 2 * a_W, w, R_WB};
  platform.p_WB += T * platform.v_W + T * T / 2 * a_W;
  platform.v_W += T * a_W;
  platform.q_WB = QuaternionProduct(platform.q_WB, QuaternionFromRotationVector(T * w)).normalized();

  Covariance F = Covariance::Identity();
  F.block<3, 3>(0, 3).diagonal().setConstant(T);
  F.block<3, 3>(3, 6) = -T * R_WB * CrossMatrix(f);
  F.block<3, 3>(6, 6) -= T * CrossMatrix(w);
  const Covariance FP = F.lazyProduct(memory.covariance);
  memory.covariance = FP.lazyProduct(F.transpose());
  memory.covariance.diagonal().segment<3>(3).array() += std::pow(T * noise.specific_force, 2);
  memory.covariance.diagonal().segment<3>(6).array() += std::pow(T * noise.angular_velocity, 2);
  return mean;
}

void CdprEstimator::CorrectByLengths(double time, const CableVector& length, const CdprNoise& noise,
                                     Step mean, Memory& memory) const {
  const double T = params.rate.period(), share = std::min(1.0, T / kBiasTime);
  const Eigen::Vector3d w_W = mean.R_WB * mean.w_B;
  PlatformState& platform = memory.platform;
  Covariance& P = memory.covariance;
  for (int i = 0; i < params.robot.num_cables(); ++i) {
    const CableLine line = CalcCableLine(params.robot, i, mean.p_WB, mean.R_WB, anchors, time - T / 2);
    const Eigen::Vector3d lever = line.wrench.tail<3>();
    double innovation = (length[i] - memory.length[i]) / T + line.direction.dot(mean.v_W) + lever.dot(w_W);
    if (anchors.any()) innovation -= line.anchor_rate;
    double& bias = memory.bias[i];
    bias += share * (innovation - bias);
    const Vector9d PH = -P.middleCols<3>(3) * line.direction;  // H selects -direction . dv
    const double S = std::pow(noise.length_rate, 2) + 2 / share * bias * bias +
                     lever.squaredNorm() * std::pow(noise.angular_velocity, 2) -
                     line.direction.dot(PH.segment<3>(3));
    const Vector9d error = innovation / S * PH;
    P.noalias() -= PH / S * PH.transpose();
    Apply(error, platform);
    mean.v_W += error.segment<3>(3);
  }
}

void CdprEstimator::Correct(const PoseMeasurement& pose, const CdprNoise& noise, Memory& memory) const {
  PlatformState& platform = memory.platform;
  Eigen::Matrix<double, 6, 1> innovation;
  const Vec<4> inverse(platform.q_WB[0], -platform.q_WB[1], -platform.q_WB[2], -platform.q_WB[3]);
  innovation << pose.p_WB - platform.p_WB, RotationVector(QuaternionProduct(inverse, pose.q_WB));

  // H selects dp and dtheta.
  const Covariance& P = memory.covariance;
  Eigen::Matrix<double, 6, 9> HP;
  HP << P.topRows<3>(), P.bottomRows<3>();
  Eigen::Matrix<double, 6, 6> S;
  S << HP.leftCols<3>(), HP.rightCols<3>();
  S.diagonal().head<3>().array() += std::pow(noise.position, 2);
  S.diagonal().tail<3>().array() += std::pow(noise.attitude, 2);
  const Eigen::Matrix<double, 6, 9> gain_transposed = internal::Cholesky<6>(S).Solve<9>(HP);
  const Vector9d error = gain_transposed.transpose() * innovation;
  const Covariance reduced = P - HP.transpose().lazyProduct(gain_transposed);
  memory.covariance = (reduced + reduced.transpose()) / 2;

  Apply(error, platform);
}

}  // namespace tenon

TENON_DEFINE_SIGNAL(tenon::PlatformEstimate);
