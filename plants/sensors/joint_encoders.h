#pragma once

#include <tenon/plants/sensors/sensor_noise.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/block.h>

#include <numbers>

namespace tenon {

/// Encoders of the joints. By default there are no errors.
struct JointEncodersParams {
  Rate rate = Hz(1000);         ///< sample rate
  SensorError angle = {};       ///< error of the angles, equal at all joints [rad]
  SensorError speed = {};       ///< error of the speeds, equal at all joints [rad/s]
  std::optional<int> bits;      ///< resolution of one turn of the joint; empty: unlimited
  double offset_deviation = 0;  ///< standard deviation of each joint's calibration error [rad]
  double speed_bandwidth = 0;   ///< cut-off frequency f of differentiated angles; 0: speeds are measured [Hz]

  /// Smallest difference of two angles; 0: unlimited [rad]
  double Resolution() const { return bits ? std::ldexp(2 * std::numbers::pi, -*bits) : 0; }
  static FieldList Fields() {
    using P = JointEncodersParams;
    return {{"rate_hz", &P::rate},
            Field("angle_noise_rad", &P::angle, &SensorError::absolute).AtLeast(0),
            Field("angle_bias_rad", &P::angle, &SensorError::bias).Finite(),
            Field("speed_noise_rad_per_s", &P::speed, &SensorError::absolute).AtLeast(0),
            Field("speed_bias_rad_per_s", &P::speed, &SensorError::bias).Finite(),
            Field("bits", &P::bits).Between(1, 52),
            Field("offset_rad", &P::offset_deviation).AtLeast(0),
            Field("speed_bandwidth_hz", &P::speed_bandwidth).AtLeast(0)};
  }
};

/// Measures angle and speed of all joints with errors (sensor_noise.h). An angle q is measured as
///
///     resolution round((q + offset + error) / resolution),   resolution = 2 pi / 2^bits.
///
/// Without a bandwidth the speed is the true speed with its error. With a bandwidth f it is computed from the
/// measured angles, by their differences over the period h and a first-order low-pass filter,
///
///     qd[n] = a qd[n - 1] + (1 - a) (q[n] - q[n - 1]) / h,   a = exp(-2 pi f h),
///
/// which lags by about 1 / (2 pi f) and contains the quantisation noise of the angles.
class JointEncoders final : public LeafSystem<JointEncodersParams> {
 public:
  using LeafSystem::LeafSystem;

  /// Memory of the differentiation.
  struct Memory {
    bool started = false;
    JointMotion last;
    static FieldList Fields() { return {{"started", &Memory::started}, {"last", &Memory::last}}; }
  };

  InputPort<LeggedState> state{this, {"state"}};
  Parameter<SensorError> angle{
      this, {"angle"}, params.angle, "error of each angle; absolute and bias in rad"};
  Parameter<SensorError> speed{
      this, {"speed"}, params.speed, "error of each speed; absolute and bias in rad/s"};
  Random angle_noise{this, "angle_noise"};
  Random speed_noise{this, "speed_noise"};
  Random offset_noise{this, "offset_noise"};
  DiscreteState<Vec<12>> offset{this, {"offset", "rad", kJointElements}};
  Update<Vec<12>> draw_offset{offset, AtStart{}, Uses(offset_noise), &JointEncoders::DrawOffset};
  Scratch<Memory> memory{this, "memory"};
  OutputPort<JointMotion> joints{this,
                                 {"joints"},
                                 Sampled{params.rate},
                                 Uses(state, angle, speed, offset, angle_noise, speed_noise, memory),
                                 &JointEncoders::CalcJoints};

 private:
  Vec<12> DrawOffset(RandomStream& noise) const {
    Vec<12> offset;
    for (double& angle : offset) angle = params.offset_deviation * noise.Normal();
    return offset;
  }
  JointMotion CalcJoints(const LeggedState& x, const SensorError& angle, const SensorError& speed,
                         const Vec<12>& offset, RandomStream& angle_noise, RandomStream& speed_noise,
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
};

}  // namespace tenon
