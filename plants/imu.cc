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

ImuMeasurement Imu::CalcMeasurement(const PlatformState& platform, const PlatformAcceleration& acceleration,
                                    RandomStream& noise) const {
  const Eigen::Matrix3d R_BW = platform.R_WB().transpose();
  const Vec<3> w_B = R_BW * platform.w_W;
  const Vec<3> f_B = R_BW * (acceleration.a_W + Vec<3>(0, 0, params.gravity));
  ImuMeasurement out;
  out.angular_velocity_B =
      w_B + params.angular_velocity_bias + NormalVector(noise, params.angular_velocity_noise);
  out.specific_force_B = f_B + params.specific_force_bias + NormalVector(noise, params.specific_force_noise);
  return out;
}

}  // namespace tenon
