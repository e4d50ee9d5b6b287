#include <tenon/plants/sensors/pose_sensor.h>
#include <tenon/plants/sensors/sensor_noise.h>

namespace tenon {

PoseSensor::Offset PoseSensor::Draw(RandomStream& calibration) const {
  Offset offset;
  offset.position = NormalVector(calibration, Vec<3>::Constant(params.position_offset));
  offset.turn = NormalVector(calibration, Vec<3>::Constant(params.attitude_offset));
  return offset;
}

PoseMeasurement PoseSensor::CalcPose(const PlatformState& platform, const Vec<3>& position_noise,
                                     const Vec<3>& attitude_noise, const Offset& offset,
                                     RandomStream& noise) const {
  const Vec<3> p_WB = platform.p_WB + offset.position + NormalVector(noise, position_noise);
  const Vec<3> turn = offset.turn + NormalVector(noise, attitude_noise);
  return {p_WB, QuaternionProduct(platform.q_WB, QuaternionFromRotationVector(turn))};
}

}  // namespace tenon
