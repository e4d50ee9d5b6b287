#pragma once

#include <tenon/systems/simulation.h>

#include <cmath>

struct PendulumParams {
  double length = 0.5;  // m
  double mass = 1;      // kg
};

// A pendulum with a motor in its joint: x = (angle from upright, angular rate), m l² a'' = m g l sin a +
// torque.
class Pendulum final : public tenon::LeafSystem<PendulumParams> {
 public:
  using LeafSystem::LeafSystem;
  tenon::InputPort<double> torque{this, {"torque", "N m"}, 0.0};
  tenon::ContinuousState<tenon::Vec<2>> x{this, {"x", "rad, rad/s", "angle, rate"}, tenon::Vec<2>(0.2, 0)};
  tenon::OutputPort<tenon::Vec<2>> state{this, {"state"}, x};
  tenon::TimeDerivative<tenon::Vec<2>> dx{x, tenon::Uses(x, torque), &Pendulum::CalcDx};

 private:
  tenon::Vec<2> CalcDx(const tenon::Vec<2>& x, double torque) const {
    const double inertia = params.mass * params.length * params.length;
    return {x[1], 9.81 / params.length * std::sin(x[0]) + torque / inertia};
  }
};
