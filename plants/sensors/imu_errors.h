#pragma once

#include <tenon/plants/signals/imu_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// Errors that differ from unit to unit: standard deviations per axis. By default there are none.
struct ImuErrorsParams {
  Rate rate = Hz(1000);              ///< rate of the samples
  double misalignment = 0;           ///< error of the mounting, about each axis of B [rad]
  double angular_velocity_bias = 0;  ///< initial bias, drawn for each run [rad/s]
  double specific_force_bias = 0;    ///< initial bias, drawn for each run [m/s^2]
  double angular_velocity_walk = 0;  ///< random walk of the bias [rad/s/sqrt(s)]
  double specific_force_walk = 0;    ///< random walk of the bias [m/s^2/sqrt(s)]

  bool any() const {
    return misalignment > 0 || angular_velocity_bias > 0 || specific_force_bias > 0 ||
           angular_velocity_walk > 0 || specific_force_walk > 0;
  }
  static FieldList Fields() {
    using P = ImuErrorsParams;
    return {Undescribed(&P::rate),
            Field("misalignment_rad", &P::misalignment).AtLeast(0),
            Field("angular_velocity_bias_deviation_rad_per_s", &P::angular_velocity_bias).AtLeast(0),
            Field("acceleration_bias_deviation_m_per_s2", &P::specific_force_bias).AtLeast(0),
            Field("angular_velocity_walk_rad_per_s_per_sqrt_s", &P::angular_velocity_walk).AtLeast(0),
            Field("acceleration_walk_m_per_s2_per_sqrt_s", &P::specific_force_walk).AtLeast(0)};
  }
};

/// Misalignment and drifting biases of an individual IMU, connected between an Imu and the blocks that read
/// it. In the IMU's frame I, which is B rotated by a small angle e,
///
///     out = R_IB in + b,   R_IB = exp(-[e] x),   b[n + 1] = b[n] + walk sqrt(h) n,
///
/// with e and b[0] drawn at the start. The blocks that read it assume that I is B. White noise is part of
/// Imu.
class ImuErrors final : public LeafSystem<ImuErrorsParams> {
 public:
  using LeafSystem::LeafSystem;

  /// Errors of an individual IMU.
  struct Unit {
    Vec<3> turn_B = Vec<3>::Zero();                 ///< e [rad]
    Vec<3> angular_velocity_bias = Vec<3>::Zero();  ///< [rad/s]
    Vec<3> specific_force_bias = Vec<3>::Zero();    ///< [m/s^2]
    static FieldList Fields() {
      return {{"turn_B", &Unit::turn_B, "rad"},
              {"angular_velocity_bias", &Unit::angular_velocity_bias, "rad/s"},
              {"specific_force_bias", &Unit::specific_force_bias, "m/s^2"}};
    }
  };

  InputPort<ImuMeasurement> measurement{this, {"measurement"}};
  Random random{this, "random"};
  DiscreteState<Unit> unit{this, {"unit"}};
  Update<Unit> draw{unit, AtStart{}, Uses(random), &ImuErrors::Draw};
  Update<Unit> walk{unit, Sampled{params.rate}, Uses(unit, random), &ImuErrors::Walk};
  OutputPort<ImuMeasurement> measured{
      this, {"measured"}, Sampled{params.rate}, Uses(measurement, unit), &ImuErrors::CalcMeasured};

 private:
  Unit Draw(RandomStream& random) const;
  Unit Walk(const Unit& unit, RandomStream& random) const;
  ImuMeasurement CalcMeasured(const ImuMeasurement& in, const Unit& unit) const;
};

}  // namespace tenon
