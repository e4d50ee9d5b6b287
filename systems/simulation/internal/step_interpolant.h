#pragma once

#include <vector>

namespace tenon::internal {

/// The right-hand side for a StepInterpolant: ẋ at (t, x).
class DerivativeSource {
 public:
  virtual void EvaluateForInterpolant(double t, const double* x, double* xdot) = 0;

 protected:
  ~DerivativeSource() = default;
};

/// Dense output of a Runge-Kutta method: the states inside a step [t0, t0 + h], from a polynomial through the
/// states and derivatives at both ends and, for higher degrees, derivatives inside:
///
///     u(θ) = Hermite's cubic + θ² (1 - θ)² (a + b θ),    θ = (t - t0) / h
///
/// Degree 3 has an error of O(h⁴). For degree 4 the derivative at θ = 0.2, computed on the cubic, determines
/// a (b = 0); for degree 5 the derivatives at 0.2 and 0.8, computed on the quartic, determine a and b
/// (Enright, Jackson, Nørsett and Thomsen, "Interpolants for Runge-Kutta formulas", ACM Trans. Math. Softw.
/// 12, 1986). The derivatives are evaluated at the first request in a step, and not at all without one.
///
/// Steps of implicit methods may be long compared with the fastest time constants. A derivative is then
/// dominated by the error of the state times the stiffness. If the derivatives inside the step do not
/// converge when they are computed again, the polynomial goes through the states at the ends of up to five
/// steps.
class StepInterpolant {
 public:
  /// `implicit` is true for an implicit method.
  StepInterpolant(int num_states, int degree, bool implicit);

  /// Declares the next step the first of a new solution.
  void Restart();
  /// Sets the next step; copies the states.
  void SetStep(double t0, const double* x0, double t1, const double* x1);
  /// Computes the states at time `t` in the step.
  void At(double t, DerivativeSource& source, double* x);

 private:
  void Prepare(DerivativeSource& source);
  void EvaluateHermite(double theta, double* x) const;
  void EvaluateThroughStates(double t, double* x) const;
  double HermiteSlope(double theta, std::size_t i) const;

  static constexpr std::size_t kMaxPast = 4;

  int degree_;
  bool implicit_;
  bool started_ = false;
  bool prepared_ = false;
  bool stiff_ = false;
  bool has_f0_ = false;  ///< the derivative at t0 is known
  double t0_ = 0, t1_ = 0;
  std::vector<double> x0_, x1_, f0_, f1_;  ///< derivatives times h when prepared
  std::vector<double> slope1_;             ///< the derivative at t1
  std::vector<double> a_, b_, x_, f_, g_;
  /// For an implicit method: time and states at the ends of the steps before t0, oldest first.
  std::vector<double> past_;
};

}  // namespace tenon::internal
