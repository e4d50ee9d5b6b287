#pragma once

#include <tenon/systems/block.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

struct StateSpaceParams {
  Eigen::MatrixXd A = {}, B = {}, C = {};
  Eigen::MatrixXd D = {};        ///< empty if y does not depend on the present u
  Eigen::VectorXd initial = {};  ///< x at the start; zero if empty
  std::string u_unit = "", x_unit = "", y_unit = "";
  std::string u_elements = "", x_elements = "", y_elements = "";  ///< names of the elements
  /// Initial value of x.
  Eigen::VectorXd Start() const {
    return initial.size() == 0 ? Eigen::VectorXd::Zero(A.rows()).eval() : initial;
  }
  void Validate() const {
    const auto size = [](const auto& m) {
      return std::to_string(m.rows()) + " x " + std::to_string(m.cols());
    };
    Demand(A.size() > 0 && A.rows() == A.cols(), "A must be square and not empty: it is " + size(A));
    Demand(B.rows() == A.rows() && B.cols() > 0,
           "B must have as many rows as A, which is " + size(A) + ", and columns: it is " + size(B));
    Demand(C.cols() == A.cols() && C.rows() > 0,
           "C must have as many columns as A, which is " + size(A) + ", and rows: it is " + size(C));
    Demand(D.size() == 0 || (D.rows() == C.rows() && D.cols() == B.cols()),
           "D must be " + std::to_string(C.rows()) + " x " + std::to_string(B.cols()) +
               " to match C and B, or empty: it is " + size(D));
    Demand(initial.size() == 0 || initial.size() == A.rows(),
           "initial must have as many elements as A has rows, " + std::to_string(A.rows()) +
               ", or none: it has " + std::to_string(initial.size()));
    Demand(internal::IsFinite(A) && internal::IsFinite(B) && internal::IsFinite(C) && internal::IsFinite(D) &&
               internal::IsFinite(initial),
           "A, B, C, D and initial must be finite");
  }
};

namespace internal {

/// Computes next = A x + B u.
inline void CalcNextState(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, const Eigen::VectorXd& x,
                          const Eigen::VectorXd& u, Eigen::VectorXd* next) {
  Multiply("A", A, "x", x, next);
  Multiply("B", B, "u", u, next, true);
}

/// The values that C x + D u depends on.
template <class Block>
std::vector<const Source*> OutputUses(const Block& block, const StateSpaceParams& built) {
  std::vector<const Source*> uses{&block.C, &block.x, &block.D};
  if (built.D.size() > 0) uses.push_back(&block.u);
  return uses;
}

template <class Block>
void CalcOutput(const Block& block, const Reads& read, Eigen::VectorXd* y) {
  Multiply("C", read[block.C], "x", read[block.x], y);
  const Eigen::MatrixXd& D = read[block.D];
  if (D.size() > 0) Multiply("D", D, "u", read[block.u], y, true);
}

}  // namespace internal

/// A linear system of any size:
///
///     dx/dt = A x + B u,   y = C x + D u,   x(0) = initial
///
/// The ports are Eigen::VectorXd. If D is empty the output does not depend on the present input, and the
/// block breaks loops; to set D during a run, initialise it to zeros. Throws ParameterError if the sizes do
/// not match or a number is not finite, and RunError if u has the wrong size.
class StateSpace final : public LeafSystem<StateSpaceParams> {
 public:
  using LeafSystem::LeafSystem;
  Parameter<Eigen::MatrixXd> A{this, "A", params.A, "state matrix"}, B{this, "B", params.B, "input matrix"},
      C{this, "C", params.C, "output matrix"}, D{this, "D", params.D, "feedthrough matrix"};
  InputPort<Eigen::VectorXd> u{this, {"u", params.u_unit, params.u_elements}};
  ContinuousState<Eigen::VectorXd> x{this, {"x", params.x_unit, params.x_elements}, params.Start()};
  OutputPort<Eigen::VectorXd> y{
      this,
      {"y", params.y_unit, params.y_elements},
      Eigen::VectorXd::Zero(params.C.rows()),
      UsesAtRunTime(internal::OutputUses(*this, params)),
      [this](const Reads& read, Eigen::VectorXd* y_out) { internal::CalcOutput(*this, read, y_out); }};
  TimeDerivative<Eigen::VectorXd> dx{x, Uses(A, B, x, u), &internal::CalcNextState};
};

struct DiscreteStateSpaceParams {
  StateSpaceParams model = {};
  Rate rate = Hz(1000);
  void Validate() const { model.Validate(); }
};

/// A sampled linear system of any size:
///
///     x[n + 1] = A x[n] + B u[n],   y[n] = C x[n] + D u[n],   x[0] = initial
///
/// Feedthrough and exceptions are those of StateSpace.
class DiscreteStateSpace final : public LeafSystem<DiscreteStateSpaceParams> {
 public:
  using LeafSystem::LeafSystem;
  Parameter<Eigen::MatrixXd> A{this, "A", params.model.A, "state matrix"},
      B{this, "B", params.model.B, "input matrix"}, C{this, "C", params.model.C, "output matrix"},
      D{this, "D", params.model.D, "feedthrough matrix"};
  InputPort<Eigen::VectorXd> u{this, {"u", params.model.u_unit, params.model.u_elements}};
  DiscreteState<Eigen::VectorXd> x{
      this, {"x", params.model.x_unit, params.model.x_elements}, params.model.Start()};
  OutputPort<Eigen::VectorXd> y{
      this,
      {"y", params.model.y_unit, params.model.y_elements},
      Eigen::VectorXd::Zero(params.model.C.rows()),
      Sampled{params.rate},
      UsesAtRunTime(internal::OutputUses(*this, params.model)),
      [this](const Reads& read, Eigen::VectorXd* y_out) { internal::CalcOutput(*this, read, y_out); }};
  Update<Eigen::VectorXd> next{x, Sampled{params.rate}, Uses(A, B, x, u), &internal::CalcNextState};
};

}  // namespace tenon
