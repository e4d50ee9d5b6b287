#pragma once

#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// The defaults model a distant motion capture system.
struct PoseSensorParams {
  Rate rate = Hz(200);                              ///< sample rate of the pose
  Vec<3> position_noise = Vec<3>::Constant(0.005);  ///< standard deviation along x, y, z of W [m]
  Vec<3> attitude_noise = Vec<3>::Constant(0.01);   ///< standard deviation about x, y, z of B [rad]
  double position_offset = 0;  ///< standard deviation of the calibration error along each axis of W [m]
  double attitude_offset = 0;  ///< standard deviation of the calibration error about each axis of B [rad]

  static FieldList Fields() {
    using P = PoseSensorParams;
    return {Undescribed(&P::rate), Undescribed("position_noise", &P::position_noise).AtLeast(0),
            Undescribed("attitude_noise", &P::attitude_noise).AtLeast(0),
            Field("offset_m", &P::position_offset).AtLeast(0),
            Field("offset_rad", &P::attitude_offset).AtLeast(0)};
  }
};

/// Measures position and attitude with white noise and calibration errors:
///
///     p = p_WB + o_p + n_p,   q = q_WB * exp((o_a + n_a) / 2),
///
/// with n_p and n_a normal, independent in their components and in time, o_p and o_a normal and drawn at the
/// start, and exp(a / 2) the rotation by |a| about a.
class PoseSensor final : public LeafSystem<PoseSensorParams> {
 public:
  using LeafSystem::LeafSystem;

  /// Calibration errors.
  struct Offset {
    Vec<3> position = Vec<3>::Zero();  ///< o_p [m]
    Vec<3> turn = Vec<3>::Zero();      ///< o_a [rad]
    static FieldList Fields() {
      return {{"position", &Offset::position, "m"}, {"turn", &Offset::turn, "rad"}};
    }
  };

  InputPort<PlatformState> platform{this, {"platform"}};
  Parameter<Vec<3>> position_noise{
      this, {"position_noise", "m"}, params.position_noise, "standard deviation along x, y, z of W"};
  Parameter<Vec<3>> attitude_noise{
      this, {"attitude_noise", "rad"}, params.attitude_noise, "standard deviation about x, y, z of B"};
  Random noise{this, "noise"};
  Random calibration{this, "calibration"};
  DiscreteState<Offset> offset{this, {"offset"}};
  Update<Offset> draw{offset, AtStart{}, Uses(calibration), &PoseSensor::Draw};
  OutputPort<PoseMeasurement> pose{this,
                                   {"pose"},
                                   Sampled{params.rate},
                                   Uses(platform, position_noise, attitude_noise, offset, noise),
                                   &PoseSensor::CalcPose};

 private:
  Offset Draw(RandomStream& calibration) const;
  PoseMeasurement CalcPose(const PlatformState& platform, const Vec<3>& position_noise,
                           const Vec<3>& attitude_noise, const Offset& offset, RandomStream& noise) const;
};

}  // namespace tenon
