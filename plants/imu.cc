#include "tenon/plants/imu.h"

#include <fmt/format.h>
#include <tenon/plants/noise.h>

#include <cmath>

namespace tenon {

void ImuParams::Validate() const {
  CheckDeviation("angular_velocity_noise", angular_velocity_noise);
  CheckDeviation("specific_force_noise", specific_force_noise);
  if (!angular_velocity_bias.allFinite() || !specific_force_bias.allFinite())
    throw ParameterError("a bias of the IMU is not finite; give rad/s and m/s^2, 0 for none");
  if (!std::isfinite(gravity)) throw ParameterError(fmt::format("gravity is {}; give m/s^2", gravity));
}

template <class State, class Acceleration>
ImuMeasurement BasicImu<State, Acceleration>::CalcMeasurement(const State& body,
                                                              const Acceleration& acceleration,
                                                              RandomStream& noise) const {
  const Eigen::Matrix3d R_BW = body.R_WB().transpose();
  const Vec<3> w_B = R_BW * body.w_W;
  const Vec<3> f_B = R_BW * (acceleration.a_W + Vec<3>(0, 0, params.gravity));
  ImuMeasurement out;
  out.angular_velocity_B =
      w_B + params.angular_velocity_bias + NormalVector(noise, params.angular_velocity_noise);
  out.specific_force_B = f_B + params.specific_force_bias + NormalVector(noise, params.specific_force_noise);
  return out;
}

template class BasicImu<PlatformState, PlatformAcceleration>;
template class BasicImu<LeggedState, LeggedAcceleration>;

}  // namespace tenon
