#include <tenon/plants/sensors/imu.h>
#include <tenon/plants/sensors/sensor_noise.h>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace tenon {

void ImuParams::Validate() const {
  if (!p_B.allFinite()) throw ParameterError("p_B, the position of the IMU, is not finite; give metres in B");
  if (!std::isfinite(gravity)) throw ParameterError(fmt::format("gravity is {}; give m/s^2", gravity));
}

template <class State, class Acceleration>
ImuMeasurement BasicImu<State, Acceleration>::CalcMeasurement(
    const State& body, const Acceleration& acceleration, const Vec<3>& angular_velocity_noise,
    const Vec<3>& specific_force_noise, const Vec<3>& angular_velocity_bias,
    const Vec<3>& specific_force_bias, RandomStream& noise) const {
  const Eigen::Matrix3d R_WB = body.R_WB();
  const Vec<3> r_W = R_WB * params.p_B;
  const Vec<3> a_W = acceleration.a_W + acceleration.alpha_W.cross(r_W) + body.w_W.cross(body.w_W.cross(r_W));
  const Vec<3> w_B = R_WB.transpose() * body.w_W;
  const Vec<3> f_B = R_WB.transpose() * (a_W + Vec<3>(0, 0, params.gravity));
  ImuMeasurement out;
  out.angular_velocity_B = w_B + angular_velocity_bias + NormalVector(noise, angular_velocity_noise);
  out.specific_force_B = f_B + specific_force_bias + NormalVector(noise, specific_force_noise);
  return out;
}

template class BasicImu<PlatformState, PlatformAcceleration>;
template class BasicImu<LeggedState, LeggedAcceleration>;

}  // namespace tenon
