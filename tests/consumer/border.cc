// Eigen's memory is allocated on one side of the border between program and library and freed on the other.
#include <tenon/systems/analysis/lqr.h>
#include <tenon/systems/block.h>
#include <tenon/systems/primitives/state_space.h>
#include <tenon/systems/simulation.h>

#include <Eigen/Dense>

#include <cmath>
#include <cstdio>
#include <utility>

using tenon::Uses;

/// Allocates in the program; the library copies, resizes and destroys the values.
class Wide final : public tenon::LeafSystem<void> {
 public:
  tenon::OutputPort<Eigen::VectorXd> y{
      this, {"y"}, Eigen::VectorXd(Eigen::VectorXd::Zero(7)), Uses(time), [](double t) {
        return Eigen::VectorXd(Eigen::VectorXd::Constant(7, t));
      }};
};

int main() {
  // From the library into the program: moved, resized and freed here.
  const Eigen::MatrixXd A = Eigen::MatrixXd::Identity(9, 9) * -1, I = Eigen::MatrixXd::Identity(9, 9);
  tenon::LqrDesign design = tenon::Lqr(A, I, I, I);
  Eigen::MatrixXd K = std::move(design.K);
  if (std::abs(K(3, 3) - (std::sqrt(2) - 1)) > 1e-9) return 1;
  K.conservativeResize(20, 20);
  K = Eigen::MatrixXd::Random(300, 300);
  const Eigen::MatrixXd product = K * K;  // Eigen's aligned work space
  if (std::abs(product(7, 5) - K.row(7).dot(K.col(5))) > 1e-9) return 2;

  tenon::DiagramBuilder builder;
  auto& wide = builder.Add<Wide>("wide");
  auto& model =
      builder.Add<tenon::StateSpace>("model", tenon::StateSpaceParams{.A = -Eigen::MatrixXd::Identity(7, 7),
                                                                      .B = Eigen::MatrixXd::Identity(7, 7),
                                                                      .C = Eigen::MatrixXd::Identity(7, 7)});
  builder.Connect(wide.y, model.u);
  tenon::Simulator simulator(builder.Build(), {.rtol = 1e-9});
  const auto log = simulator.AddLog(tenon::Hz(10), {&wide.y, &model.y});
  simulator.RunTo(1);
  const auto copy = simulator.context().Clone();
  if (std::abs(copy->Eval(model.y)[6] - std::exp(-1)) > 1e-6 || log->rows() != 11) return 3;
  std::puts("ok");
}
