#include <tenon/plants/sensors/imu_errors.h>
#include <tenon/plants/sensors/sensor_noise.h>
#include <tenon/plants/signals/quaternion.h>

namespace tenon {

ImuErrors::Unit ImuErrors::Draw(RandomStream& random) const {
  Unit unit;
  unit.turn_B = NormalVector(random, Vec<3>::Constant(params.misalignment));
  unit.angular_velocity_bias = NormalVector(random, Vec<3>::Constant(params.angular_velocity_bias));
  unit.specific_force_bias = NormalVector(random, Vec<3>::Constant(params.specific_force_bias));
  return unit;
}

ImuErrors::Unit ImuErrors::Walk(const Unit& unit, RandomStream& random) const {
  const double root = std::sqrt(params.rate.period());
  Unit next = unit;
  next.angular_velocity_bias += NormalVector(random, Vec<3>::Constant(params.angular_velocity_walk * root));
  next.specific_force_bias += NormalVector(random, Vec<3>::Constant(params.specific_force_walk * root));
  return next;
}

ImuMeasurement ImuErrors::CalcMeasured(const ImuMeasurement& in, const Unit& unit) const {
  const Eigen::Matrix3d R_IB = RotationFromQuaternion(QuaternionFromRotationVector(-unit.turn_B));
  ImuMeasurement out;
  out.angular_velocity_B = R_IB * in.angular_velocity_B + unit.angular_velocity_bias;
  out.specific_force_B = R_IB * in.specific_force_B + unit.specific_force_bias;
  return out;
}

}  // namespace tenon
