#pragma once

#include <tenon/plants/model/rigid_inertia.h>
#include <tenon/plants/signals/cdpr_signals.h>
#include <tenon/plants/signals/imu_signals.h>
#include <tenon/plants/signals/legged_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// Inertial unit. The defaults model a small industrial one without bias.
struct ImuParams {
  Rate rate = Hz(1000);  ///< sample rate
  Vec<3> p_B =
      Vec<3>::Zero();  ///< position in B; QuadrupedWorld uses imu_B of the robot, CdprEstimator 0 [m]
  Vec<3> angular_velocity_noise = Vec<3>::Constant(0.005);  ///< standard deviation per axis [rad/s]
  Vec<3> specific_force_noise = Vec<3>::Constant(0.05);     ///< standard deviation per axis [m/s^2]
  Vec<3> angular_velocity_bias = Vec<3>::Zero();            ///< added to all samples [rad/s]
  Vec<3> specific_force_bias = Vec<3>::Zero();              ///< added to all samples [m/s^2]
  double gravity = kGravity;                                ///< [m/s^2]

  static FieldList Fields() {
    using P = ImuParams;
    return {{"rate_hz", &P::rate},
            Undescribed("p_B", &P::p_B).Finite(),
            Field("angular_velocity_noise_rad_per_s", &P::angular_velocity_noise).AtLeast(0).Uniform(),
            Field("angular_velocity_bias_rad_per_s", &P::angular_velocity_bias).Finite(),
            Field("acceleration_noise_m_per_s2", &P::specific_force_noise).AtLeast(0).Uniform(),
            Field("acceleration_bias_m_per_s2", &P::specific_force_bias).Finite(),
            Undescribed("gravity", &P::gravity).Finite()};
  }
};

/// An inertial measurement unit at the point p_B, aligned with B, with constant bias and white noise:
///
///     angular velocity = R_WB^T w_W + b_w + n_w,
///     specific force   = R_WB^T (a_W + alpha_W x r + w_W x (w_W x r) - g) + b_f + n_f,
///
/// with r = R_WB p_B and g = (0, 0, -gravity).
/// The specific force is 9.81 m/s^2 upwards at rest and 0 in free fall.
///
/// Imu is for the platform of a cable robot, TrunkImu for the trunk of a quadruped.
template <class State, class Acceleration>
class BasicImu final : public LeafSystem<ImuParams> {
 public:
  using LeafSystem::LeafSystem;
  InputPort<State> body{this, {"body"}};
  InputPort<Acceleration> acceleration{this, {"acceleration"}};
  Parameter<Vec<3>> angular_velocity_noise{this,
                                           {"angular_velocity_noise", "rad/s"},
                                           params.angular_velocity_noise,
                                           "standard deviation per axis"};
  Parameter<Vec<3>> specific_force_noise{
      this, {"specific_force_noise", "m/s^2"}, params.specific_force_noise, "standard deviation per axis"};
  Parameter<Vec<3>> angular_velocity_bias{
      this, {"angular_velocity_bias", "rad/s"}, params.angular_velocity_bias, "bias of all samples"};
  Parameter<Vec<3>> specific_force_bias{
      this, {"specific_force_bias", "m/s^2"}, params.specific_force_bias, "bias of all samples"};
  Random noise{this, "noise"};
  OutputPort<ImuMeasurement> measurement{
      this,
      {"measurement"},
      Sampled{params.rate},
      Uses(body, acceleration, angular_velocity_noise, specific_force_noise, angular_velocity_bias,
           specific_force_bias, noise),
      &BasicImu::CalcMeasurement};

 private:
  ImuMeasurement CalcMeasurement(const State& body, const Acceleration& acceleration,
                                 const Vec<3>& angular_velocity_noise, const Vec<3>& specific_force_noise,
                                 const Vec<3>& angular_velocity_bias, const Vec<3>& specific_force_bias,
                                 RandomStream& noise) const;
};

using Imu = BasicImu<PlatformState, PlatformAcceleration>;
using TrunkImu = BasicImu<LeggedState, LeggedAcceleration>;
extern template class BasicImu<PlatformState, PlatformAcceleration>;
extern template class BasicImu<LeggedState, LeggedAcceleration>;

}  // namespace tenon
