#include <tenon/plants/sensors/pose_sensor.h>

#include <tenon/plants/sensors/sensor_noise.h>

namespace tenon {

void PoseSensorParams::Validate() const {
  CheckDeviation("position_noise", position_noise);
  CheckDeviation("attitude_noise", attitude_noise);
}

PoseMeasurement PoseSensor::CalcPose(const PlatformState& platform, const Vec<3>& position_noise,
                                     const Vec<3>& attitude_noise, RandomStream& noise) const {
  const Vec<3> p_WB = platform.p_WB + NormalVector(noise, position_noise);
  const Vec<3> turn = NormalVector(noise, attitude_noise);
  return {p_WB, QuaternionProduct(platform.q_WB, QuaternionFromRotationVector(turn))};
}

}  // namespace tenon
