#pragma once

#include <tenon/controllers/legged/observers/disturbance_filter.h>
#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/ground_plane.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

#include <array>
#include <optional>
#include <vector>

namespace tenon {

/// Which equations of motion an observer takes for the legs.
enum class LegDynamics {
  kExact,   ///< the joints' rows of the floating robot: forces on the trunk do not appear in them
  kThesis,  ///< decoupled from the trunk, whose disturbances are neglected
};
constexpr auto EnumNames(LegDynamics) {
  return std::array{Named{LegDynamics::kExact, "exact"}, Named{LegDynamics::kThesis, "thesis"}};
}

/// What is tuned of a leg observer.
struct LegObserverGains {
  std::vector<double> gains;                     ///< K_1 ... K_r [1/s]; see GainsOfPolynomial
  std::optional<ButterworthDesign> butterworth;  ///< instead of `gains`
  LegDynamics dynamics = LegDynamics::kExact;
  double min_singular_value = 0.02;  ///< of a leg's Jacobian; below, its foot force is damped [m]

  static FieldList Fields() {
    return {{"gains_per_s", &LegObserverGains::gains},
            {"butterworth", &LegObserverGains::butterworth},
            {"dynamics", &LegObserverGains::dynamics},
            {"min_singular_value_m", &LegObserverGains::min_singular_value}};
  }
  /// K_1 ... K_r [1/s], given or designed. With neither, (100, 256): a second order with a damping of 0.8
  /// that settles fast; noise and lag are those of the first order at 100 rad/s, see docs/observers.md.
  std::vector<double> Gains() const;
  void Validate() const;  ///< throws ParameterError; the poles must be stable, see DemandHurwitz
};

struct LegMomentumObserverParams {
  QuadrupedDescription robot;  ///< what the observer believes
  LegObserverGains gains;
  Rate rate = Hz(1000);
  void Validate() const;  ///< throws ParameterError
};

/// Estimates what unknown forces do to the joints of a quadruped's legs, swinging or standing, from the
/// momentum of the legs (Morlando 2023, section 2.4.2, of any order r). Of the momentum rho the known part is
///
///     rho' = alpha + F,   alpha = C^T nu - g + tau + sum_i J_i^T f_i        (joints' rows)
///
/// and the estimator (2.10), (2.11) of the torques F that are left, in which integrals over each interval
/// take the torque of that interval and the mean of C^T nu - g and J^T f at its ends, gives (2.9):
///
///     F_hat = K_1 K_2 ... K_r / (s^r + K_r s^(r-1) + K_r K_(r-1) s^(r-2) + ... ) F.
///
/// It is exact in time for an F that is constant in each interval. rho(0) is subtracted, so that it may start
/// on a moving robot. `kExact` uses the rows of the floating robot, p_j = S_j . H_j, in which gravity appears
/// and forces on the trunk do not; `kThesis` those of DecoupledDynamics, (2.6) and (2.7). Whatever else acts
/// at the joints, say their friction, is part of the estimate.
///
/// The ground's forces act where each foot's sphere touches the plane that is told. The estimate is also told
/// as forces at the spheres' centres, J_leg^T f = F_hat for each leg (kThesis: J_q^T f = F_hat for all). Near
/// a singular leg, one that is straight, say, the part of f that the joints hardly feel goes to zero instead
/// of to infinity, see SolveFootForces.
///
///     | port        | kind            | type             |
///     | state       | input           | LeggedState      |
///     | torque      | input           | Vec<12> [N m]    |
///     | foot_forces | input           | FootForces       |
///     | ground      | input           | GroundPlane; level if not connected |
///     | estimate    | output, sampled | LegForceEstimate |
///     | gains       | parameter       | LegObserverGains |
///
/// The estimate depends on the present state and foot forces, and on the torque as it was set one tick ago,
/// so that a controller may use it for the torque of the same tick. Gains of another order, or other
/// dynamics, that are set in a run go on from the present estimate.
class LegMomentumObserver final : public LeafSystem<LegMomentumObserverParams> {
 public:
  using LeafSystem::LeafSystem;

  /// The momentum, what is known of its rate without the torque, and the estimator.
  struct Memory {
    bool started = false;
    LegDynamics dynamics = LegDynamics::kExact;  ///< that the momentum is of
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

 private:
  const QuadrupedModel model_{params.robot};

 public:
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<Vec<12>> torque{this, {"torque", "N m"}};
  InputPort<FootForces> foot_forces{this, {"foot_forces"}};
  InputPort<GroundPlane> ground{this, {"ground"}, GroundPlane()};
  Parameter<LegObserverGains> gains{
      this, {"gains"}, params.gains, "of the estimator, and the dynamics that it takes"};
  Shared<DisturbanceFilter> filter{this, "filter", Uses(gains), &LegMomentumObserver::CalcFilter};

  DiscreteState<Vec<12>> held_torque{this,
                                     {"held_torque", "N m", kJointElements}};  ///< of the interval that ends
  Update<Vec<12>> next_torque{held_torque, Sampled{params.rate}, Uses(torque),
                              [](const Vec<12>& torque) -> const Vec<12>& { return torque; }};
  Scratch<Memory> memory{this, "memory", Memory{.estimator = CalcFilter(params.gains).Start<12>()}};
  OutputPort<LegForceEstimate> estimate{this,
                                        {"estimate"},
                                        Sampled{params.rate},
                                        Uses(state, foot_forces, ground, held_torque, gains, filter, memory),
                                        &LegMomentumObserver::CalcEstimate};

 private:
  DisturbanceFilter CalcFilter(const LegObserverGains& gains) const;
  LegForceEstimate CalcEstimate(const LeggedState& state, const FootForces& foot_forces,
                                const GroundPlane& ground, const Vec<12>& held_torque,
                                const LegObserverGains& gains, const DisturbanceFilter& filter,
                                Memory& memory) const;
};

}  // namespace tenon
