#pragma once

#include <tenon/controllers/optimization/dual_active_set.h>

#include <gtest/gtest.h>

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

/// The largest residual of the Karush-Kuhn-Tucker conditions, which prove that x is the minimum of a convex
/// problem, and its name. Each residual is relative to the terms of its difference; it is infinite if a
/// number is not finite.
struct KktResidual {
  double largest = 0;
  std::string which;

  KktResidual(const QuadraticProgram& qp, const Eigen::VectorXd& x, const Eigen::VectorXd& multipliers) {
    if (!x.allFinite() || !multipliers.allFinite()) {
      Add(std::numeric_limits<double>::infinity(), "finiteness", 0);
      return;
    }
    const auto equalities = qp.b_eq.size(), inequalities = qp.b_in.size();
    const Eigen::MatrixXd H = qp.H.selfadjointView<Eigen::Lower>();
    const Eigen::VectorXd slope = H * x, lambda = multipliers.head(equalities),
                          mu = multipliers.tail(inequalities);
    Eigen::VectorXd pull = Eigen::VectorXd::Zero(x.size());
    if (equalities > 0) pull += qp.A_eq.transpose() * lambda;
    if (inequalities > 0) pull += qp.A_in.transpose() * mu;
    const double forces =
        std::max({slope.cwiseAbs().maxCoeff(), qp.g.cwiseAbs().maxCoeff(), pull.cwiseAbs().maxCoeff()});
    if (forces > 0) Add((slope + qp.g - pull).cwiseAbs().maxCoeff() / forces, "H x + g - A^T u", 0);
    for (Eigen::Index i = 0; i < equalities; ++i) {
      const double scale = std::abs(qp.b_eq[i]) + qp.A_eq.row(i).norm() * x.norm();
      const double residual = std::abs(qp.A_eq.row(i).dot(x) - qp.b_eq[i]);
      if (residual > 0) Add(residual / scale, "equality", i);
    }
    const double most = std::max(1e-300, multipliers.size() > 0 ? multipliers.cwiseAbs().maxCoeff() : 0.0);
    for (Eigen::Index i = 0; i < inequalities; ++i) {
      const double scale = std::abs(qp.b_in[i]) + qp.A_in.row(i).norm() * x.norm();
      const double slack = qp.A_in.row(i).dot(x) - qp.b_in[i];
      if (slack < 0) Add(-slack / scale, "inequality", i);
      Add(-mu[i] / most, "multiplier", i);
      if (mu[i] > 0 && slack > 0) Add(mu[i] * slack / (most * scale), "complementarity", i);
    }
  }

 private:
  void Add(double residual, const char* name, Eigen::Index i) {
    if (residual > largest || std::isnan(residual)) {
      largest = residual;
      which = name + (" " + std::to_string(i));
    }
  }
};

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
