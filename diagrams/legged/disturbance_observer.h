#pragma once

#include <tenon/diagrams/legged/locomotion_profile.h>
#include <tenon/systems/framework/diagram/diagram_builder.h>

namespace tenon {

/// The estimates that a whole-body controller takes off, by an observer of one's choice. What the kind does
/// not estimate is zero.
///
///     state, torque, foot_forces ──► legs or ndo ──► leg_forces
///     state, foot_forces, imu ─────► com ──────────► wrench
///
/// Torque and inertial unit take effect a tick later, state and foot forces at once: so the controller whose
/// torque it is may use the estimates.
class DisturbanceObserver final : public Subdiagram {
 public:
  explicit DisturbanceObserver(const DisturbanceObserverParams& params);

  InputPort<LeggedState> state{this, {"state"}};
  InputPort<Vec<12>> torque{this, {"torque", "N m"}};
  InputPort<FootForces> foot_forces{this, {"foot_forces"}};
  InputPort<ImuMeasurement> imu{this, {"imu"}};
  InputPort<GroundPlane> ground{this, {"ground"}, GroundPlane()};

  LegMomentumObserver* legs = nullptr;          ///< for kLegs and kHybrid
  NonlinearDisturbanceObserver* ndo = nullptr;  ///< for kNdoM and kNdoInverse
  ComObserver* com = nullptr;                   ///< for kCom, kHybrid and kFocchi

  OutputPort<WrenchEstimate> wrench{this, {"wrench"}};
  OutputPort<LegForceEstimate> leg_forces{this, {"leg_forces"}};
};

}  // namespace tenon
