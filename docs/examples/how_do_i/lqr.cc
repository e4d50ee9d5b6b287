// Designs a feedback that holds the pendulum upright, from a linear model of the diagram.

#include <tenon/systems/analysis/linearize_discrete.h>
#include <tenon/systems/analysis/lqr.h>

#include "pendulum.h"

#include <cstdio>

constexpr double kPeriod = 0.02;  // s

int main() {
  // The plant alone, at rest at the top.
  tenon::DiagramBuilder open;
  auto& plant = open.Add<Pendulum>("pendulum");
  const auto plant_diagram = open.BuildWithOpenInputs();
  const auto at_rest = plant_diagram->CreateContext();
  at_rest->Set(plant.x, {0, 0});
  at_rest->Set(plant.torque, 0);
  const auto model = tenon::LinearizeDiscrete(*at_rest, {&plant.torque}, {&plant.state}, {.period = kPeriod});
  const auto lqr = tenon::DiscreteLqr(model.A, model.B, Eigen::Vector2d(10, 1).asDiagonal(),
                                      Eigen::MatrixXd::Identity(1, 1));

  // The loop: u = -K x, sampled and held.
  tenon::DiagramBuilder builder;
  auto& pendulum = builder.Add<Pendulum>("pendulum");
  auto& feedback = builder.AddFunction(
      {"feedback", "N m"}, tenon::Sampled{tenon::Seconds(kPeriod)}, tenon::Uses(pendulum.state),
      [K = tenon::Vec<2>(lqr.K.transpose())](const tenon::Vec<2>& x) { return -K.dot(x); });
  builder.Connect(feedback, pendulum.torque);
  tenon::Simulator simulator(builder.Build());
  simulator.RunTo(5);
  const double angle = simulator.context().Eval(pendulum.state)[0];
  std::printf("K = (%.2f, %.2f); after 5 s the angle is %.1e rad\n", lqr.K(0), lqr.K(1), angle);
  return std::abs(angle) < 1e-3 ? 0 : 1;
}
