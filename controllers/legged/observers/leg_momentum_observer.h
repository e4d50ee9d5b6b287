#pragma once

#include <tenon/controllers/legged/observers/disturbance_filter.h>
#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// Equations of motion of the legs in an observer.
enum class LegDynamics {
  kExact,   ///< the joints' rows of the floating-base dynamics, which forces on the trunk do not enter
  kThesis,  ///< decoupled from the trunk, neglecting forces on it; see DecoupledDynamics
};

/// Gains of LegMomentumObserver.
struct LegObserverGains {
  std::vector<double> gains;                     ///< K_1 ... K_r [1/s]; see GainsOfPolynomial
  std::optional<ButterworthDesign> butterworth;  ///< an alternative to `gains`
  LegDynamics dynamics = LegDynamics::kExact;
  double min_singular_value = 0.02;  ///< least singular value of a leg's Jacobian, see SolveFootForces [m]

  static FieldList Fields() {
    return {{"gains_per_s", &LegObserverGains::gains},
            {"butterworth", &LegObserverGains::butterworth},
            {"dynamics", &LegObserverGains::dynamics},
            Field("min_singular_value_m", &LegObserverGains::min_singular_value)
                .Positive()
                .Because("at 0 a straight leg is singular")};
  }
  /// K_1 ... K_r [1/s] from `gains` or `butterworth`. With neither, (100, 256): second order with a damping
  /// ratio of 0.8, with the noise and the lag of the first order at 100 rad/s, see docs/observers.md.
  std::vector<double> Gains() const;
  void Validate() const;  ///< throws ParameterError; the poles must be stable, see DemandHurwitz
};

struct LegMomentumObserverParams {
  QuadrupedDescription robot;  ///< model of the observer
  LegObserverGains gains;
  Rate rate = Hz(1000);
  void Validate() const;  ///< throws ParameterError
};

/// Estimates the joint torques of unknown external forces on a quadruped's legs, in swing or stance, from the
/// momentum of the legs (Morlando 2023, section 2.4.2, with any order r). The momentum rho changes by
///
///     rho' = alpha + F,   alpha = C^T nu - g + tau + sum_i J_i^T f_i        (joints' rows)
///
/// with a known part alpha and the unknown torques F. The estimator (2.10), (2.11), in which integrals over
/// an interval use its torque and the mean of C^T nu - g and J^T f at its ends, yields (2.9):
///
///     F_hat = K_1 K_2 ... K_r / (s^r + K_r s^(r-1) + K_r K_(r-1) s^(r-2) + ... ) F.
///
/// It is exact in time for an F that is constant over each interval. rho(0) is subtracted, so the observer
/// may start on a moving robot. `kExact` uses the joints' rows of the floating-base dynamics, p_j = S_j .
/// H_j, with gravity and without forces on the trunk; `kThesis` uses DecoupledDynamics, (2.6) and (2.7).
/// Other torques at the joints, such as friction, are part of the estimate.
///
/// The ground forces act where each foot's sphere touches the `ground` plane. The estimate is also output as
/// forces at the spheres' centres, J_leg^T f = F_hat for each leg (kThesis: J_q^T f = F_hat for all legs). In
/// a nearly singular leg, the component of f that hardly affects the joints tends to zero, see
/// SolveFootForces.
///
/// The estimate depends on the present state and foot forces and on the torque of the previous tick, so a
/// controller may use it for the torque of the same tick. If the order of the gains or the dynamics change
/// during a run, the estimator continues from the present estimate.
class LegMomentumObserver final : public LeafSystem<LegMomentumObserverParams> {
 public:
  using LeafSystem::LeafSystem;

  /// The momentum, the known part of its rate without the torque, and the state of the estimator.
  struct Memory {
    bool started = false;
    LegDynamics dynamics = LegDynamics::kExact;  ///< dynamics that `momentum` was computed with
    Vec<12> momentum = Vec<12>::Zero();
    Vec<12> known_rate = Vec<12>::Zero();
    DisturbanceFilter::Memory<12> estimator;

    static FieldList Fields() {
      return {{"started", &Memory::started},
              {"dynamics", &Memory::dynamics},
              {"momentum", &Memory::momentum},
              {"known_rate", &Memory::known_rate},
              {"estimator", &Memory::estimator}};
    }
  };

  InputPort<LeggedState> state{this, {"state"}};

 private:
  const QuadrupedModel model_{params.robot};
  Shared<QuadrupedDynamics> dynamics_{this, "dynamics", Uses(state), model_};

 public:
  InputPort<Vec<12>> torque{this, {"torque", "N m"}};
  InputPort<FootForces> foot_forces{this, {"foot_forces"}};
  InputPort<GroundPlane> ground{this, {"ground"}, GroundPlane()};
  Parameter<LegObserverGains> gains{
      this, {"gains"}, params.gains, "gains of the estimator and model of the legs' dynamics"};
  Shared<DisturbanceFilter> filter{this, "filter", Uses(gains), &LegMomentumObserver::CalcFilter};

  DiscreteState<Vec<12>> held_torque{
      this, {"held_torque", "N m", kJointElements}};  ///< torque of the last interval
  Update<Vec<12>> next_torque{held_torque, Sampled{params.rate}, Uses(torque),
                              [](const Vec<12>& torque_now) -> const Vec<12>& { return torque_now; }};
  Scratch<Memory> memory{this, "memory", Memory{.estimator = CalcFilter(params.gains).Start<12>()}};
  OutputPort<LegForceEstimate> estimate{
      this,
      {"estimate"},
      Sampled{params.rate},
      Uses(state, dynamics_, foot_forces, ground, held_torque, gains, filter, memory),
      &LegMomentumObserver::CalcEstimate};

 private:
  DisturbanceFilter CalcFilter(const LegObserverGains& gains) const {
    return {gains.Gains(), params.rate.period()};
  }
  LegForceEstimate CalcEstimate(const LeggedState& state, const QuadrupedDynamics& dynamics,
                                const FootForces& foot_forces, const GroundPlane& ground,
                                const Vec<12>& held_torque, const LegObserverGains& gains,
                                const DisturbanceFilter& filter, Memory& memory) const;
};

}  // namespace tenon
