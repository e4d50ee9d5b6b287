#pragma once

#include <Eigen/Core>

namespace tenon {

/// The stabilising solution P of the discrete algebraic Riccati equation
///
///     P = Q + A^T P A - A^T P B (R + B^T P B)^{-1} B^T P A:
///
/// 1/2 x^T P x is the infinite-horizon cost to go of x' = A x + B u under the optimal feedback, for the cost
/// 1/2 (x^T Q x + u^T R u) per step. By the structure-preserving doubling algorithm (Chu, Fan and Lin, Linear
/// Algebra Appl. 396, 2005), which converges quadratically.
///
/// @throws ParameterError if the iteration does not converge: (A, B) cannot be stabilised, or a mode on the
/// unit circle costs nothing.
Eigen::MatrixXd SolveDiscreteRiccati(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                                     const Eigen::MatrixXd& Q, const Eigen::MatrixXd& R);

}  // namespace tenon
