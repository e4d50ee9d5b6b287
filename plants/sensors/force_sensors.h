#pragma once

#include <tenon/plants/sensors/sensor_noise.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// Torque sensors of the joints. By default there are no errors.
struct TorqueSensorParams {
  Rate rate = Hz(1000);    ///< sample rate
  SensorError error = {};  ///< error of each torque, equal at all joints [N m]

  static FieldList Fields() {
    using P = TorqueSensorParams;
    return {{"rate_hz", &P::rate},
            Field("noise_ratio", &P::error, &SensorError::relative).AtLeast(0),
            Field("bias_N_m", &P::error, &SensorError::bias).Finite()};
  }
};

/// Sensors of the ground forces on the feet. By default there are no errors.
struct FootForceSensorParams {
  Rate rate = Hz(1000);    ///< sample rate
  SensorError error = {};  ///< error of each component, equal at all feet [N]
  double threshold = 0;    ///< measured forces below this are set to 0 [N]

  static FieldList Fields() {
    using P = FootForceSensorParams;
    const auto weights = [](double ratio, const Scale& scale) { return scale.Weight() * ratio; };
    return {
        {"rate_hz", &P::rate},
        Field("noise_ratio", &P::error, &SensorError::relative).AtLeast(0),
        Field("noise_N", &P::error, &SensorError::absolute).AtLeast(0).Scaled("noise_weight_ratio", weights),
        Field("bias_N", &P::error, &SensorError::bias).Finite(),
        Field("threshold_N", &P::threshold).AtLeast(0).Scaled("threshold_weight_ratio", weights)};
  }
};

/// Measures the torques of all drives, each with an error (sensor_noise.h).
class JointTorqueSensor final : public LeafSystem<TorqueSensorParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<Vec<12>> torque{this, {"torque", "N m"}};
  Parameter<SensorError> error{
      this, {"error"}, params.error, "error of each component; absolute and bias in N m"};
  Random noise{this, "noise"};
  OutputPort<Vec<12>> measured{this,
                               {"measured", "N m", kJointElements},
                               Sampled{params.rate},
                               Uses(torque, error, noise),
                               &JointTorqueSensor::CalcMeasured};

 private:
  Vec<12> CalcMeasured(const Vec<12>& torque, const SensorError& error, RandomStream& noise) const {
    return error.Measure(torque, noise);
  }
};

/// Measures the forces on all feet, each component with an error (sensor_noise.h), in the axes of the input.
/// Measured forces below the threshold are set to 0.
class FootForceSensor final : public LeafSystem<FootForceSensorParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<FootForces> forces{this, {"forces"}};
  Parameter<SensorError> error{
      this, {"error"}, params.error, "error of each component; absolute and bias in N"};
  Random noise{this, "noise"};
  OutputPort<FootForces> measured{
      this, {"measured"}, Sampled{params.rate}, Uses(forces, error, noise), &FootForceSensor::CalcMeasured};

 private:
  FootForces CalcMeasured(const FootForces& forces, const SensorError& error, RandomStream& noise) const {
    FootForces measured;
    for (int leg = 0; leg < kNumLegs; ++leg) {
      measured[leg] = error.Measure(forces[leg], noise);
      if (measured[leg].norm() < params.threshold) measured[leg].setZero();
    }
    return measured;
  }
};

}  // namespace tenon
