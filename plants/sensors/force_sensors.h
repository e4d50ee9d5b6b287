#pragma once

#include <tenon/plants/sensors/sensor_noise.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

namespace tenon {

/// By default there are no errors.
struct ForceSensorParams {
  Rate rate = Hz(1000);
  SensorError error = {};  ///< error of each component [N m] or [N]
};

/// By default there are no errors.
struct FootForceSensorParams {
  Rate rate = Hz(1000);
  SensorError error = {};  ///< error of each component [N]
  double threshold = 0;    ///< measured forces below this are set to 0 [N]

  void Validate() const;  ///< throws ParameterError
};

/// Measures the torques of all drives, each with an error (sensor_noise.h).
class JointTorqueSensor final : public LeafSystem<ForceSensorParams> {
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
  Vec<12> CalcMeasured(const Vec<12>& torque, const SensorError& error, RandomStream& noise) const;
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
  FootForces CalcMeasured(const FootForces& forces, const SensorError& error, RandomStream& noise) const;
};

}  // namespace tenon
