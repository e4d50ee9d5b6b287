#pragma once

#include <tenon/systems/framework/types/signal.h>

namespace tenon {

/// Measurement of an IMU, in the body's frame B.
struct ImuMeasurement {
  Vec<3> angular_velocity_B = Vec<3>::Zero();  ///< [rad/s]
  Vec<3> specific_force_B = Vec<3>::Zero();    ///< acceleration minus gravity: 9.81 upwards at rest [m/s^2]

  static FieldList Fields() {
    return {{"angular_velocity_B", &ImuMeasurement::angular_velocity_B, "rad/s"},
            {"specific_force_B", &ImuMeasurement::specific_force_B, "m/s^2"}};
  }
};

}  // namespace tenon

TENON_DECLARE_SIGNAL(tenon::ImuMeasurement);
