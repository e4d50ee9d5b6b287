#pragma once

#include <tenon/controllers/optimization/lanes/small_product.h>
#include <tenon/controllers/optimization/slq_options.h>

namespace tenon {

/// The Jacobians of f(x, u), dense; n and m may be Eigen::Dynamic.
template <int n, int m>
struct DenseLinearization {
  static constexpr int kColumns = n == Eigen::Dynamic || m == Eigen::Dynamic ? Eigen::Dynamic : n + m;
  /// Derivatives of a state with respect to the initial state and the input, [d/dx0  d/du].
  using Tangent = Eigen::Matrix<double, n, kColumns>;

  Eigen::Matrix<double, n, n> fx;
  Eigen::Matrix<double, n, m> fu;

  explicit DenseLinearization(int states = n, int inputs = m) : fx(states, states), fu(states, inputs) {}

  /// rate = fx tangent + [0  fu]: the rate of the tangent.
  void Multiply(const Tangent& tangent, Tangent& rate) const {
    internal::Multiply(fx, tangent, rate);
    rate.rightCols(fu.cols()) += fu;
  }
  /// rate = [fx  fu]: the rate of the tangent [1  0] at the start of a step.
  void MultiplyIdentity(Tangent& rate) const {
    rate.leftCols(fx.cols()) = fx;
    rate.rightCols(fu.cols()) = fu;
  }
};

/// The stages of Euler, the midpoint rule and the classical method of order 4 are all of the form
///
///     k_i = f(x + a_i h k_{i-1}, u),   x' = x + h sum_i b_i k_i.
struct StepTableau {
  static constexpr int kMaxStages = 4;
  int stages;
  double a[kMaxStages], b[kMaxStages];
};

inline const StepTableau& TableauOf(StepMethod method) {
  static constexpr StepTableau kEuler{1, {0}, {1}};
  static constexpr StepTableau kMidpoint{2, {0, 0.5}, {0, 1}};
  static constexpr StepTableau kClassic{4, {0, 0.5, 0.5, 1}, {1. / 6, 1. / 3, 1. / 3, 1. / 6}};
  return method == StepMethod::kEuler ? kEuler : method == StepMethod::kMidpoint ? kMidpoint : kClassic;
}

/// One explicit step x' = F(x, u) of a system  dx/dt = f(x, u)  with u constant, and the exact derivatives
/// [dF/dx  dF/du] of that same step (not of the flow that it approximates): with the k_i of StepTableau,
/// K_i = fx S_i + [0 fu] with S_i = [1 0] + a_i h K_{i-1} are the derivatives of the k_i.
///
/// `System` provides
///
///     void Derivative(const State& x, const Input& u, State& dx) const;
///     void Linearize(const State& x, const Input& u, State& dx, Linearization& f) const;
///
/// and the type Linearization with the products of DenseLinearization, which may exploit the structure of the
/// Jacobians. Alternatively the system implements the steps itself, see TakesOwnSteps.
template <class System>
class RungeKutta {
 public:
  using State = Eigen::Matrix<double, System::kStates, 1>;
  using Input = Eigen::Matrix<double, System::kInputs, 1>;
  using Linearization = typename System::Linearization;
  using Tangent = typename DenseLinearization<System::kStates, System::kInputs>::Tangent;

  RungeKutta(int states, int inputs)
      : k_(states),
        at_(states),
        S_(states, states + inputs),
        K_(states, states + inputs),
        f_(states, inputs) {}

  /// The step from node k of a horizon; all nodes are alike.
  void Step(const System& system, int, StepMethod method, double h, const State& x, const Input& u,
            State& next) {
    const StepTableau& tableau = TableauOf(method);
    next = x;
    for (int i = 0; i < tableau.stages; ++i) {
      if (i == 0) {
        system.Derivative(x, u, k_);
      } else {
        at_ = x + (tableau.a[i] * h) * k_;
        system.Derivative(at_, u, k_);
      }
      if (tableau.b[i] != 0) next += (tableau.b[i] * h) * k_;
    }
  }

  /// The derivatives of `count` steps, h[i] from x[i] with u[i].
  void Linearize(const System& system, StepMethod method, int count, const double* h, const State* x,
                 const Input* u, Tangent* tangents) {
    for (int i = 0; i < count; ++i) Linearize(system, TableauOf(method), h[i], x[i], u[i], tangents[i]);
  }

 private:
  void Linearize(const System& system, const StepTableau& tableau, double h, const State& x, const Input& u,
                 Tangent& tangent) {
    tangent.setZero();
    for (Eigen::Index j = 0; j < tangent.rows(); ++j) tangent(j, j) = 1;
    for (int i = 0; i < tableau.stages; ++i) {
      if (i == 0) {
        system.Linearize(x, u, k_, f_);
        f_.MultiplyIdentity(K_);
      } else {
        at_ = x + (tableau.a[i] * h) * k_;
        const double scale = tableau.a[i] * h;
        for (Eigen::Index j = 0; j < S_.size(); ++j) S_.data()[j] = scale * K_.data()[j];
        for (Eigen::Index j = 0; j < S_.rows(); ++j) S_(j, j) += 1;
        system.Linearize(at_, u, k_, f_);
        f_.Multiply(S_, K_);
      }
      if (tableau.b[i] == 0) continue;
      const double weight = tableau.b[i] * h;
      for (Eigen::Index j = 0; j < K_.size(); ++j) tangent.data()[j] += weight * K_.data()[j];
    }
  }

  State k_, at_;
  Tangent S_, K_;
  Linearization f_;
};

template <class System>
concept GivesJacobians = requires(const System& system, Eigen::Matrix<double, System::kStates, 1>& x,
                                  const Eigen::Matrix<double, System::kInputs, 1>& u,
                                  typename System::Linearization& f) {
  system.Derivative(x, u, x);
  system.Linearize(x, u, x, f);
};

/// A system that implements the steps of RungeKutta itself, for example several steps at once, or steps that
/// differ from node to node:
///
///     void Step(int k, StepMethod, double h, const State& x, const Input& u, State& next) const;
///     void LinearizeSteps(StepMethod, int count, const double* h, const State* x, const Input* u,
///                         Tangent* tangents, StepWorkspace&) const;
///     struct StepWorkspace { explicit StepWorkspace(int inputs); };
template <class System>
concept TakesOwnSteps = requires {
  typename System::StepWorkspace;
};

template <TakesOwnSteps System>
class RungeKutta<System> {
 public:
  using State = Eigen::Matrix<double, System::kStates, 1>;
  using Input = Eigen::Matrix<double, System::kInputs, 1>;
  using Tangent = typename DenseLinearization<System::kStates, System::kInputs>::Tangent;

  RungeKutta(int, int inputs) : workspace_(inputs) {}

  void Step(const System& system, int k, StepMethod method, double h, const State& x, const Input& u,
            State& next) {
    system.Step(k, method, h, x, u, next);
  }
  void Linearize(const System& system, StepMethod method, int count, const double* h, const State* x,
                 const Input* u, Tangent* tangents) {
    system.LinearizeSteps(method, count, h, x, u, tangents, workspace_);
  }

 private:
  typename System::StepWorkspace workspace_;
};

}  // namespace tenon
