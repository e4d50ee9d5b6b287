#pragma once

#include <tenon/systems/framework/errors.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>

namespace tenon {

/// The stabilising solution P of the discrete algebraic Riccati equation
///
///     P = Q + A^T P A - A^T P B (R + B^T P B)^{-1} B^T P A:
///
/// the cost to go 1/2 x^T P x of x' = A x + B u under the optimal feedback, for ever, at the cost
/// 1/2 (x^T Q x + u^T R u) per step. By the structure-preserving doubling algorithm (Chu, Fan and Lin, Linear
/// Algebra Appl. 396, 2005), which converges quadratically.
///
/// @throws ParameterError if the iteration does not converge: (A, B) cannot be stabilised, or a mode on the
/// unit circle costs nothing.
inline Eigen::MatrixXd SolveDiscreteRiccati(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                                            const Eigen::MatrixXd& Q, const Eigen::MatrixXd& R) {
  constexpr int kMaxDoublings = 60;
  const Eigen::Index n = A.rows();
  Eigen::MatrixXd a = A, G = B * R.llt().solve(B.transpose()), P = Q;
  for (int i = 0; i < kMaxDoublings; ++i) {
    const Eigen::PartialPivLU<Eigen::MatrixXd> lu(Eigen::MatrixXd::Identity(n, n) + G * P);
    const Eigen::MatrixXd inverse_a = lu.solve(a), inverse_G = lu.solve(G);
    const Eigen::MatrixXd change = a.transpose() * P * inverse_a;
    G += a * inverse_G * a.transpose();
    P += (change + change.transpose()) / 2;
    a = a * inverse_a;
    if (!P.allFinite()) break;
    if (change.cwiseAbs().maxCoeff() <= 1e-14 * P.cwiseAbs().maxCoeff()) return P;
  }
  throw ParameterError(
      "The Riccati equation has no stabilising solution: check that the inputs reach every unstable mode and "
      "that the state cost sees every mode that does not decay by itself.");
}

}  // namespace tenon
