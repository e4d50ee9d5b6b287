#pragma once

#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/systems/block.h>

namespace tenon {

/// Hysteresis of the stance detection, in normal force over the robot's weight.
struct ContactThresholds {
  double touch = 0.12;  ///< touchdown above this ratio; exceeds a 20 N push on the knee of a 21 kg robot
  double leave = 0.04;  ///< lift-off below this ratio

  static FieldList Fields() {
    return {Field("touch_weight_ratio", &ContactThresholds::touch).Finite(),
            Field("leave_weight_ratio", &ContactThresholds::leave).Positive()};
  }
  void Validate() const;  ///< throws ParameterError unless 0 < leave < touch
};

struct GroundForceObserverParams {
  QuadrupedDescription robot;  ///< model of the observer
  ContactThresholds thresholds = {};
  double gravity = kGravity;         ///< [m/s^2]
  double min_singular_value = 0.02;  ///< least singular value of a leg's Jacobian, see SolveFootForces [m]
  Rate rate = Hz(1000);
  void Validate() const;  ///< throws ParameterError
};

/// Ground forces of a robot without foot sensors. The joint torques F_i of a leg observer that knows no foot
/// forces are attributed to a force at the foot's contact point,
///
///     J_leg^T f_i = F_i
///
/// for stance legs; forces of swing legs are zero. A foot stands from when f_i . n rises above `touch` until
/// it falls below `leave`. Other external forces on a standing leg cannot be distinguished from its ground
/// force and are part of it.
class GroundForceObserver final : public LeafSystem<GroundForceObserverParams> {
 public:
  using LeafSystem::LeafSystem;

  InputPort<LeggedState> state{this, {"state"}};

 private:
  const QuadrupedModel model_{params.robot, params.gravity};
  Shared<QuadrupedDynamics> dynamics_{this, "dynamics", Uses(state), model_};

 public:
  InputPort<LegForceEstimate> leg_forces{this, {"leg_forces"}};
  InputPort<GroundPlane> ground{this, {"ground"}, GroundPlane()};
  Parameter<ContactThresholds> thresholds{
      this, {"thresholds"}, params.thresholds, "hysteresis of the stance detection"};
  Scratch<std::array<bool, kNumLegs>> stands{this, "stands", {true, true, true, true}};
  OutputPort<FootForces> forces{this,
                                {"forces"},
                                Sampled{params.rate},
                                Uses(dynamics_, leg_forces, ground, thresholds, stands),
                                &GroundForceObserver::CalcForces};

 private:
  FootForces CalcForces(QuadrupedDynamics dynamics, const LegForceEstimate& leg_forces,
                        const GroundPlane& ground, const ContactThresholds& thresholds,
                        std::array<bool, kNumLegs>& stands) const;
};

}  // namespace tenon
