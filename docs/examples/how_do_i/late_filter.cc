// A Kalman filter that needs 3 ms for its computation: it reads the measurement at its tick, every 10 ms, and
// its estimate appears 3 ms later. The computation is an Update of a state, which reads the values of the
// tick. An output with an offset shows the new state.
#include <tenon/systems/analysis/lqr.h>
#include <tenon/systems/simulation.h>

#include <cmath>
#include <cstdio>

using tenon::Uses, tenon::Vec;

constexpr double kPeriod = 0.01, kDelay = 0.003;  // s

// A falling ball whose height is measured: x = (height, velocity).
class Ball final : public tenon::LeafSystem<void> {
 public:
  tenon::ContinuousState<Vec<2>> x{this, {"x", "m, m/s", "height, velocity"}, Vec<2>(10, 0)};
  tenon::OutputPort<double> height{this, {"height", "m"}, Uses(x), [](const Vec<2>& x) { return x[0]; }};
  tenon::TimeDerivative<Vec<2>> dx{x, Uses(x), [](const Vec<2>& x) { return Vec<2>(x[1], -9.81); }};
};

class Filter final : public tenon::LeafSystem<void> {
 public:
  tenon::InputPort<double> y{this, {"y", "m"}};
  tenon::DiscreteState<Vec<2>> x{this, {"x", "m, m/s"}, Vec<2>(9, 0)};  // estimate for the last tick
  tenon::Update<Vec<2>> next{x, tenon::Sampled{tenon::Hz(100)}, Uses(x, y), &Filter::Correct};
  tenon::OutputPort<Vec<2>> estimate{this,
                                     {"estimate", "m, m/s"},
                                     Vec<2>(9, 0),  // until the first result
                                     tenon::Sampled{tenon::Hz(100), kDelay},
                                     Uses(x),
                                     [](const Vec<2>& x) { return x; }};

 private:
  Eigen::MatrixXd A = (Eigen::MatrixXd(2, 2) << 1, kPeriod, 0, 1).finished(),
                  C = Eigen::MatrixXd::Identity(1, 2);
  Eigen::MatrixXd L = tenon::DiscreteKalman(A, C, 0.01 * Eigen::MatrixXd::Identity(2, 2),
                                            0.0001 * Eigen::MatrixXd::Identity(1, 1))
                          .L;
  Vec<2> Correct(const Vec<2>& x, double y) const {
    const Vec<2> predicted(x[0] + kPeriod * x[1] - 9.81 * kPeriod * kPeriod / 2, x[1] - 9.81 * kPeriod);
    return predicted + L * (y - predicted[0]);
  }
};

int main() {
  tenon::DiagramBuilder builder;
  auto& ball = builder.Add<Ball>("ball");
  auto& filter = builder.Add<Filter>("filter");
  builder.Connect(ball.height, filter.y);
  tenon::Simulator simulator(builder.Build());
  simulator.RunTo(1.002);  // the computation that began at 1 s still runs: the estimate is that for 0.99 s
  const double before = simulator.context().Eval(filter.estimate)[0];
  simulator.RunTo(1.003);
  const double after = simulator.context().Eval(filter.estimate)[0];
  std::printf("height for 0.99 s: %.4f m, for 1 s: %.4f m\n", before, after);
  return std::abs(before - (10 - 9.81 * 0.99 * 0.99 / 2)) < 1e-3 && std::abs(after - (10 - 9.81 / 2)) < 1e-3
             ? 0
             : 1;
}
