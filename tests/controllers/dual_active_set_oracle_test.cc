// The dual active set method against CGAL's solver, which computes in exact rational numbers.

#include <CGAL/Gmpzf.h>
#include <CGAL/QP_functions.h>
#include <CGAL/QP_models.h>
#include <gtest/gtest.h>

#include <random>

#include "tenon/controllers/dual_active_set.h"
#include "tenon/tests/controllers/qp_certificate.h"
#include "tenon/tests/testing/matchers.h"

namespace tenon {
namespace {

using test::OwnedQp;
using ExactProgram = CGAL::Quadratic_program<double>;
using ExactSolution = CGAL::Quadratic_program_solution<CGAL::Gmpzf>;

ExactSolution SolveExactly(const OwnedQp& qp) {
  ExactProgram exact(CGAL::LARGER, false, 0, false, 0);
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
  return CGAL::solve_quadratic_program(exact, CGAL::Gmpzf());
}

// Integers, small, so that degenerate vertices and infeasible problems are common.
OwnedQp RandomIntegers(std::mt19937& generator, int variables, int equalities, int inequalities) {
  OwnedQp qp(variables, equalities, inequalities);
  const auto integer = [&](int size) { return std::uniform_int_distribution<int>(-size, size)(generator); };
  Eigen::MatrixXd root = qp.H;
  for (auto* matrix : {&root})
    for (double& entry : matrix->reshaped()) entry = integer(2);
  qp.H = root * root.transpose() + Eigen::MatrixXd::Identity(variables, variables);
  for (double& entry : qp.g) entry = integer(20);
  for (double& entry : qp.A_eq.reshaped()) entry = integer(2);
  for (double& entry : qp.A_in.reshaped()) entry = integer(2);
  for (double& entry : qp.b_eq) entry = integer(1);
  for (double& entry : qp.b_in) entry = integer(3);
  return qp;
}

TEST(DualActiveSetOracle, AgreesWithExactArithmetic) {
  std::mt19937 generator(1);
  DualActiveSet solver(6, 20);
  int feasible = 0, infeasible = 0;
  for (int i = 0; i < 300; ++i) {
    const OwnedQp qp = RandomIntegers(generator, 2 + i % 5, i % 3, 4 + i % 9);
    const ExactSolution exact = SolveExactly(qp);
    const QpReport report = solver.Solve(qp.view());
    ASSERT_EQ(report.status, exact.is_infeasible() ? QpStatus::kInfeasible : QpStatus::kSolved)
        << "problem " << i << ": " << report.Message();
    if (exact.is_infeasible()) {
      ++infeasible;
      continue;
    }
    ++feasible;
    EXPECT_TRUE(test::IsOptimal(qp.view(), solver)) << "problem " << i;
    Eigen::VectorXd x(qp.g.size());
    auto value = exact.variable_values_begin();
    for (double& entry : x) entry = CGAL::to_double(*value++);
    EXPECT_THAT(solver.x(), IsNear(x, 1e-10 * (1 + x.norm()))) << "problem " << i;
  }
  EXPECT_GT(feasible, 50);
  EXPECT_GT(infeasible, 50);
}

}  // namespace
}  // namespace tenon
