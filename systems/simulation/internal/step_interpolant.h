#pragma once

#include <vector>

namespace tenon::internal {

/// What a StepInterpolant asks for: ẋ at (t, x).
class DerivativeSource {
 public:
  virtual void EvaluateForInterpolant(double t, const double* x, double* xdot) = 0;

 protected:
  ~DerivativeSource() = default;
};

/// The states inside a step [t0, t0 + h] of a Runge-Kutta method, by a polynomial through the states and
/// derivatives at both its ends and, for higher degrees, derivatives inside:
///
///     u(θ) = Hermite's cubic + θ² (1 - θ)² (a + b θ),    θ = (t - t0) / h
///
/// Degree 3 errs by O(h⁴). For degree 4 the derivative at θ = 0.2, computed on the cubic, determines a
/// (b = 0); for degree 5 those at 0.2 and 0.8, computed on the quartic, determine a and b (Enright, Jackson,
/// Nørsett and Thomsen, "Interpolants for Runge-Kutta formulas", ACM Trans. Math. Softw. 12, 1986). The
/// derivatives are evaluated once a step, however often the states are asked for: none if nobody asks.
///
/// Steps of implicit methods may be long beside the fastest time constants. Derivatives then tell the error
/// of a state, multiplied by stiffness, and no slope: where those inside the step do not settle when computed
/// again, the polynomial goes through the states at the ends of up to five steps.
class StepInterpolant {
 public:
  /// `implicit`: the method is.
  StepInterpolant(int num_states, int degree, bool implicit);

  /// The next step is the first of a new solution.
  void Restart();
  /// Another step; states are copied.
  void SetStep(double t0, const double* x0, double t1, const double* x1);
  /// The states at a time in the step.
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
  /// Of an implicit method: time and states at the ends of the steps before t0, oldest first.
  std::vector<double> past_;
};

}  // namespace tenon::internal
