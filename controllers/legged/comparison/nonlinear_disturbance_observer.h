#pragma once

#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/systems/block.h>
#include <tenon/systems/framework/types/diagonal_gains.h>

namespace tenon {

/// Gain matrix Lambda of the observer in terms of X; publications differ.
enum class NdoReading {
  kM,        ///< Lambda = X M_q^-1
  kInverse,  ///< Lambda = X^-1 M_q^-1
};

struct NonlinearDisturbanceObserverParams {
  QuadrupedDescription robot;  ///< model of the observer
  NdoReading reading = NdoReading::kM;
  DiagonalGains gain = 10;           ///< X of each joint [N m s/rad], or its inverse [rad/(N m s)]
  double min_singular_value = 0.02;  ///< least singular value of a leg's Jacobian, see SolveFootForces [m]
  Rate rate = Hz(1000);
  void Validate() const;  ///< throws ParameterError
};

/// The nonlinear disturbance observer that Morlando 2023 compares the leg momentum observer with, in the
/// decoupled coordinates of the legs (DecoupledDynamics):
///
///     M_q qdd + C_q nu = tau + J_q^T f + F,
///     F_hat = z + p,   p = x qd,   Lambda = x M_q^-1,
///     z' = -Lambda z + Lambda (C_q nu - tau - J_q^T f - p),
///
/// with the diagonal matrix x = X or X^-1, so that F_hat' = Lambda (F - F_hat), a first-order filter whose
/// bandwidth grows as the inertia of the legs falls. It is discretised with step h by the implicit Euler
/// method, which is stable for all x:
///
///     F_hat[n] = F_hat[n-1] + x (M_q + x h)^-1 (M_q (qd[n] - qd[n-1]) + h (C_q nu - tau - J_q^T f
///                - F_hat[n-1])),
///
/// where tau is the torque of the interval and C_q nu - J_q^T f the mean of its ends. The first tick only
/// stores its values, so the observer may start on a moving robot. LegMomentumObserver with
/// LegDynamics::kThesis has equal ports and converts F_hat to foot forces in the same way.
///
/// `gain` and `min_singular_value` are Parameters: a run can change them.
class NonlinearDisturbanceObserver final : public LeafSystem<NonlinearDisturbanceObserverParams> {
 public:
  using LeafSystem::LeafSystem;

  /// Values of the last tick.
  struct Memory {
    bool started = false;
    Vec<12> qd = Vec<12>::Zero();
    Vec<12> known_torque = Vec<12>::Zero();  ///< J_q^T f - C_q nu
    Vec<12> estimate = Vec<12>::Zero();

    static FieldList Fields() {
      return {{"started", &Memory::started},
              {"qd", &Memory::qd},
              {"known_torque", &Memory::known_torque},
              {"estimate", &Memory::estimate}};
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
  Parameter<DiagonalGains> gain{
      this, {"gain"}, params.gain, "observer gain X [N m s/rad], or its inverse", Range().Positive()};
  Parameter<double> min_singular_value{
      this,
      {"min_singular_value", "m"},
      params.min_singular_value,
      "lower bound of a leg's singular values, below which its foot force is damped",
      Range().Positive()};

  DiscreteState<Vec<12>> held_torque{
      this, {"held_torque", "N m", kJointElements}};  ///< torque of the last interval
  Update<Vec<12>> next_torque{held_torque, Sampled{params.rate}, Uses(torque),
                              [](const Vec<12>& torque_now) -> const Vec<12>& { return torque_now; }};
  Scratch<Memory> memory{this, "memory", Memory()};
  OutputPort<LegForceEstimate> estimate{
      this,
      {"estimate"},
      Sampled{params.rate},
      Uses(state, dynamics_, foot_forces, ground, held_torque, gain, min_singular_value, memory),
      &NonlinearDisturbanceObserver::CalcEstimate};

 private:
  LegForceEstimate CalcEstimate(const LeggedState& state, const QuadrupedDynamics& dynamics,
                                const FootForces& foot_forces, const GroundPlane& ground,
                                const Vec<12>& held_torque, const DiagonalGains& gain,
                                double min_singular_value, Memory& memory) const;
};

}  // namespace tenon
