#pragma once

#include <tenon/plants/model/gravity.h>
#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/signals/disturbance_signals.h>
#include <tenon/plants/signals/ground_plane.h>
#include <tenon/systems/framework/block/parameter.h>
#include <tenon/systems/framework/block/ports.h>
#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/framework/block/system.h>

#include <array>

namespace tenon {

/// When a foot stands, by the part of its force that presses it on the ground, over the robot's weight.
struct ContactThresholds {
  double touch = 0.12;  ///< a foot with more has touched down: no push of 20 N on a knee of 21 kg looks so
  double leave = 0.04;  ///< and one with less has left

  static FieldList Fields() {
    return {{"touch_weight_ratio", &ContactThresholds::touch},
            {"leave_weight_ratio", &ContactThresholds::leave}};
  }
  void Validate() const;  ///< throws ParameterError unless 0 < leave < touch
};

struct GroundForceObserverParams {
  QuadrupedDescription robot;  ///< what the observer believes
  ContactThresholds thresholds = {};
  double gravity = kGravity;         ///< [m/s^2]
  double min_singular_value = 0.02;  ///< of a leg's Jacobian, as in LegMomentumObserver [m]
  Rate rate = Hz(1000);
  void Validate() const;  ///< throws ParameterError
};

/// The forces of the ground of a robot without sensors in its feet: what acts on the joints of its legs, as a
/// leg observer that knows of no foot forces tells it, taken for a force F_i where the foot touches the
/// ground,
///
///     J_leg^T f_i = F_i,
///
/// of the legs that stand, zero of the others. A foot stands from when f_i . n rises above `touch` until it
/// falls below `leave`. Whatever else pushes a standing leg is in its force, and nobody can tell it apart.
///
///     | port       | kind            | type                                                              |
///     | state      | input           | LeggedState                                                       |
///     | leg_forces | input           | LegForceEstimate of a LegMomentumObserver told of no foot forces  |
///     | ground     | input           | GroundPlane; level if not connected                               |
///     | forces     | output, sampled | FootForces in W [N]                                               |
///     | thresholds | parameter       | ContactThresholds                                                 |
class GroundForceObserver final : public LeafSystem<GroundForceObserverParams> {
 public:
  using LeafSystem::LeafSystem;

 private:
  const QuadrupedModel model_{params.robot, params.gravity};

 public:
  InputPort<LeggedState> state{this, {"state"}};
  InputPort<LegForceEstimate> leg_forces{this, {"leg_forces"}};
  InputPort<GroundPlane> ground{this, {"ground"}, GroundPlane()};
  Parameter<ContactThresholds> thresholds{this, {"thresholds"}, params.thresholds, "when a foot stands"};
  Scratch<std::array<bool, kNumLegs>> stands{this, "stands", {true, true, true, true}};
  OutputPort<FootForces> forces{this,
                                {"forces"},
                                Sampled{params.rate},
                                Uses(state, leg_forces, ground, thresholds, stands),
                                &GroundForceObserver::CalcForces};

 private:
  FootForces CalcForces(const LeggedState& state, const LegForceEstimate& leg_forces,
                        const GroundPlane& ground, const ContactThresholds& thresholds,
                        std::array<bool, kNumLegs>& stands) const;
};

}  // namespace tenon
