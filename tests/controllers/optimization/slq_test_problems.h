#pragma once

#include <tenon/controllers/optimization/runge_kutta.h>

namespace tenon::test {

/// dx/dt = A x + B u with quadratic costs about x_des and u_des; n and m may be Eigen::Dynamic.
template <int n, int m>
struct LinearProblem {
  static constexpr int kStates = n, kInputs = m;
  using State = Eigen::Matrix<double, n, 1>;
  using Input = Eigen::Matrix<double, m, 1>;
  using StateMatrix = Eigen::Matrix<double, n, n>;
  using InputMatrix = Eigen::Matrix<double, m, m>;
  using Linearization = DenseLinearization<n, m>;

  StateMatrix A, Q, Q_f;
  Eigen::Matrix<double, n, m> B;
  InputMatrix R;
  State x_des;
  Input u_des, lower, upper;

  int num_states() const { return static_cast<int>(A.rows()); }
  int num_inputs() const { return static_cast<int>(B.cols()); }
  void Derivative(const State& x, const Input& u, State& dx) const {
    dx.noalias() = A * x;
    dx.noalias() += B * u;
  }
  void Linearize(const State& x, const Input& u, State& dx, Linearization& f) const {
    Derivative(x, u, dx);
    f.fx = A;
    f.fu = B;
  }
  double StageCost(int, const State& x, const Input& u) const {
    return (Dot(Q, x, x_des) + Dot(R, u, u_des)) / 2;
  }
  void AddStageCost(int, const State& x, const Input& u, double h, State& gx, Input& gu, StateMatrix& Hxx,
                    InputMatrix& Huu) const {
    gx.noalias() += h * (Q * x);
    gx.noalias() -= h * (Q * x_des);
    gu.noalias() += h * (R * u);
    gu.noalias() -= h * (R * u_des);
    Hxx += h * Q;
    Huu += h * R;
  }
  double TerminalCost(const State& x) const { return Dot(Q_f, x, x_des) / 2; }
  void AddTerminalCost(const State& x, State& gx, StateMatrix& Hxx) const {
    gx.noalias() += Q_f * x;
    gx.noalias() -= Q_f * x_des;
    Hxx += Q_f;
  }
  const Input& Lower(int) const { return lower; }
  const Input& Upper(int) const { return upper; }

 private:
  template <class M, class V>
  static double Dot(const M& W, const V& a, const V& b) {
    double sum = 0;
    for (Eigen::Index i = 0; i < a.size(); ++i)
      for (Eigen::Index j = 0; j < a.size(); ++j) sum += (a[i] - b[i]) * W(i, j) * (a[j] - b[j]);
    return sum;
  }
};

/// Three states, two inputs, wide bounds, nothing zero.
template <int n = 3, int m = 2>
LinearProblem<n, m> SomeLinearProblem() {
  LinearProblem<n, m> problem;
  problem.A.resize(3, 3);
  problem.A << 0, 1, 0.2, -2, -0.1, 0.5, 0.3, 0, 0.4;
  problem.B.resize(3, 2);
  problem.B << 0, 0.1, 1, 0, 0.2, 1;
  problem.Q = Eigen::Vector3d(10, 1, 3).asDiagonal();
  problem.Q_f = Eigen::Vector3d(20, 4, 5).asDiagonal();
  problem.R = Eigen::Vector2d(0.1, 0.3).asDiagonal();
  problem.x_des = Eigen::Vector3d(0.5, 0, -0.2);
  problem.u_des = Eigen::Vector2d(0.3, 0.1);
  problem.upper = Eigen::Vector2d(1e6, 1e6);
  problem.lower = -problem.upper;
  return problem;
}

/// A pendulum, angle from hanging and rate, that is to stand up under a bounded torque:
/// d2a/dt2 = -9.81 sin a - 0.1 da/dt + u.
struct PendulumProblem {
  static constexpr int kStates = 2, kInputs = 1;
  using State = Eigen::Vector2d;
  using Input = Eigen::Matrix<double, 1, 1>;
  using Linearization = DenseLinearization<2, 1>;
  Input lower = Input(-6), upper = Input(6);

  int num_states() const { return 2; }
  int num_inputs() const { return 1; }
  void Derivative(const State& x, const Input& u, State& dx) const {
    const double a = x[0], rate = x[1];
    dx << rate, -9.81 * std::sin(a) - 0.1 * rate + u[0];
  }
  void Linearize(const State& x, const Input& u, State& dx, Linearization& f) const {
    f.fx << 0, 1, -9.81 * std::cos(x[0]), -0.1;
    f.fu << 0, 1;
    Derivative(x, u, dx);
  }
  double StageCost(int, const State& x, const Input& u) const {
    return Error(x).cwiseAbs2().dot(State(1, 0.1)) / 2 + 0.01 * u[0] * u[0] / 2;
  }
  void AddStageCost(int, const State& x, const Input& u, double h, State& gx, Input& gu, Eigen::Matrix2d& Hxx,
                    Eigen::Matrix<double, 1, 1>& Huu) const {
    gx += h * Error(x).cwiseProduct(State(1, 0.1));
    gu[0] += h * 0.01 * u[0];
    Hxx.diagonal() += h * State(1, 0.1);
    Huu(0, 0) += h * 0.01;
  }
  double TerminalCost(const State& x) const { return 50 * Error(x).squaredNorm() / 2; }
  void AddTerminalCost(const State& x, State& gx, Eigen::Matrix2d& Hxx) const {
    gx += 50 * Error(x);
    Hxx.diagonal().array() += 50;
  }
  const Input& Lower(int) const { return lower; }
  const Input& Upper(int) const { return upper; }
  static State Error(const State& x) { return {x[0] - 3.14159265358979, x[1]}; }
};

}  // namespace tenon::test
