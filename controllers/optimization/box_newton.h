#pragma once

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace tenon {

/// min 1/2 x^T H x + g^T x   subject to   lower <= x <= upper,   H symmetric, positive definite.
///
/// Projected Newton method: entries at a bound whose gradient points outwards are fixed, the others take a
/// Newton step, clamped to the bounds, with a backtracking line search along the projected path (Bertsekas,
/// SIAM J. Control Optim. 20, 1982; in differential dynamic programming: Tassa, Mansard and Todorov, ICRA
/// 2014). Ends after finitely many steps at the exact solution, up to rounding.
///
/// N is the size, or Eigen::Dynamic with the size given to the constructor. Solve() does not allocate.
template <int N>
class BoxNewton {
 public:
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;

  explicit BoxNewton(int size = N)
      : masked_(size, size),
        gradient_(size),
        step_(size),
        trial_(size),
        change_(size),
        free_(size),
        curvature_(size) {}

  /// `x` is the start and the solution. Returns false if H is not positive definite on the free entries, if a
  /// value is not finite, or after 50 iterations. The unconstrained solution is tried first, so that inactive
  /// bounds cost little.
  [[gnu::always_inline]] bool Solve(const Matrix& H, const Vector& g, const Vector& lower,
                                    const Vector& upper, Vector& x) {
    if (SolveFree(H, g, trial_) && Within(trial_, lower, upper) && Largest(trial_) < kHuge) {
      x = trial_;
      return true;
    }
    return SolveBounded(H, g, lower, upper, x);
  }

  /// Solves without bounds: x = -H^{-1} g. Returns false if H is not positive definite.
  [[gnu::always_inline]] bool SolveFree(const Matrix& H, const Vector& g, Vector& x) {
    free_.setOnes();
    if (!Factor(H)) return false;
    x = -g;
    Substitute(x.data());
    return true;
  }

  /// For each entry of the last solution 1 if it is free, 0 if it is fixed at a bound.
  const Vector& free() const { return free_; }

  /// Sensitivity of the solution to a change G y of g while the same entries are free: -H_ff^{-1} G_f in the
  /// rows of free entries, zero in the others. `C` is G^T on entry and the transpose of the result on return.
  template <class Derived>
  [[gnu::always_inline]] void Sensitivity(Eigen::MatrixBase<Derived>& C) const {
    const Eigen::Index size = free_.size(), rows = C.rows();
    const auto subtract = [&](Eigen::Index j, double factor, Eigen::Index k) __attribute__((always_inline)) {
      for (Eigen::Index r = 0; r < rows; ++r) C(r, j) -= factor * C(r, k);
    };
    for (Eigen::Index j = 1; j < size; ++j)
      for (Eigen::Index k = 0; k < j; ++k) subtract(j, masked_(j, k), k);
    for (Eigen::Index j = size - 1; j >= 0; --j) {
      const double scale = -(free_[j] * masked_(j, j));
      for (Eigen::Index r = 0; r < rows; ++r) C(r, j) *= scale;
      for (Eigen::Index k = j + 1; k < size; ++k) subtract(j, masked_(k, j), k);
    }
  }

 private:
  static constexpr double kHuge = 1e300;

  static double Largest(const Vector& v) { return v.cwiseAbs().maxCoeff(); }
  [[gnu::always_inline]] static bool Within(const Vector& x, const Vector& lower, const Vector& upper) {
    bool within = true;
    for (Eigen::Index i = 0; i < x.size(); ++i) within = within && lower[i] <= x[i] && x[i] <= upper[i];
    return within;
  }

  [[gnu::noinline]] bool SolveBounded(const Matrix& H, const Vector& g, const Vector& lower,
                                      const Vector& upper, Vector& x) {
    constexpr int kMaxIterations = 50, kMaxHalvings = 30;
    constexpr double kSufficientDecrease = 0.1;
    const Eigen::Index size = x.size();
    for (Eigen::Index i = 0; i < size; ++i) x[i] = std::min(std::max(x[i], lower[i]), upper[i]);
    const double scale = 1e-12 * (1 + Largest(g));
    for (int iteration = 0; iteration < kMaxIterations; ++iteration) {
      gradient_ = g;
      gradient_.noalias() += H * x;
      bool changed = iteration == 0;
      for (Eigen::Index i = 0; i < size; ++i) {
        const double is_free =
            (x[i] <= lower[i] && gradient_[i] > 0) || (x[i] >= upper[i] && gradient_[i] < 0) ? 0 : 1;
        changed = changed || is_free != free_[i];
        free_[i] = is_free;
      }
      if (changed && !Factor(H)) return false;
      for (Eigen::Index i = 0; i < size; ++i) step_[i] = -(gradient_[i] * free_[i]);
      const double steepest = Largest(step_);
      if (!(steepest < kHuge)) return false;
      if (steepest <= scale) return true;
      Substitute(step_.data());
      double alpha = 1;
      for (int halving = 0; halving <= kMaxHalvings; ++halving, alpha /= 2) {
        for (Eigen::Index i = 0; i < size; ++i) {
          trial_[i] = std::min(std::max(x[i] + alpha * step_[i], lower[i]), upper[i]);
          change_[i] = trial_[i] - x[i];
        }
        // The change of the cost, from gradient and Hessian at x: no cancellation of large numbers.
        const double slope = gradient_.dot(change_);
        curvature_.noalias() = H * change_;
        if (slope + change_.dot(curvature_) / 2 <= kSufficientDecrease * slope) break;
      }
      x = trial_;
      if (Largest(change_) <= 1e-15 * (1 + Largest(x))) return true;  // rounding
    }
    return false;
  }

  // H with the rows and columns of held entries replaced by those of the unit matrix.
  [[gnu::always_inline]] bool Factor(const Matrix& H) {
    masked_ = H;
    const Eigen::Index size = free_.size();
    for (Eigen::Index i = 0; i < size; ++i) {
      if (free_[i] != 0) continue;
      for (Eigen::Index j = 0; j < size; ++j) masked_(i, j) = masked_(j, i) = 0;
      masked_(i, i) = 1;
    }
    // L D L^T, without square roots: a column of L waits for one division.
    for (Eigen::Index j = 0; j < size; ++j) {
      if (!(masked_(j, j) > 0)) return false;
      masked_(j, j) = 1 / masked_(j, j);
      for (Eigen::Index k = j + 1; k < size; ++k) {
        const double factor = masked_(k, j) * masked_(j, j);
        for (Eigen::Index i = k; i < size; ++i) masked_(i, k) -= masked_(i, j) * factor;
      }
      for (Eigen::Index i = j + 1; i < size; ++i) masked_(i, j) *= masked_(j, j);
    }
    return true;
  }

  // x <- (L D L^T)^{-1} x
  [[gnu::always_inline]] void Substitute(double* x) const {
    const Eigen::Index size = free_.size();
    for (Eigen::Index j = 0; j < size; ++j)
      for (Eigen::Index i = j + 1; i < size; ++i) x[i] -= masked_(i, j) * x[j];
    for (Eigen::Index j = size - 1; j >= 0; --j) {
      x[j] *= masked_(j, j);
      for (Eigen::Index i = j + 1; i < size; ++i) x[j] -= masked_(i, j) * x[i];
    }
  }

  Matrix masked_;  // below the diagonal L, on it D^{-1}
  Vector gradient_, step_, trial_, change_, free_, curvature_;
};

}  // namespace tenon
