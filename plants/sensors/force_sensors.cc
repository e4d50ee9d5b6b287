#include <tenon/plants/sensors/force_sensors.h>

namespace tenon {

Vec<12> JointTorqueSensor::CalcMeasured(const Vec<12>& torque, const SensorError& error,
                                        RandomStream& noise) const {
  return error.Measure(torque, noise);
}

FootForces FootForceSensor::CalcMeasured(const FootForces& forces, const SensorError& error,
                                         RandomStream& noise) const {
  FootForces measured;
  for (int leg = 0; leg < kNumLegs; ++leg) {
    measured[leg] = error.Measure(forces[leg], noise);
    if (measured[leg].norm() < params.threshold) measured[leg].setZero();
  }
  return measured;
}

}  // namespace tenon
