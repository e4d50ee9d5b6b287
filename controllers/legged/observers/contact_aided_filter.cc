#include <tenon/controllers/legged/observers/contact_aided_filter.h>
#include <tenon/controllers/optimization/lanes/small_product.h>
#include <tenon/plants/model/vectors.h>
#include <tenon/systems/analysis/internal/small_matrices.h>
#include <tenon/systems/framework/block/system.h>

namespace tenon {
namespace {

using Filter = ContactAidedFilter;
using Eigen::Matrix3d;

constexpr int Rows(int leg) {
  return Filter::kFeet + 3 * leg;
}

/// Measurements without the estimated biases.
struct Unbiased {
  Unbiased(const ContactAidedMean& mean, const ImuMeasurement& inertial)
      : f_B(inertial.specific_force_B - mean.specific_force_bias_B),
        w_B(inertial.angular_velocity_B - mean.angular_velocity_bias_B) {}
  Vec<3> f_B, w_B;
};

TENON_VECTOR_CLONES void Multiply(const Filter::Covariance& a, const Filter::Covariance& b,
                                  Filter::Covariance* c) {
  internal::Multiply(a, b, *c);
}

}  // namespace

ContactAidedMean Plus(const ContactAidedMean& mean, const Filter::Error& error) {
  const Vec<4> turn = QuaternionFromRotationVector(error.segment<3>(Filter::kAttitude));
  const Matrix3d E = RotationFromQuaternion(turn);
  ContactAidedMean out = mean;
  out.p_WI = E * mean.p_WI + error.segment<3>(Filter::kPosition);
  out.v_WI = E * mean.v_WI + error.segment<3>(Filter::kVelocity);
  out.q_WB = QuaternionProduct(turn, mean.q_WB).normalized();
  out.specific_force_bias_B += error.segment<3>(Filter::kForceBias);
  out.angular_velocity_bias_B += error.segment<3>(Filter::kRateBias);
  for (int leg = 0; leg < kNumLegs; ++leg)
    out.feet_W[leg] = E * mean.feet_W[leg] + error.segment<3>(Rows(leg));
  return out;
}

ContactAidedMean Propagate(const ContactAidedMean& mean, const ContactAidedInput& input,
                           const std::array<bool, kNumLegs>& anchored, double T, double radius,
                           double gravity) {
  const Unbiased imu(mean, input.inertial);
  const Matrix3d R = mean.R_WB();
  const Vec<3> a = R * imu.f_B - Vec<3>(0, 0, gravity);
  ContactAidedMean out = mean;
  out.p_WI += T * mean.v_WI + T * T / 2 * a;
  out.v_WI += T * a;
  out.q_WB = QuaternionProduct(mean.q_WB, QuaternionFromRotationVector(T * imu.w_B)).normalized();
  for (std::size_t leg = 0; leg < kNumLegs; ++leg) {
    if (!anchored[leg]) continue;
    const Vec<3> turn_W = R * (T * imu.w_B + input.turn_B[leg]);
    out.feet_W[leg] += radius * turn_W.cross(input.normal_W);
  }
  return out;
}

Filter::Covariance PropagationJacobian(const ContactAidedMean& mean, const ContactAidedInput& input,
                                       const std::array<bool, kNumLegs>& anchored, double T, double radius,
                                       double gravity) {
  const ContactAidedMean next = Propagate(mean, input, anchored, T, radius, gravity);
  const Unbiased imu(mean, input.inertial);
  const Matrix3d R = mean.R_WB(), up = CrossMatrix(Vec<3>::UnitZ()), normal = CrossMatrix(input.normal_W);
  // Rotation over the interval due to an error of the angular velocity.
  const Matrix3d turned = -T * RotationFromQuaternion(QuaternionProduct(
                                   mean.q_WB, QuaternionFromRotationVector(T / 2 * imu.w_B)));
  Filter::Covariance F = Filter::Covariance::Identity();
  F.block<3, 3>(Filter::kPosition, Filter::kVelocity).diagonal().setConstant(T);
  F.block<3, 3>(Filter::kPosition, Filter::kAttitude) = -T * T / 2 * gravity * up;
  F.block<3, 3>(Filter::kPosition, Filter::kForceBias) = -T * T / 2 * R;
  F.block<3, 3>(Filter::kPosition, Filter::kRateBias) = CrossMatrix(next.p_WI) * turned;
  F.block<3, 3>(Filter::kVelocity, Filter::kAttitude) = -T * gravity * up;
  F.block<3, 3>(Filter::kVelocity, Filter::kForceBias) = -T * R;
  F.block<3, 3>(Filter::kVelocity, Filter::kRateBias) = CrossMatrix(next.v_WI) * turned;
  F.block<3, 3>(Filter::kAttitude, Filter::kRateBias) = turned;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    if (!anchored[leg]) continue;
    const Vec<3> turn_W = R * (T * imu.w_B + input.turn_B[leg]);
    // The ground's normal does not depend on the attitude error.
    F.block<3, 3>(Rows(leg), Filter::kAttitude) = radius * CrossMatrix(turn_W) * normal;
    F.block<3, 3>(Rows(leg), Filter::kRateBias) =
        CrossMatrix(next.feet_W[leg]) * turned + radius * T * normal * R;
  }
  return F;
}

Vec<3> FootResidual(const ContactAidedMean& mean, int leg, const Vec<3>& p_IF_B) {
  return mean.feet_W[leg] - mean.p_WI - mean.R_WB() * p_IF_B;
}

void ContactAidedFilter::Start(const ContactAidedMean& start, const Eigen::Matrix<double, 5, 1>& deviation) {
  mean = start;
  anchored.fill(false);
  covariance.setZero();
  for (int i = 0; i < 5; ++i) covariance.diagonal().segment<3>(3 * i).setConstant(std::pow(deviation[i], 2));
  // xi = (p - p_hat) + p_hat x theta
  const double turn = std::pow(deviation[kAttitude / 3], 2);
  const Matrix3d p = CrossMatrix(mean.p_WI), v = CrossMatrix(mean.v_WI);
  covariance.block<3, 3>(kPosition, kPosition) += turn * p * p.transpose();
  covariance.block<3, 3>(kPosition, kVelocity) = turn * p * v.transpose();
  covariance.block<3, 3>(kVelocity, kPosition) = turn * v * p.transpose();
  covariance.block<3, 3>(kVelocity, kVelocity) += turn * v * v.transpose();
  covariance.block<3, 3>(kPosition, kAttitude) = turn * p;
  covariance.block<3, 3>(kAttitude, kPosition) = turn * p.transpose();
  covariance.block<3, 3>(kVelocity, kAttitude) = turn * v;
  covariance.block<3, 3>(kAttitude, kVelocity) = turn * v.transpose();
}

Matrix3d ContactAidedFilter::PlainCovariance(int rows, const Vec<3>& value) const {
  const Matrix3d cross = CrossMatrix(value);
  const Matrix3d mixed = cross * covariance.block<3, 3>(kAttitude, rows);
  return covariance.block<3, 3>(rows, rows) - mixed - mixed.transpose() +
         cross * covariance.block<3, 3>(kAttitude, kAttitude) * cross.transpose();
}

void ContactAidedFilter::Predict(const ContactAidedInput& input, const ContactAidedNoise& noise, double T,
                                 double radius, double gravity) {
  const Covariance F = PropagationJacobian(mean, input, anchored, T, radius, gravity);
  const Covariance F_transposed = F.transpose();
  Covariance FP;
  Multiply(F, covariance, &FP);
  Multiply(FP, F_transposed, &covariance);
  mean = Propagate(mean, input, anchored, T, radius, gravity);

  // Sensor noise enters like the bias, for one period.
  Eigen::Matrix<double, kErrors, 6, Eigen::DontAlign> G;
  G.leftCols<3>() = noise.specific_force * F.middleCols<3>(kForceBias);
  G.rightCols<3>() = noise.angular_velocity * F.middleCols<3>(kRateBias);
  G.middleRows<6>(kForceBias).setZero();
  covariance += G.lazyProduct(G.transpose());
  auto variance = covariance.diagonal();
  variance.segment<3>(kForceBias).array() += T * std::pow(noise.specific_force_bias_walk, 2);
  variance.segment<3>(kRateBias).array() += T * std::pow(noise.angular_velocity_bias_walk, 2);
  for (int leg = 0; leg < kNumLegs; ++leg)
    if (anchored[leg]) variance.segment<3>(Rows(leg)).array() += T * std::pow(noise.foot_walk, 2);
}

void ContactAidedFilter::Anchor(int leg, const FootMeasurement& foot) {
  Release(leg);
  anchored[leg] = true;
  const Matrix3d R = mean.R_WB();
  mean.feet_W[leg] = mean.p_WI + R * foot.p_IF_B;
  // The foot's error is the error of p plus the measurement error.
  const FootRow row = covariance.middleRows<3>(kPosition);
  covariance.middleRows<3>(Rows(leg)) = row;
  covariance.middleCols<3>(Rows(leg)) = row.transpose();
  covariance.block<3, 3>(Rows(leg), Rows(leg)) =
      row.middleCols<3>(kPosition) + R * foot.covariance * R.transpose();
}

void ContactAidedFilter::Release(int leg) {
  anchored[leg] = false;
  covariance.middleRows<3>(Rows(leg)).setZero();
  covariance.middleCols<3>(Rows(leg)).setZero();
}

int ContactAidedFilter::Correct(const std::array<FootMeasurement, kNumLegs>& feet, double outlier) {
  // Sequential update by each foot, linearised at one mean.
  const Matrix3d R = mean.R_WB();
  Error error = Error::Zero();
  std::array<bool, kNumLegs> moved{};
  for (int leg = 0; leg < kNumLegs; ++leg) {
    if (!anchored[leg]) continue;
    const FootMeasurement& foot = feet[leg];
    const FootRow HP = covariance.middleRows<3>(Rows(leg)) - covariance.middleRows<3>(kPosition);
    const Matrix3d S =
        HP.middleCols<3>(Rows(leg)) - HP.middleCols<3>(kPosition) + R * foot.covariance * R.transpose();
    const Vec<3> innovation =
        -FootResidual(mean, leg, foot.p_IF_B) - (error.segment<3>(Rows(leg)) - error.segment<3>(kPosition));
    const internal::Cholesky<3> factors(S);
    const Vec<3> weighted = factors.Solve<1>(innovation);
    if (innovation.dot(weighted) > outlier) {
      moved[leg] = true;
      continue;
    }
    error += HP.transpose() * weighted;
    const FootRow half = factors.SolveLower<kErrors>(HP);  // P -= HP^T S^-1 HP, symmetric by construction
    covariance -= half.transpose().lazyProduct(half);
  }
  mean = Plus(mean, error);
  covariance = ((covariance + covariance.transpose()) / 2).eval();
  int count = 0;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    if (!moved[leg]) continue;
    Anchor(leg, feet[leg]);
    ++count;
  }
  return count;
}

}  // namespace tenon
