#pragma once

// CGAL's solver of quadratic programmes, which computes in exact rational numbers. Link gmp and mpfr.

// CGAL's internal checks are off, because in unoptimised builds they take hours for the programmes of the
// walk.
#ifndef CGAL_NDEBUG
#define CGAL_NDEBUG
#endif
#include <tenon/controllers/optimization/dual_active_set.h>

#include <CGAL/Gmpzf.h>
#include <CGAL/QP_functions.h>
#include <CGAL/QP_models.h>

#include <optional>

namespace tenon::test {

/// The minimiser, rounded at the end; std::nullopt if the problem is infeasible.
inline std::optional<Eigen::VectorXd> SolveExactly(const QuadraticProgram& qp) {
  CGAL::Quadratic_program<double> exact(CGAL::LARGER, false, 0, false, 0);
  const int variables = static_cast<int>(qp.g.size()), equalities = static_cast<int>(qp.b_eq.size());
  const auto set_row = [&](int row, const auto& a, double b, CGAL::Comparison_result relation) {
    for (int j = 0; j < variables; ++j) exact.set_a(j, row, a[j]);
    exact.set_b(row, b);
    exact.set_r(row, relation);
  };
  for (int i = 0; i < equalities; ++i) set_row(i, qp.A_eq.row(i), qp.b_eq[i], CGAL::EQUAL);
  for (int i = 0; i < qp.b_in.size(); ++i) set_row(equalities + i, qp.A_in.row(i), qp.b_in[i], CGAL::LARGER);
  for (int i = 0; i < variables; ++i) {
    exact.set_c(i, qp.g[i]);
    for (int j = 0; j <= i; ++j) exact.set_d(i, j, qp.H(i, j));  // twice the matrix of x^T D x
  }
  const auto solution = CGAL::solve_quadratic_program(exact, CGAL::Gmpzf());
  if (solution.is_infeasible()) return std::nullopt;
  Eigen::VectorXd x(variables);
  auto value = solution.variable_values_begin();
  for (double& entry : x) entry = CGAL::to_double(*value++);
  return x;
}

}  // namespace tenon::test
