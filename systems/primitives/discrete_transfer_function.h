#pragma once

#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/primitives/transfer_function.h>

#include <string>
#include <vector>

namespace tenon {

struct DiscreteTransferFunctionParams {
  std::vector<double> numerator = {1};   ///< coefficients of powers of z, highest first
  std::vector<double> denominator = {};  ///< like `numerator`; at least two, the first not zero
  Rate rate = Hz(1000);
  std::string u_unit = "";  ///< unit of the input
  std::string y_unit = "";  ///< unit of the output
  void Validate() const {
    TransferFunctionParams{.numerator = numerator, .denominator = denominator}.Validate();
    Demand(denominator.size() >= 2,
           "denominator must have two coefficients or more: use a Gain for a constant");
  }
};

/// A sampled rational transfer function with one input and one output, of any order n:
///
///     y(z) / u(z) = (b_n z^n + … + b_0) / (a_n z^n + … + a_0),   zero initial state
///
///     | port | kind            | size   | unit   |
///     | u    | input           | double | u_unit |
///     | y    | output, sampled | double | y_unit |
///
/// Realised in the transposed direct form II, with the coefficients divided by a_n and x_(n + 1) = 0:
///
///     y = b_n u + x_1,   x_i[k + 1] = x_(i + 1) + b_(n - i) u - a_(n - i) y
///
/// If b_n = 0 the output does not depend on the present input, and the block breaks loops. The coefficients
/// are constant during a run; use DiscreteStateSpace to change them.
///
/// Throws ParameterError if the function is not proper, if a coefficient is not finite, or if the denominator
/// is of order 0.
class DiscreteTransferFunction final : public LeafSystem<DiscreteTransferFunctionParams> {
  /// The coefficients of z^n … z^0, divided by a_n.
  Eigen::VectorXd Divided(const std::vector<double>& list) const {
    const Eigen::Index size = std::ssize(params.denominator), given = std::ssize(list);
    Eigen::VectorXd coefficients = Eigen::VectorXd::Zero(size);
    coefficients.tail(given) =
        Eigen::Map<const Eigen::VectorXd>(list.data(), given) / params.denominator.front();
    return coefficients;
  }
  const Eigen::VectorXd b_ = Divided(params.numerator), a_ = Divided(params.denominator);
  double CalcY(const Eigen::VectorXd& x, double u) const { return b_[0] * u + x[0]; }

 public:
  using LeafSystem::LeafSystem;
  InputPort<double> u{this, {"u", params.u_unit}};
  DiscreteState<Eigen::VectorXd> x{this, {"x", params.y_unit}, Eigen::VectorXd::Zero(a_.size() - 1)};
  OutputPort<double> y{
      this,
      {"y", params.y_unit},
      Sampled{params.rate},
      UsesAtRunTime(b_[0] == 0 ? std::vector<const Source*>{&x} : std::vector<const Source*>{&x, &u}),
      [this](const Reads& read) -> double { return CalcY(read[x], b_[0] == 0 ? 0 : read[u]); }};
  Update<Eigen::VectorXd> next{x, Sampled{params.rate}, Uses(x, u),
                               [this](const Eigen::VectorXd& x, double u, Eigen::VectorXd* next) {
                                 const Eigen::Index n = x.size();
                                 *next = b_.tail(n) * u - a_.tail(n) * CalcY(x, u);
                                 next->head(n - 1) += x.tail(n - 1);
                               }};
};

}  // namespace tenon
