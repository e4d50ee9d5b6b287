#include <tenon/plants/sensors/joint_encoders.h>

namespace tenon {

void JointEncodersParams::Validate() const {
  angle.Validate("the joint angles");
  speed.Validate("the joint speeds");
}

JointMotion JointEncoders::CalcJoints(const LeggedState& x, const SensorError& angle,
                                      const SensorError& speed, RandomStream& angle_noise,
                                      RandomStream& speed_noise) const {
  return {angle.Measure(x.q, angle_noise), speed.Measure(x.qd, speed_noise)};
}

}  // namespace tenon
