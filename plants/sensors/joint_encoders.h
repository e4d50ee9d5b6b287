#pragma once

#include <tenon/plants/model/legged_signals.h>
#include <tenon/plants/sensors/sensor_noise.h>
#include <tenon/systems/framework/parameter.h>
#include <tenon/systems/framework/ports.h>
#include <tenon/systems/framework/state.h>
#include <tenon/systems/framework/system.h>

namespace tenon {

/// Defaults: without errors.
struct JointEncodersParams {
  Rate rate = Hz(1000);
  SensorError angle = {};  ///< [rad]
  SensorError speed = {};  ///< [rad/s]

  void Validate() const;  ///< throws ParameterError
};

/// Measures angle and speed of all joints at a rate, each with an error of its own (sensor_noise.h); the
/// speed is the drive's, not a difference of angles.
///
///     port in   state   the true state
///     port out  joints  sampled
///
/// The errors `angle` and `speed` are Parameters: a run can change them.
class JointEncoders final : public LeafSystem<JointEncodersParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<LeggedState> state{this, {"state"}};
  Parameter<SensorError> angle{
      this, {"angle"}, params.angle, "error of each angle; absolute and bias in rad"};
  Parameter<SensorError> speed{
      this, {"speed"}, params.speed, "error of each speed; absolute and bias in rad/s"};
  Random angle_noise{this, "angle_noise"};
  Random speed_noise{this, "speed_noise"};
  OutputPort<JointMotion> joints{this,
                                 {"joints"},
                                 Sampled{params.rate},
                                 Uses(state, angle, speed, angle_noise, speed_noise),
                                 &JointEncoders::CalcJoints};

 private:
  JointMotion CalcJoints(const LeggedState& x, const SensorError& angle, const SensorError& speed,
                         RandomStream& angle_noise, RandomStream& speed_noise) const;
};

}  // namespace tenon
