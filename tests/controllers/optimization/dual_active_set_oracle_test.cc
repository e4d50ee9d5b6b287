// The dual active set method against CGAL's solver, which computes in exact rational numbers.

#include <tenon/tests/controllers/optimization/exact_qp.h>
#include <tenon/tests/controllers/optimization/qp_certificate.h>
#include <tenon/tests/testing/block_test.h>

#include <random>

namespace tenon::dual_active_set_oracle_test {

using test::OwnedQp;

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
    const auto exact = test::SolveExactly(qp.view());
    const QpReport report = solver.Solve(qp.view());
    ASSERT_EQ(report.status, exact ? QpStatus::kSolved : QpStatus::kInfeasible)
        << "problem " << i << ": " << report.Message();
    if (!exact) {
      ++infeasible;
      continue;
    }
    ++feasible;
    EXPECT_TRUE(test::IsOptimal(qp.view(), solver)) << "problem " << i;
    EXPECT_THAT(solver.x(), IsNear(*exact, 1e-10 * (1 + exact->norm()))) << "problem " << i;
  }
  EXPECT_GT(feasible, 50);
  EXPECT_GT(infeasible, 50);
}

}  // namespace tenon::dual_active_set_oracle_test
