#include <tenon/controllers/legged/comparison/nonlinear_disturbance_observer.h>
#include <tenon/controllers/legged/whole_body/foot_forces.h>
#include <tenon/systems/analysis/internal/small_matrices.h>

namespace tenon {

void NonlinearDisturbanceObserverParams::Validate() const {
  robot.CheckMass();
  gain.CheckSize("gain", 12, "joints");
}

LegForceEstimate NonlinearDisturbanceObserver::CalcEstimate(
    const LeggedState& state, const QuadrupedDynamics& dynamics, const FootForces& foot_forces,
    const GroundPlane& ground, const Vec<12>& held_torque, const DiagonalGains& gain,
    double min_singular_value, Memory& memory) const {
  DecoupledDynamics decoupled;
  model_.CalcDecoupled(state, dynamics, &decoupled);

  const Vec<12> known_torque =
      DecoupledGroundTorque(dynamics, foot_forces, ground.ContactArm(params.robot.foot_radius)) -
      decoupled.coriolis;
  if (memory.started) {
    const double period = params.rate.period();
    Vec<12> x = gain.As<12>();
    if (params.reading == NdoReading::kInverse) x = x.cwiseInverse().eval();
    Eigen::Matrix<double, 12, 12> stiffened = decoupled.M_q;
    stiffened.diagonal() += x * period;
    const Vec<12> impulse =
        decoupled.M_q * (state.qd - memory.qd) -
        period * ((known_torque + memory.known_torque) / 2 + held_torque + memory.estimate);
    memory.estimate += x.cwiseProduct(internal::SolveCholesky<12>(stiffened, impulse));
  }
  memory.started = true;
  memory.qd = state.qd;
  memory.known_torque = known_torque;
  return {memory.estimate, SolveFootForces(dynamics, decoupled, memory.estimate, min_singular_value)};
}

}  // namespace tenon
