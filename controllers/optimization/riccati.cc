#include <tenon/controllers/optimization/riccati.h>
#include <tenon/systems/framework/types/errors.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace tenon {

Eigen::MatrixXd SolveDiscreteRiccati(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
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
