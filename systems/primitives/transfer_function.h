#pragma once

#include <tenon/systems/framework/block/state.h>
#include <tenon/systems/primitives/internal/elementwise.h>

namespace tenon {

struct TransferFunctionParams {
  std::vector<double> numerator = {1};   ///< coefficients of powers of s [1/s], highest first
  std::vector<double> denominator = {};  ///< like `numerator`; Order + 1 coefficients, the first not zero
  std::string u_unit = "";               ///< unit of the input
  std::string y_unit = "";               ///< unit of the output
  void Validate() const {
    Demand(!numerator.empty(), "numerator must not be empty");
    Demand(internal::IsFinite(numerator) && internal::IsFinite(denominator), "coefficients must be finite");
    Demand(!denominator.empty() && denominator.front() != 0,
           "denominator must begin with a coefficient other than 0");
    Demand(numerator.size() <= denominator.size(),
           "numerator must not have more coefficients than denominator: the transfer function would not be "
           "proper");
  }
};

/// A proper rational transfer function with one input and one output, n = Order from 1 to 8:
///
///     y(s) / u(s) = (b_n s^n + … + b_0) / (a_n s^n + … + a_0),   zero initial state
///
/// Realised in controllable canonical form, in the time scale of the denominator: with
/// w = max |a_i / a_n|^(1 / (n - i)) and s = w p, a_n = 1, d = b_n and c_i = (b_i - d a_i) w^(i - n),
///
///     dx_i/dt = w x_(i+1),   dx_n/dt = w (u - sum a_i w^(i - n) x_(i+1)),   y = sum c_i x_(i+1) + d u.
///
/// The states have about the magnitude of u at any frequency, so that the integrator's absolute tolerance
/// applies equally to all of them. If b_n = 0 the output does not depend on the present input, and the block
/// breaks loops.
///
/// Throws ParameterError if the function is not proper, if a coefficient is not finite, or if the denominator
/// does not have Order + 1 coefficients.
template <int Order>
class TransferFunction final : public LeafSystem<TransferFunctionParams> {
  static_assert(Order >= 1 && Order <= 8, "TransferFunction: the order is from 1 to 8.");

 public:
  using LeafSystem::LeafSystem;

 private:
  struct Realization {
    double w;
    Vec<Order> a, c;
    double d;
  };
  static Realization Realize(const TransferFunctionParams& params);
  const Realization form_ = Realize(params);

 public:
  InputPort<double> u{this, {"u", params.u_unit}};
  ContinuousState<Vec<Order>> x{this, {"x", params.u_unit}};
  OutputPort<double> y{
      this,
      {"y", params.y_unit},
      UsesAtRunTime(form_.d == 0 ? std::vector<const Source*>{&x} : std::vector<const Source*>{&x, &u}),
      [this](const Reads& read) -> double {
        const double direct = form_.d == 0 ? 0 : form_.d * read[u];
        return form_.c.dot(read[x]) + direct;
      }};
  TimeDerivative<Vec<Order>> dx{x, Uses(x, u), [this](const Vec<Order>& x_now, double u_now) -> Vec<Order> {
                                  Vec<Order> rate;
                                  for (int i = 0; i + 1 < Order; ++i) rate[i] = form_.w * x_now[i + 1];
                                  rate[Order - 1] = form_.w * (u_now - form_.a.dot(x_now));
                                  return rate;
                                }};
};

template <int Order>
auto TransferFunction<Order>::Realize(const TransferFunctionParams& params) -> Realization {
  Demand(params.denominator.size() == Order + 1,
         "denominator has " + std::to_string(params.denominator.size()) +
             " coefficients; a TransferFunction<" + std::to_string(Order) + "> needs " +
             std::to_string(Order + 1));
  const double lead = params.denominator.front();
  const auto coefficient = [lead](const std::vector<double>& list, int power) {
    const int i = static_cast<int>(list.size()) - 1 - power;
    return i < 0 ? 0.0 : list[static_cast<std::size_t>(i)] / lead;
  };
  Realization form{.w = 0, .a = {}, .c = {}, .d = coefficient(params.numerator, Order)};
  for (int i = 0; i < Order; ++i) {
    form.w = std::max(form.w, std::pow(std::abs(coefficient(params.denominator, i)), 1.0 / (Order - i)));
  }
  if (form.w == 0) form.w = 1;  // all poles at 0
  for (int i = 0; i < Order; ++i) {
    const double scale = std::pow(form.w, i - Order), a = coefficient(params.denominator, i);
    form.a[i] = a * scale;
    form.c[i] = (coefficient(params.numerator, i) - form.d * a) * scale;
  }
  return form;
}

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
  double CalcY(const Eigen::VectorXd& x_now, double u_now) const { return b_[0] * u_now + x_now[0]; }

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
                               [this](const Eigen::VectorXd& x_now, double u_now, Eigen::VectorXd* next_out) {
                                 const Eigen::Index n = x_now.size();
                                 *next_out = b_.tail(n) * u_now - a_.tail(n) * CalcY(x_now, u_now);
                                 next_out->head(n - 1) += x_now.tail(n - 1);
                               }};
};

}  // namespace tenon
