#pragma once

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
  explicit OwnedQp(const QuadraticProgram& qp)
      : H(qp.H), g(qp.g), A_eq(qp.A_eq), b_eq(qp.b_eq), A_in(qp.A_in), b_in(qp.b_in) {}
  QuadraticProgram view() const { return {H, g, A_eq, b_eq, A_in, b_in}; }
};

}  // namespace tenon::test
