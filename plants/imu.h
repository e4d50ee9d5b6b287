#pragma once

#include <tenon/plants/description/cdpr_signals.h>
#include <tenon/systems/ports.h>
#include <tenon/systems/state.h>
#include <tenon/systems/system.h>

namespace tenon {

/// Defaults: a small industrial unit without bias.
struct ImuParams {
  Rate rate = Hz(1000);
  Vec<3> angular_velocity_noise = Vec<3>::Constant(0.005);  ///< standard deviation per axis [rad/s]
  Vec<3> specific_force_noise = Vec<3>::Constant(0.05);     ///< standard deviation per axis [m/s^2]
  Vec<3> angular_velocity_bias = Vec<3>::Zero();            ///< added to all samples [rad/s]
  Vec<3> specific_force_bias = Vec<3>::Zero();              ///< added to all samples [m/s^2]
  double gravity = 9.81;                                    ///< [m/s^2]

  void Validate() const;  ///< throws ParameterError
};

/// An inertial measurement unit at the CoM, aligned with B, with constant bias and white noise:
///     angular velocity = R_WB^T w_W + b_w + n_w,
///     specific force   = R_WB^T (a_W - g) + b_f + n_f,   g = (0, 0, -gravity).
/// At rest the specific force points up and is 9.81 m/s^2; in free fall it is 0.
///
///     ports in  platform      the true state
///               acceleration  the true acceleration
///     port out  measurement   sampled
class Imu final : public LeafSystem<ImuParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<PlatformState> platform{this, {"platform"}};
  InputPort<PlatformAcceleration> acceleration{this, {"acceleration"}};
  Random noise{this, "noise"};
  OutputPort<ImuMeasurement> measurement{this,
                                         {"measurement"},
                                         Sampled{params.rate},
                                         Uses(platform, acceleration, noise),
                                         &Imu::CalcMeasurement};

 private:
  ImuMeasurement CalcMeasurement(const PlatformState& platform, const PlatformAcceleration& acceleration,
                                 RandomStream& noise) const;
};

}  // namespace tenon
