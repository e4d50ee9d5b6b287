#pragma once

#include <tenon/systems/block.h>
#include <tenon/systems/geometry.h>

struct CartParams {
  double mass = 2;  // kg
  void Validate() const { tenon::Demand(mass > 0, "mass must be positive"); }
};

// A cart on a rail: x = (position, velocity), dx/dt = (velocity, force / mass).
class Cart final : public tenon::LeafSystem<CartParams> {
 public:
  using LeafSystem::LeafSystem;
  tenon::InputPort<double> force{this, {"force", "N"}};
  tenon::ContinuousState<tenon::Vec<2>> x{this, {"x", "m, m/s", "position, velocity"}};
  tenon::OutputPort<tenon::Vec<2>> state{this, x};
  tenon::TimeDerivative<tenon::Vec<2>> dx{x, tenon::Uses(x, force), &Cart::CalcDx};
  // The shapes of a replay: a box that moves, and the force as an arrow of 0.2 m/N.
  tenon::OutputPort<tenon::Geometry> geometry{
      this,
      {"geometry"},
      {tenon::Shape::Box(tenon::ShapeRole::kBody, "cart", {0.3, 0.2, 0.1}),
       tenon::Shape::Arrow(tenon::ShapeRole::kForce, "force", 0.2)},
      tenon::Uses(x, force),
      &Cart::CalcGeometry};

 private:
  void CalcGeometry(const tenon::Vec<2>& x, double force, tenon::Geometry* out) const {
    for (tenon::Shape& shape : *out) shape.p_W = {x[0], 0, 0.05};
    (*out)[1].vector_W = {force, 0, 0};
  }
  tenon::Vec<2> CalcDx(const tenon::Vec<2>& x, double force) const { return {x[1], force / params.mass}; }
};

struct PdParams {
  double kp = 10;  // N/m
  double kd = 6;   // N s/m
  tenon::Rate rate = tenon::Hz(1000);
};

// u = kp (ref - position) - kd velocity, sampled at `rate` and held in between.
class Pd final : public tenon::LeafSystem<PdParams> {
 public:
  using LeafSystem::LeafSystem;
  tenon::InputPort<tenon::Vec<2>> x{this, {"x", "m, m/s", "position, velocity"}};
  tenon::InputPort<double> ref{this, {"ref", "m"}};
  tenon::OutputPort<double> u{this, {"u", "N"}, tenon::Sampled{params.rate}, tenon::Uses(x, ref), &Pd::CalcU};

 private:
  double CalcU(const tenon::Vec<2>& x, double ref) const {
    return params.kp * (ref - x[0]) - params.kd * x[1];
  }
};
