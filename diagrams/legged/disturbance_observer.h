#pragma once

#include <tenon/diagrams/legged/locomotion_profile.h>
#include <tenon/systems/framework/diagram/diagram_builder.h>

namespace tenon {

/// Estimates the disturbances that a whole-body controller compensates, with the observers of an
/// ObserverKind. Outputs that the kind does not estimate are zero.
///
///     state, torque, foot_forces ──► legs or ndo ──► leg_forces
///     state, foot_forces, imu ─────► com ──────────► wrench
///
/// The outputs have feedthrough from state and foot forces only. `torque` and `imu` act one tick later, so
/// that the controller that computes the torque can use the estimates without an algebraic loop. `wrench`
/// does not contain `known_wrench`, a wrench on the trunk; it is zero if not connected.
class DisturbanceObserver final : public Subdiagram {
 public:
  explicit DisturbanceObserver(const DisturbanceObserverParams& params);

  InputPort<LeggedState> state{this, {"state"}};
  InputPort<Vec<12>> torque{this, {"torque", "N m"}};
  InputPort<FootForces> foot_forces{this, {"foot_forces"}};
  InputPort<ImuMeasurement> imu{this, {"imu"}};
  InputPort<GroundPlane> ground{this, {"ground"}, GroundPlane()};
  InputPort<WrenchEstimate> known_wrench{this, {"known_wrench"}, WrenchEstimate()};

  LegMomentumObserver* legs = nullptr;          ///< null except for kLegs and kHybrid
  NonlinearDisturbanceObserver* ndo = nullptr;  ///< null except for kNdoM, kNdoInverse and kNdoHybrid
  ComObserver* com = nullptr;                   ///< null except for kCom, kHybrid, kFocchi and kNdoHybrid

  OutputPort<WrenchEstimate> wrench{this, {"wrench"}};
  OutputPort<LegForceEstimate> leg_forces{this, {"leg_forces"}};
};

}  // namespace tenon
