#pragma once

#include <tenon/systems/framework/types/internal/border.h>

namespace tenon {

/// A linear feedback u = -K x and its cost from x0, x0' S x0.
struct LqrDesign {
  Eigen::MatrixXd K;  ///< m x n
  Eigen::MatrixXd S;  ///< n x n, symmetric
};

/// Computes the feedback of ẋ = A x + B u that minimises
///
///     J = ∫ x'Q x + u'R u + 2 x'N u dt:   K = R⁻¹ (B'S + N'),
///     A'S + S A - (S B + N) R⁻¹ (B'S + N') + Q = 0
///
/// A: n x n, B: n x m, Q: n x n, R: m x m, N: n x m (empty: 0). S comes from the matrix sign function of the
/// Hamiltonian matrix, by Newton's method with determinant scaling (J. D. Roberts, Int. J. Control 32, 1980;
/// R. Byers, Linear Algebra Appl. 85, 1987).
///
/// Throws ParameterError for wrong sizes, numbers that are not finite, Q (or Q - N R⁻¹ N') that is not
/// symmetric and positive semidefinite, R that is not symmetric and positive definite, and, with its
/// eigenvalue, a mode that does not decay and is not controllable by B (not stabilisable) or has no weight in
/// Q (not detectable).
LqrDesign Lqr(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, const Eigen::MatrixXd& Q,
              const Eigen::MatrixXd& R, const Eigen::MatrixXd& N = {});

/// Computes the feedback of x[k+1] = A x[k] + B u[k] that minimises
///
///     J = Σ x'Q x + u'R u + 2 x'N u:   K = (R + B'S B)⁻¹ (B'S A + N'),
///     S = A'S A - (A'S B + N) (R + B'S B)⁻¹ (B'S A + N') + Q
///
/// Sizes and errors are those of Lqr. S comes from structure-preserving doubling, which converges
/// quadratically (E. K.-W. Chu, H.-Y. Fan, W.-W. Lin, C.-S. Wang, Int. J. Control 77, 2004).
LqrDesign DiscreteLqr(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B, const Eigen::MatrixXd& Q,
                      const Eigen::MatrixXd& R, const Eigen::MatrixXd& N = {});

/// Returns the stabilising solution P of the discrete algebraic Riccati equation
///
///     P = Q + A' P A - A' P B (R + B' P B)⁻¹ B' P A
///
/// by the method of DiscreteLqr, without its checks of the arguments. Throws ParameterError if it does not
/// converge: (A, B) is not stabilisable, or a mode on the unit circle has no weight in Q.
Eigen::MatrixXd SolveDiscreteRiccati(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                                     const Eigen::MatrixXd& Q, const Eigen::MatrixXd& R);

/// The gain of an observer, and the covariance of its error.
struct KalmanDesign {
  Eigen::MatrixXd L;  ///< n x p
  Eigen::MatrixXd P;  ///< n x n, symmetric
};

/// Computes the steady-state Kalman-Bucy filter of ẋ = A x + B u + w, y = C x + v, with white noise of
/// intensities Q (n x n) of w and R (p x p) of v [unit² s]:
///
///     dx̂/dt = A x̂ + B u + L (y - C x̂),   L = P C' R⁻¹,   A P + P A' - P C' R⁻¹ C P + Q = 0
///
/// It is the dual of Lqr, with the same method and errors: a mode that does not decay must be observable in y
/// (detectable) and excited by w (stabilisable).
KalmanDesign Kalman(const Eigen::MatrixXd& A, const Eigen::MatrixXd& C, const Eigen::MatrixXd& Q,
                    const Eigen::MatrixXd& R);

/// Computes the steady-state Kalman filter of x[k+1] = A x[k] + B u[k] + w[k], y[k] = C x[k] + v[k], with
/// covariances Q (n x n) of w and R (p x p) of v [unit²]:
///
///     x̂⁺ = x̂ + L (y[k] - C x̂),   x̂[k+1] = A x̂⁺ + B u[k],   L = P C' (C P C' + R)⁻¹
///     P = A P A' - A P C' (C P C' + R)⁻¹ C P A' + Q
///
/// P is the covariance before the measurement; after it, it is (I - L C) P. Errors are those of Kalman.
KalmanDesign DiscreteKalman(const Eigen::MatrixXd& A, const Eigen::MatrixXd& C, const Eigen::MatrixXd& Q,
                            const Eigen::MatrixXd& R);

}  // namespace tenon
