#pragma once

#include <gtest/gtest.h>

#include <tenon/controllers/optimization/dual_active_set.h>
#include <tenon/tests/controllers/optimization/kkt_residual.h>

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

/// Whether x is proved to be the minimum, see KktResidual.
inline ::testing::AssertionResult IsOptimal(const QuadraticProgram& qp, const Eigen::VectorXd& x,
                                            const Eigen::VectorXd& multipliers, double tolerance = 1e-9) {
  const KktResidual residual(qp, x, multipliers);
  if (residual.largest <= tolerance) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << residual.which << " is off by " << residual.largest;
}

inline ::testing::AssertionResult IsOptimal(const QuadraticProgram& qp, const DualActiveSet& solver) {
  return IsOptimal(qp, solver.x(), solver.multipliers());
}

}  // namespace tenon::test
