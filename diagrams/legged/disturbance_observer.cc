#include <tenon/diagrams/legged/disturbance_observer.h>
#include <tenon/systems/primitives/constant.h>

namespace tenon {

DisturbanceObserver::DisturbanceObserver(const DisturbanceObserverParams& params) {
  const ObserverKind kind = params.kind;
  if (kind == ObserverKind::kLegs || kind == ObserverKind::kHybrid) {
    legs = &Add<LegMomentumObserver>("legs", params.legs);
    Connect(state, legs->state);
    Connect(torque, legs->torque);
    Connect(foot_forces, legs->foot_forces);
    Connect(ground, legs->ground);
    Connect(legs->estimate, leg_forces);
  } else if (kind == ObserverKind::kNdoM || kind == ObserverKind::kNdoInverse ||
             kind == ObserverKind::kNdoHybrid) {
    NonlinearDisturbanceObserverParams reading = params.ndo;
    reading.reading = kind == ObserverKind::kNdoInverse ? NdoReading::kInverse : NdoReading::kM;
    ndo = &Add<NonlinearDisturbanceObserver>("ndo", reading);
    Connect(state, ndo->state);
    Connect(torque, ndo->torque);
    Connect(foot_forces, ndo->foot_forces);
    Connect(ground, ndo->ground);
    Connect(ndo->estimate, leg_forces);
  } else {
    Connect(Add<ConstantSource<LegForceEstimate>>("no_leg_forces").y, leg_forces);
  }
  if (kind == ObserverKind::kCom || kind == ObserverKind::kHybrid || kind == ObserverKind::kFocchi ||
      kind == ObserverKind::kNdoHybrid) {
    ComObserverParams of_kind = params.com;
    if (kind == ObserverKind::kFocchi) of_kind.gains = params.focchi;
    com = &Add<ComObserver>("com", of_kind);
    Connect(state, com->state);
    Connect(foot_forces, com->foot_forces);
    Connect(ground, com->ground);
    Connect(imu, com->imu);
    Connect(known_wrench, com->known_wrench);
    Connect(com->estimate, wrench);
  } else {
    Connect(Add<ConstantSource<WrenchEstimate>>("no_wrench").y, wrench);
  }
}

}  // namespace tenon
