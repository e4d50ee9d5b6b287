#include <tenon/diagrams/legged/disturbance_observer.h>
#include <tenon/diagrams/legged/foot_forces_of_legs.h>
#include <tenon/systems/primitives/constant.h>
#include <tenon/systems/primitives/unit_delay.h>

namespace tenon {

DisturbanceObserver::DisturbanceObserver(const DisturbanceObserverParams& params) {
  const ObserverKind kind = params.kind;
  const auto connect = [this](auto& observer) {
    Connect(state, observer.state);
    if constexpr (requires { observer.torque; }) Connect(torque, observer.torque);
    Connect(foot_forces, observer.foot_forces);
    Connect(ground, observer.ground);
  };
  if (kind == ObserverKind::kLegs || kind == ObserverKind::kHybrid) {
    legs = &Add<LegMomentumObserver>("legs", params.legs);
    connect(*legs);
    Connect(legs->estimate, leg_forces);
  } else if (kind == ObserverKind::kNdoM || kind == ObserverKind::kNdoInverse ||
             kind == ObserverKind::kNdoHybrid) {
    NonlinearDisturbanceObserverParams reading = params.ndo;
    reading.reading = kind == ObserverKind::kNdoInverse ? NdoReading::kInverse : NdoReading::kM;
    ndo = &Add<NonlinearDisturbanceObserver>("ndo", reading);
    connect(*ndo);
    Connect(ndo->estimate, leg_forces);
  } else {
    Connect(Add<ConstantSource<LegForceEstimate>>("no_leg_forces").y, leg_forces);
  }
  if (kind == ObserverKind::kCom || kind == ObserverKind::kHybrid || kind == ObserverKind::kFocchi ||
      kind == ObserverKind::kNdoHybrid) {
    ComObserverParams of_kind = params.com;
    if (kind == ObserverKind::kFocchi) of_kind.gains = params.focchi;
    com = &Add<ComObserver>("com", of_kind);
    connect(*com);
    Connect(imu, com->imu);
    Connect(known_wrench, com->known_wrench);
    Connect(com->estimate, wrench);
  } else {
    Connect(Add<ConstantSource<WrenchEstimate>>("no_wrench").y, wrench);
  }
}

FootForcesOfLegs::FootForcesOfLegs(const FootForcesOfLegsParams& params)
    : legs(Add<LegMomentumObserver>(
          "legs",
          LegMomentumObserverParams{.robot = params.robot, .gains = params.gains, .rate = params.rate})),
      ground_forces(Add<GroundForceObserver>(
          "ground_forces", GroundForceObserverParams{.robot = params.robot,
                                                     .thresholds = params.thresholds,
                                                     .min_singular_value = params.gains.min_singular_value,
                                                     .rate = params.rate})) {
  auto& last_state = Add<UnitDelay<LeggedState>>(
      "last_state", UnitDelayParams<LeggedState>{.initial = params.initial, .rate = params.rate});
  auto& last_torque =
      Add<UnitDelay<Vec<12>>>("last_torque", UnitDelayParams<Vec<12>>{.rate = params.rate, .unit = "N m"});
  auto& last_ground =
      Add<UnitDelay<GroundPlane>>("last_ground", UnitDelayParams<GroundPlane>{.rate = params.rate});
  Connect(state, last_state.u);
  Connect(torque, last_torque.u);
  Connect(ground, last_ground.u);

  Connect(last_state.y, legs.state);
  Connect(last_torque.y, legs.torque);
  Connect(Add<ConstantSource<FootForces>>("no_foot_forces").y, legs.foot_forces);
  Connect(last_state.y, ground_forces.state);
  Connect(legs.estimate, ground_forces.leg_forces);
  Connect(last_ground.y, ground_forces.ground);
  Connect(ground_forces.forces, forces);
}

}  // namespace tenon
