#include <tenon/plants/sensors/joint_encoders.h>

#include <numbers>

namespace tenon {

double JointEncodersParams::Resolution() const {
  return bits ? std::ldexp(2 * std::numbers::pi, -*bits) : 0;
}

Vec<12> JointEncoders::DrawOffset(RandomStream& noise) const {
  Vec<12> offset;
  for (double& angle : offset) angle = params.offset_deviation * noise.Normal();
  return offset;
}

JointMotion JointEncoders::CalcJoints(const LeggedState& x, const SensorError& angle,
                                      const SensorError& speed, const Vec<12>& offset,
                                      RandomStream& angle_noise, RandomStream& speed_noise,
                                      Memory& memory) const {
  JointMotion joints{angle.Measure<12>(x.q + offset, angle_noise), speed.Measure(x.qd, speed_noise)};
  if (params.bits) {
    const double resolution = params.Resolution();
    joints.q = resolution * (joints.q / resolution).array().round().matrix();
  }
  if (params.speed_bandwidth > 0) {
    const double h = params.rate.period();
    const double a = std::exp(-2 * std::numbers::pi * params.speed_bandwidth * h);
    joints.qd = memory.started ? Vec<12>(a * memory.last.qd + (1 - a) / h * (joints.q - memory.last.q))
                               : Vec<12>::Zero();
    memory = {true, joints};
  }
  return joints;
}

}  // namespace tenon
