#pragma once

#include <gtest/gtest.h>

#include <algorithm>

#include <tenon/controllers/optimization/dual_active_set.h>

namespace tenon::test {

/// A problem that owns its numbers.
struct OwnedQp {
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  ConstraintMatrix A_eq;
  Eigen::VectorXd b_eq;
  ConstraintMatrix A_in;
  Eigen::VectorXd b_in;

  OwnedQp(int variables, int equalities, int inequalities)
      : H(Eigen::MatrixXd::Identity(variables, variables)),
        g(Eigen::VectorXd::Zero(variables)),
        A_eq(ConstraintMatrix::Zero(equalities, variables)),
        b_eq(Eigen::VectorXd::Zero(equalities)),
        A_in(ConstraintMatrix::Zero(inequalities, variables)),
        b_in(Eigen::VectorXd::Zero(inequalities)) {}
  QuadraticProgram view() const { return {H, g, A_eq, b_eq, A_in, b_in}; }
};

/// Whether x and the multipliers meet the conditions of Karush, Kuhn and Tucker, which prove that x is the
/// minimum of a convex problem: each residual relative to the terms that it is the difference of.
inline ::testing::AssertionResult IsOptimal(const QuadraticProgram& qp, const Eigen::VectorXd& x,
                                            const Eigen::VectorXd& multipliers, double tolerance = 1e-9) {
  if (!x.allFinite() || !multipliers.allFinite()) return ::testing::AssertionFailure() << "not finite";
  const auto equalities = qp.b_eq.size(), inequalities = qp.b_in.size();
  const Eigen::MatrixXd H = qp.H.selfadjointView<Eigen::Lower>();
  const Eigen::VectorXd slope = H * x, lambda = multipliers.head(equalities),
                        mu = multipliers.tail(inequalities);
  Eigen::VectorXd pull = Eigen::VectorXd::Zero(x.size());
  if (equalities > 0) pull += qp.A_eq.transpose() * lambda;
  if (inequalities > 0) pull += qp.A_in.transpose() * mu;
  const double forces =
      std::max({slope.cwiseAbs().maxCoeff(), qp.g.cwiseAbs().maxCoeff(), pull.cwiseAbs().maxCoeff()});
  const double stationarity = (slope + qp.g - pull).cwiseAbs().maxCoeff();
  if (!(stationarity <= tolerance * forces))
    return ::testing::AssertionFailure() << "H x + g - A^T u = " << stationarity << " of " << forces;
  for (Eigen::Index i = 0; i < equalities; ++i) {
    const double scale = std::abs(qp.b_eq[i]) + qp.A_eq.row(i).norm() * x.norm();
    const double residual = std::abs(qp.A_eq.row(i).dot(x) - qp.b_eq[i]);
    if (!(residual <= tolerance * scale))
      return ::testing::AssertionFailure() << "equality " << i << " is off by " << residual;
  }
  const double largest = std::max(1e-300, multipliers.size() > 0 ? multipliers.cwiseAbs().maxCoeff() : 0.0);
  for (Eigen::Index i = 0; i < inequalities; ++i) {
    const double scale = std::abs(qp.b_in[i]) + qp.A_in.row(i).norm() * x.norm();
    const double slack = qp.A_in.row(i).dot(x) - qp.b_in[i];
    if (!(slack >= -tolerance * scale))
      return ::testing::AssertionFailure() << "inequality " << i << " is violated by " << -slack;
    if (!(mu[i] >= -tolerance * largest))
      return ::testing::AssertionFailure() << "multiplier " << i << " is " << mu[i];
    if (!(mu[i] * slack <= tolerance * largest * scale))
      return ::testing::AssertionFailure()
             << "inequality " << i << " has slack " << slack << " and multiplier " << mu[i];
  }
  return ::testing::AssertionSuccess();
}

inline ::testing::AssertionResult IsOptimal(const QuadraticProgram& qp, const DualActiveSet& solver) {
  return IsOptimal(qp, solver.x(), solver.multipliers());
}

}  // namespace tenon::test
