#pragma once

#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/imu_signals.h>
#include <tenon/systems/block.h>
#include <tenon/systems/framework/types/diagonal_gains.h>

namespace tenon {

/// Source of the CoM's acceleration.
enum class ForceSource {
  kImu,       ///< the IMU of the trunk, and the CoM's velocity relative to it
  kMomentum,  ///< the CoM's velocity, which requires the trunk's velocity
};

/// Gains of ComObserver.
struct ComObserverGains {
  DiagonalGains force_bandwidth = 20;   ///< K_l, along the axes of W [rad/s]
  DiagonalGains torque_bandwidth = 20;  ///< K_a, about the axes of W [rad/s]
  ForceSource force_source = ForceSource::kImu;

  static FieldList Fields() {
    return {Field("force_bandwidth_rad_per_s", &ComObserverGains::force_bandwidth)
                .Positive()
                .Because("with 0 the estimate stays at its initial value"),
            Field("torque_bandwidth_rad_per_s", &ComObserverGains::torque_bandwidth)
                .Positive()
                .Because("with 0 the estimate stays at its initial value"),
            {"force_source", &ComObserverGains::force_source}};
  }
  void Validate() const;  ///< throws ParameterError unless K_l and K_a have 1 or 3 numbers
};

/// Gains that make ComObserver the centroidal momentum observer of Focchi et al. 2020: force and moment from
/// the momenta, at 25 and 10 rad/s.
inline ComObserverGains CentroidalMomentumObserver() {
  return {25, 10, ForceSource::kMomentum};
}

struct ComObserverParams {
  QuadrupedDescription robot;  ///< model of the observer
  ComObserverGains gains;
  Rate rate = Hz(1000);
  void Validate() const { robot.CheckMass(); }  ///< throws ParameterError
};

/// Estimates the net external wrench on a quadruped, without gravity and ground forces, about its centre of
/// mass x: the hybrid observer of Morlando 2023, section 2.4.2, in exact discrete form. With L the angular
/// momentum about x, and the ground forces f_i at p_i,
///
///     tau' = K_a (tau_ext - tau),   tau_ext = L' - sum_i (p_i - x) x f_i              (2.15) to (2.18)
///     f'   = K_l (f_ext - f),       f_ext   = m x'' + m g e_z - sum_i f_i             (2.19) to (2.21)
///
/// where each first-order filter is exact in time for a wrench that is constant over each interval. Neither
/// L' nor x'' is computed by differentiation: the filters need only their means over an interval, which are
/// differences of momenta. The mean of tau_ext is (L[n] - L[n-1]) / h minus the mean moment of the ground
/// forces at both ends.
///
/// **Force.** The trunk's velocity is poorly known, but the IMU at point I measures its specific force s, and
/// joint speeds and angular velocity yield the CoM's velocity u = x' - v_I relative to I. From
/// m (v_I' + g e_z) = m R_WB s follows
///
///     f_ext = m R_WB s + m u' - sum_i f_i,   the mean of u' being (u[n] - u[n-1]) / h,
///
/// with s and f_i at the start of the interval, when s is sampled: vibration of a stiff contact is in both
/// and cancels. Neither the velocity of the trunk, nor gravity, nor angular acceleration is needed.
/// `kMomentum` uses the mean of m x'' from x' itself, and the mean of f_i at both ends.
///
/// The ground forces act where each foot's sphere touches the `ground` plane. The wrench contains all
/// external forces except `known_wrench`, wherever they act; it does not depend on the estimates of other
/// observers.
///
/// The estimate depends on the present state and foot forces and on the IMU sample of the previous tick, so a
/// controller may use it for the torque of the same tick, which affects the IMU without delay. If
/// `gains.force_source` changes during a run, the filter continues from the present estimate.
class ComObserver final : public LeafSystem<ComObserverParams> {
 public:
  using LeafSystem::LeafSystem;

  /// Values of the last tick.
  struct Memory {
    bool started = false;
    ForceSource force_source = ForceSource::kImu;
    Vec<3> linear = Vec<3>::Zero();   ///< m u, or m x' [kg m/s]
    Vec<3> angular = Vec<3>::Zero();  ///< L [kg m^2/s]
    Vec<3> ground = Vec<3>::Zero();   ///< sum of the ground forces [N]
    Vec<3> moment = Vec<3>::Zero();   ///< moment of the ground forces about x [N m]
    WrenchEstimate known;
    WrenchEstimate estimate;

    static FieldList Fields() {
      return {{"started", &Memory::started},    {"force_source", &Memory::force_source},
              {"linear", &Memory::linear},      {"angular", &Memory::angular},
              {"ground", &Memory::ground, "N"}, {"moment", &Memory::moment, "N m"},
              {"known", &Memory::known},        {"estimate", &Memory::estimate}};
    }
  };

  InputPort<LeggedState> state{this, {"state"}};

 private:
  const QuadrupedModel model_{params.robot};
  Shared<QuadrupedDynamics> dynamics_{this, "dynamics", Uses(state), model_};

 public:
  InputPort<FootForces> foot_forces{this, {"foot_forces"}};
  InputPort<GroundPlane> ground{this, {"ground"}, GroundPlane()};
  InputPort<ImuMeasurement> imu{this, {"imu"}};
  InputPort<WrenchEstimate> known_wrench{this, {"known_wrench"}, WrenchEstimate()};
  Parameter<ComObserverGains> gains{
      this, {"gains"}, params.gains, "bandwidths of the filters and source of the force"};

  DiscreteState<Vec<3>> specific_force_W{this,
                                         {"specific_force_W", "m/s^2"}};  ///< at the start of the interval
  Update<Vec<3>> next_specific_force{
      specific_force_W, Sampled{params.rate}, Uses(state, imu),
      [](const LeggedState& x, const ImuMeasurement& u) -> Vec<3> { return x.R_WB() * u.specific_force_B; }};
  Scratch<Memory> memory{this, "memory", Memory()};
  OutputPort<WrenchEstimate> estimate{
      this,
      {"estimate"},
      Sampled{params.rate},
      Uses(state, dynamics_, foot_forces, ground, specific_force_W, known_wrench, gains, memory),
      &ComObserver::CalcEstimate};

 private:
  WrenchEstimate CalcEstimate(const LeggedState& state, const QuadrupedDynamics& dynamics,
                              const FootForces& foot_forces, const GroundPlane& ground,
                              const Vec<3>& specific_force_W, const WrenchEstimate& known,
                              const ComObserverGains& gains, Memory& memory) const;
};

}  // namespace tenon
