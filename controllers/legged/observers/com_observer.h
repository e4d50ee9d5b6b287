#pragma once

#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/ground_plane.h>
#include <tenon/plants/signals/imu_signals.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

#include <array>

namespace tenon {

/// What an observer takes the acceleration of the centre of mass from.
enum class ForceSource {
  kImu,       ///< the inertial unit of the trunk, and the legs' motion relative to it
  kMomentum,  ///< the velocity of the centre of mass, which the trunk's must be known for
};
constexpr auto EnumNames(ForceSource) {
  return std::array{Named{ForceSource::kImu, "imu"}, Named{ForceSource::kMomentum, "momentum"}};
}

/// What is tuned of an observer of the net wrench.
struct ComObserverGains {
  double force_bandwidth = 20;   ///< K_l [rad/s]
  double torque_bandwidth = 20;  ///< K_a [rad/s]
  ForceSource force_source = ForceSource::kImu;

  static FieldList Fields() {
    return {{"force_bandwidth_rad_per_s", &ComObserverGains::force_bandwidth},
            {"torque_bandwidth_rad_per_s", &ComObserverGains::torque_bandwidth},
            {"force_source", &ComObserverGains::force_source}};
  }
  void Validate() const;  ///< throws ParameterError
};

/// With these a ComObserver is the centroidal momentum observer of Focchi et al. 2020: force and torque from
/// the momenta, with gains of 25 and 10 rad/s.
constexpr ComObserverGains CentroidalMomentumObserver() {
  return {25, 10, ForceSource::kMomentum};
}

struct ComObserverParams {
  QuadrupedDescription robot;  ///< what the observer believes
  ComObserverGains gains;
  Rate rate = Hz(1000);
  void Validate() const;  ///< throws ParameterError
};

/// Estimates the net wrench on a quadruped of everything but gravity and the ground, about its centre of mass
/// x: the hybrid observer of Morlando 2023, section 2.4.2, in its exact form. With L the angular momentum
/// about x, and the ground's forces f_i at p_i,
///
///     tau' = K_a (tau_ext - tau),   tau_ext = L' - sum_i (p_i - x) x f_i              (2.15) to (2.18)
///     f'   = K_l (f_ext - f),       f_ext   = m x'' + m g e_z - sum_i f_i             (2.19) to (2.21)
///
/// each first-order filter being exact in time for a wrench that is constant in each interval. Neither L' nor
/// x'' is differentiated: a filter needs their means over an interval only, and these are differences of
/// momenta. So tau_ext has the mean (L[n] - L[n-1]) / h minus the mean moment of the ground at the ends.
///
/// **Force.** The trunk's velocity is hard to know, but its specific force s is measured at the point I of
/// the inertial unit, and the centre of mass moves relative to I with a velocity u = x' - v_I that joint
/// speeds and angular velocity tell. So, from m (v_I' + g e_z) = m R_WB s,
///
///     f_ext = m R_WB s + m u' - sum_i f_i,   the mean of u' being (u[n] - u[n-1]) / h,
///
/// with the inertial unit and the ground at the instant of the unit's sample, the start of the interval: the
/// shaking of a stiff contact is in both and cancels. No velocity of the trunk, no gravity and no angular
/// acceleration is needed. `kMomentum` takes the mean of m x'' from x' itself, and that of f_i from both
/// ends.
///
/// The ground's forces act where each foot's sphere touches the plane that is told. All forces of the
/// surroundings are in the wrench, wherever they act; estimates of other observers do not enter.
///
///     | port        | kind            | type                                      |
///     | state       | input           | LeggedState; v_W is read by kMomentum only |
///     | foot_forces | input           | FootForces                                |
///     | ground      | input           | GroundPlane; level if not connected       |
///     | imu         | input           | ImuMeasurement                            |
///     | estimate    | output, sampled | WrenchEstimate                            |
///     | gains       | parameter       | ComObserverGains                          |
///
/// The estimate depends on the present state and foot forces, and on the inertial unit one tick ago, so that
/// a controller may use it for the torque of the same tick, which the unit feels at once. Another source of
/// the force that is set in a run goes on from the present estimate.
class ComObserver final : public LeafSystem<ComObserverParams> {
 public:
  using LeafSystem::LeafSystem;

  /// Of the last tick.
  struct Memory {
    bool started = false;
    ForceSource force_source = ForceSource::kImu;
    Vec<3> linear = Vec<3>::Zero();   ///< m u, or m x' [kg m/s]
    Vec<3> angular = Vec<3>::Zero();  ///< L [kg m^2/s]
    Vec<3> ground = Vec<3>::Zero();   ///< force [N]
    Vec<3> moment = Vec<3>::Zero();   ///< of the ground about x [N m]
    WrenchEstimate estimate;

    static FieldList Fields() {
      return {{"started", &Memory::started},    {"force_source", &Memory::force_source},
              {"linear", &Memory::linear},      {"angular", &Memory::angular},
              {"ground", &Memory::ground, "N"}, {"moment", &Memory::moment, "N m"},
              {"estimate", &Memory::estimate}};
    }
  };

 private:
  const QuadrupedModel model_{params.robot};

 public:
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<FootForces> foot_forces{this, {"foot_forces"}};
  InputPort<GroundPlane> ground{this, {"ground"}, GroundPlane()};
  InputPort<ImuMeasurement> imu{this, {"imu"}};
  Parameter<ComObserverGains> gains{this, {"gains"}, params.gains, "bandwidths, and the source of the force"};

  DiscreteState<Vec<3>> specific_force_W{this, {"specific_force_W", "m/s^2"}};  ///< when the interval began
  Update<Vec<3>> next_specific_force{specific_force_W, Sampled{params.rate}, Uses(state, imu),
                                     [](const LeggedState& state, const ImuMeasurement& imu) -> Vec<3> {
                                       return state.R_WB() * imu.specific_force_B;
                                     }};
  Scratch<Memory> memory{this, "memory", Memory()};
  OutputPort<WrenchEstimate> estimate{this,
                                      {"estimate"},
                                      Sampled{params.rate},
                                      Uses(state, foot_forces, ground, specific_force_W, gains, memory),
                                      &ComObserver::CalcEstimate};

 private:
  WrenchEstimate CalcEstimate(const LeggedState& state, const FootForces& foot_forces,
                              const GroundPlane& ground, const Vec<3>& specific_force_W,
                              const ComObserverGains& gains, Memory& memory) const;
};

}  // namespace tenon
