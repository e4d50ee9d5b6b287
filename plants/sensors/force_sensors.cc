#include <tenon/plants/sensors/force_sensors.h>

namespace tenon {

Vec<12> JointTorqueSensor::CalcMeasured(const Vec<12>& torque, RandomStream& noise) const {
  return params.error.Measure(torque, noise);
}

FootForces FootForceSensor::CalcMeasured(const FootForces& forces, RandomStream& noise) const {
  FootForces measured;
  for (int leg = 0; leg < kNumLegs; ++leg) measured[leg] = params.error.Measure(forces[leg], noise);
  return measured;
}

}  // namespace tenon
