#include <tenon/systems/analysis/lqr.h>
#include <tenon/systems/analysis/matrix_functions.h>
#include <tenon/systems/framework/types/errors.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

namespace tenon {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Words for messages of a design; a filter is the dual of a feedback.
struct Words {
  const char* function;
  bool discrete;
  const char* unreached;   ///< not (A, B) stabilisable
  const char* unweighted;  ///< not (A, Q) detectable
};

constexpr const char* kNotSteered = "is not controllable by B: (A, B) is not stabilisable";
constexpr const char* kNotWeighed = "has no weight in Q: (A, Q) is not detectable";
constexpr const char* kNotSeen = "is not observable by C: (A, C) is not detectable";
constexpr const char* kNotDriven = "is not excited by Q: (A, Q) is not stabilisable";

[[noreturn]] void Fail(const Words& words, const std::string& text) {
  throw ParameterError(fmt::format("{}: {}", words.function, text));
}

void CheckSize(const Words& words, const char* name, const MatrixXd& matrix, Index rows, Index cols) {
  if (matrix.rows() != rows || matrix.cols() != cols) {
    Fail(words,
         fmt::format("{} is {} x {}, but should be {} x {}", name, matrix.rows(), matrix.cols(), rows, cols));
  }
  if (!matrix.allFinite()) Fail(words, fmt::format("{} holds numbers that are not finite", name));
}

/// Throws unless the matrix is symmetric and positive definite (`definite`) or semidefinite.
void CheckDefinite(const Words& words, const char* name, const MatrixXd& matrix, bool definite) {
  const double size = matrix.cwiseAbs().maxCoeff();
  const double asymmetry = (matrix - matrix.transpose()).cwiseAbs().maxCoeff();
  if (asymmetry > 1e-10 * size) {
    Fail(words, fmt::format("{} is not symmetric: two of its elements differ by {:.3g}", name, asymmetry));
  }
  // The tolerance does not depend on the units of the rows.
  const Eigen::VectorXd units =
      matrix.diagonal().unaryExpr([](double own) { return own == 0 ? 1 : 1 / std::sqrt(std::abs(own)); });
  const auto smallest = [](const MatrixXd& symmetric) { return SymmetricEigenvalues(symmetric)[0]; };
  const double in_units = smallest(units.asDiagonal() * matrix * units.asDiagonal());
  if (definite ? in_units > 1e-15 : in_units > -1e-10) return;
  Fail(words, fmt::format("{} is not positive {}: it has the eigenvalue {:.3g}", name,
                          definite ? "definite" : "semidefinite", smallest(matrix)));
}

/// Finds the undamped or unstable mode of A that is nearest to being uncontrollable by B, by the test of
/// Popov, Belevitch and Hautus: [A - λ I, B] loses rank.
struct Mode {
  std::complex<double> eigenvalue;
  double reach = std::numeric_limits<double>::infinity();  ///< smallest singular value, relative
};
Mode WorstMode(const MatrixXd& A, const MatrixXd& B, bool discrete) {
  const Index n = A.rows();
  const double size = std::max(A.norm(), std::numeric_limits<double>::min());
  const double input = B.norm();
  const MatrixXd scaled = input > 0 ? MatrixXd(B * (size / input)) : B;
  Mode worst;
  for (const std::complex<double>& eigenvalue : Eigenvalues(A)) {
    const double growth = discrete ? std::abs(eigenvalue) - 1 : eigenvalue.real();
    if (growth < -1e-8 * (discrete ? 1 : size)) continue;
    // The real form [Re -Im; Im Re] of the complex matrix has each singular value twice.
    MatrixXd test = MatrixXd::Zero(2 * n, 2 * (n + B.cols()));
    for (const Index half : {Index{0}, n}) {
      test.block(half, half, n, n) = A - eigenvalue.real() * MatrixXd::Identity(n, n);
      test.block(half, 2 * n + (half == 0 ? 0 : B.cols()), n, B.cols()) = scaled;
    }
    test.block(0, n, n, n).diagonal().setConstant(eigenvalue.imag());
    test.block(n, 0, n, n).diagonal().setConstant(-eigenvalue.imag());
    const double reach = Eigen::JacobiSVD<MatrixXd>(test).singularValues()[2 * n - 1] / size;
    if (reach < worst.reach) worst = {eigenvalue, reach};
  }
  return worst;
}

[[noreturn]] void FailFor(const Words& words, const Mode& mode, const char* what) {
  const std::complex<double> z = mode.eigenvalue;
  const std::string value = z.imag() == 0 ? fmt::format("{:.6g}", z.real())
                                          : fmt::format("{:.6g} {} {:.6g} i", z.real(),
                                                        z.imag() < 0 ? '-' : '+', std::abs(z.imag()));
  Fail(words, fmt::format("the mode with eigenvalue {} does not decay and {}", value, what));
}

/// Returns scales d of the states, x = diag(d) z, that balance the Hamiltonian matrix, so that the row and
/// column of a state have equal norms (P. Benner, SIAM J. Sci. Comput. 22, 2001).
Eigen::VectorXd Balance(const MatrixXd& A, const MatrixXd& G, const MatrixXd& Q) {
  const Index n = A.rows();
  Eigen::VectorXd d = Eigen::VectorXd::Ones(n);
  for (int sweep = 0; sweep < 20; ++sweep) {
    for (Index i = 0; i < n; ++i) {
      double row = 0, column = 0;  // squared norms that decrease and increase with d[i]
      for (Index j = 0; j < n; ++j) {
        if (j != i) {
          row += std::pow(A(i, j) * d[j] / d[i], 2);
          column += std::pow(A(j, i) * d[i] / d[j], 2);
        }
        row += std::pow(G(i, j) / (d[i] * d[j]), 2);
        column += std::pow(Q(i, j) * d[i] * d[j], 2);
      }
      if (row > 0 && column > 0) d[i] *= std::pow(row / column, 0.25);
    }
  }
  // Powers of two avoid rounding errors.
  return d.unaryExpr([](double scale) { return std::exp2(std::round(std::log2(scale))); });
}

/// Solves A'S + S A - S G S + Q = 0 for the S with stable A - G S: [I; S] spans the eigenspace of the
/// Hamiltonian matrix's sign function for the eigenvalue -1.
MatrixXd SolveContinuous(const MatrixXd& A, const MatrixXd& G, const MatrixXd& Q) {
  const Index n = A.rows();
  MatrixXd Z(2 * n, 2 * n);
  Z << A, -G, -Q, -A.transpose();
  bool scaling = true;
  double last = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 100; ++i) {
    const Eigen::PartialPivLU<MatrixXd> lu(Z);
    const double log_determinant = lu.matrixLU().diagonal().cwiseAbs().array().log().sum();
    const double c = scaling ? std::exp(-log_determinant / static_cast<double>(2 * n)) : 1;
    const MatrixXd next = 0.5 * (c * Z + lu.inverse() / c);
    const double change = (next - Z).norm() / next.norm();
    Z = next;
    // Convergence is finally quadratic until rounding errors dominate.
    if (change < 1e-2) scaling = false;
    if (change < 1e-15 || (change < 1e-8 && change >= last)) break;
    last = change;
  }
  MatrixXd left(2 * n, n), right(2 * n, n);
  const MatrixXd identity = MatrixXd::Identity(n, n);
  left << Z.topRightCorner(n, n), Z.bottomRightCorner(n, n) + identity;
  right << Z.topLeftCorner(n, n) + identity, Z.bottomLeftCorner(n, n);
  const MatrixXd S = left.colPivHouseholderQr().solve(-right);
  return 0.5 * (S + S.transpose());
}

/// Solves S = A'S (I + G S)⁻¹ A + Q for the S with stable (I + G S)⁻¹ A by the structure-preserving doubling
/// algorithm (Chu, Fan and Lin, Linear Algebra Appl. 396, 2005). Iteration i covers 2^i periods. `converged`
/// may be null.
MatrixXd SolveDiscrete(MatrixXd A, MatrixXd G, const MatrixXd& Q, bool* converged) {
  const Index n = A.rows();
  MatrixXd S = Q;
  if (converged != nullptr) *converged = false;
  for (int i = 0; i < 60; ++i) {
    const Eigen::PartialPivLU<MatrixXd> W(MatrixXd::Identity(n, n) + G * S);
    const MatrixXd WA = W.solve(A), WG = W.solve(G);
    const MatrixXd change = A.transpose() * S * WA;
    G += A * WG * A.transpose();
    S += (change + change.transpose()) / 2;
    A = A * WA;
    if (!S.allFinite()) break;
    if (change.cwiseAbs().maxCoeff() > 1e-14 * S.cwiseAbs().maxCoeff()) continue;
    if (converged != nullptr) *converged = true;
    break;
  }
  return S;
}

LqrDesign Design(const Words& words, const MatrixXd& A, const MatrixXd& B, const MatrixXd& Q,
                 const MatrixXd& R, const MatrixXd& N) {
  CheckSize(words, "Q", Q, A.rows(), A.rows());
  CheckSize(words, "R", R, B.cols(), B.cols());
  if (N.size() > 0) CheckSize(words, "N", N, A.rows(), B.cols());
  CheckDefinite(words, "Q", Q, false);
  CheckDefinite(words, "R", R, true);
  const Eigen::LLT<MatrixXd> cholesky(R);
  // The input v = u + R⁻¹ N'x eliminates the cross term.
  MatrixXd free = A, weight = Q;
  if (N.size() > 0) {
    free -= B * cholesky.solve(N.transpose());
    weight -= N * cholesky.solve(N.transpose());
    weight = 0.5 * (weight + weight.transpose()).eval();
    CheckDefinite(words, "Q - N R^-1 N'", weight, false);
  }
  const Mode unreached = WorstMode(A, B, words.discrete);
  const Mode unweighted = WorstMode(free.transpose(), weight, words.discrete);
  constexpr double kNothing = 1e-11;
  if (unreached.reach < kNothing) FailFor(words, unreached, words.unreached);
  if (unweighted.reach < kNothing) FailFor(words, unweighted, words.unweighted);

  LqrDesign design;
  const MatrixXd reach = B * cholesky.solve(B.transpose());
  const Eigen::VectorXd d = Balance(free, reach, weight), inverse = d.cwiseInverse();
  const MatrixXd balanced = inverse.asDiagonal() * free * d.asDiagonal();
  const MatrixXd G = inverse.asDiagonal() * reach * inverse.asDiagonal();
  const MatrixXd balanced_weight = d.asDiagonal() * weight * d.asDiagonal();
  const MatrixXd solution = words.discrete ? SolveDiscrete(balanced, G, balanced_weight, nullptr)
                                           : SolveContinuous(balanced, G, balanced_weight);
  design.S = inverse.asDiagonal() * solution * inverse.asDiagonal();
  const MatrixXd cross = N.size() > 0 ? MatrixXd(N.transpose()) : MatrixXd::Zero(B.cols(), A.rows());
  if (words.discrete) {
    design.K = (R + B.transpose() * design.S * B).llt().solve(B.transpose() * design.S * A + cross);
  } else {
    design.K = cholesky.solve(B.transpose() * design.S + cross);
  }
  const MatrixXd loop = A - B * design.K;
  const Eigen::VectorXcd closed = loop.allFinite() ? Eigenvalues(loop) : Eigen::VectorXcd::Constant(1, 2);
  const bool stable = words.discrete ? closed.cwiseAbs().maxCoeff() < 1 : closed.real().maxCoeff() < 0;
  if (!stable) {
    const bool is_reach = unreached.reach < unweighted.reach;
    FailFor(words, is_reach ? unreached : unweighted, is_reach ? words.unreached : words.unweighted);
  }
  return design;
}

LqrDesign Feedback(const Words& words, const MatrixXd& A, const MatrixXd& B, const MatrixXd& Q,
                   const MatrixXd& R, const MatrixXd& N) {
  CheckSize(words, "A", A, std::max<Index>(1, A.rows()), std::max<Index>(1, A.rows()));
  CheckSize(words, "B", B, A.rows(), std::max<Index>(1, B.cols()));
  return Design(words, A, B, Q, R, N);
}

LqrDesign Filter(const Words& words, const MatrixXd& A, const MatrixXd& C, const MatrixXd& Q,
                 const MatrixXd& R) {
  CheckSize(words, "A", A, std::max<Index>(1, A.rows()), std::max<Index>(1, A.rows()));
  CheckSize(words, "C", C, std::max<Index>(1, C.rows()), A.rows());
  return Design(words, A.transpose(), C.transpose(), Q, R, {});
}

}  // namespace

LqrDesign Lqr(const MatrixXd& A, const MatrixXd& B, const MatrixXd& Q, const MatrixXd& R, const MatrixXd& N) {
  return Feedback({"Lqr", false, kNotSteered, kNotWeighed}, A, B, Q, R, N);
}

LqrDesign DiscreteLqr(const MatrixXd& A, const MatrixXd& B, const MatrixXd& Q, const MatrixXd& R,
                      const MatrixXd& N) {
  return Feedback({"DiscreteLqr", true, kNotSteered, kNotWeighed}, A, B, Q, R, N);
}

MatrixXd SolveDiscreteRiccati(const MatrixXd& A, const MatrixXd& B, const MatrixXd& Q, const MatrixXd& R) {
  bool converged;
  const MatrixXd P = SolveDiscrete(A, B * R.llt().solve(B.transpose()), Q, &converged);
  if (converged) return P;
  throw ParameterError(
      "The Riccati equation has no stabilising solution: check that the inputs reach every unstable mode and "
      "that the state cost sees every mode that does not decay by itself.");
}

KalmanDesign Kalman(const MatrixXd& A, const MatrixXd& C, const MatrixXd& Q, const MatrixXd& R) {
  const LqrDesign dual = Filter({"Kalman", false, kNotSeen, kNotDriven}, A, C, Q, R);
  return {dual.K.transpose(), dual.S};
}

KalmanDesign DiscreteKalman(const MatrixXd& A, const MatrixXd& C, const MatrixXd& Q, const MatrixXd& R) {
  const MatrixXd P = Filter({"DiscreteKalman", true, kNotSeen, kNotDriven}, A, C, Q, R).S;
  return {(C * P * C.transpose() + R).llt().solve(C * P).transpose(), P};
}

}  // namespace tenon
