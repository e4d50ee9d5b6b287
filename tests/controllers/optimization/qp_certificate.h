#pragma once

#include <tenon/controllers/optimization/dual_active_set.h>
#include <tenon/tests/controllers/optimization/kkt_residual.h>
#include <tenon/tests/controllers/optimization/owned_qp.h>

#include <gtest/gtest.h>

namespace tenon::test {

/// Succeeds if the conditions of KktResidual prove that x is the minimum.
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
