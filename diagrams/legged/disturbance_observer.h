#pragma once

#include <tenon/controllers/legged/observers/com_observer.h>
#include <tenon/controllers/legged/observers/leg_momentum_observer.h>
#include <tenon/controllers/legged/observers/nonlinear_disturbance_observer.h>
#include <tenon/systems/framework/diagram_builder.h>

#include <array>

namespace tenon {

/// Which estimates a controller is given.
enum class ObserverKind {
  kNone,        ///< zeros
  kLegs,        ///< of the legs
  kCom,         ///< of the net wrench
  kHybrid,      ///< both
  kFocchi,      ///< of the net wrench by CentroidalMomentumObserver
  kNdoM,        ///< of the legs by NonlinearDisturbanceObserver, reading kM
  kNdoInverse,  ///< the same, reading kInverse
};
constexpr auto EnumNames(ObserverKind) {
  return std::array{Named{ObserverKind::kNone, "none"},
                    Named{ObserverKind::kLegs, "legs"},
                    Named{ObserverKind::kCom, "com"},
                    Named{ObserverKind::kHybrid, "hybrid"},
                    Named{ObserverKind::kFocchi, "focchi"},
                    Named{ObserverKind::kNdoM, "ndo_m"},
                    Named{ObserverKind::kNdoInverse, "ndo_inverse"}};
}

/// The kind decides which of the blocks there are; `focchi` takes its gains from CentroidalMomentumObserver,
/// and the reading of `ndo` is the kind's.
struct DisturbanceObserverParams {
  ObserverKind kind = ObserverKind::kHybrid;
  LegMomentumObserverParams legs;
  ComObserverParams com;
  NonlinearDisturbanceObserverParams ndo;
};

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

  LegMomentumObserver* legs = nullptr;          ///< for kLegs and kHybrid
  NonlinearDisturbanceObserver* ndo = nullptr;  ///< for kNdoM and kNdoInverse
  ComObserver* com = nullptr;                   ///< for kCom, kHybrid and kFocchi

  OutputPort<WrenchEstimate> wrench{this, {"wrench"}};
  OutputPort<LegForceEstimate> leg_forces{this, {"leg_forces"}};
};

}  // namespace tenon
