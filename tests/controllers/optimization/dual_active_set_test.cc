#include <tenon/tests/controllers/optimization/qp_certificate.h>
#include <tenon/tests/testing/block_test.h>

#include <random>

namespace tenon::dual_active_set_test {

using test::IsOptimal, test::OwnedQp;

double Uniform(std::mt19937& generator, double size = 1) {
  return std::uniform_real_distribution<double>(-size, size)(generator);
}

// Feasible, because a point is: the first half of the inequalities passes through it, and the cost pulls away
// from it. Condition number of H up to about 1e4.
OwnedQp RandomFeasible(std::mt19937& generator, int variables, int equalities, int inequalities) {
  OwnedQp qp(variables, equalities, inequalities);
  const auto fill = [&](auto& matrix) {
    for (Eigen::Index i = 0; i < matrix.rows(); ++i)
      for (Eigen::Index j = 0; j < matrix.cols(); ++j) matrix(i, j) = Uniform(generator);
  };
  fill(qp.H);
  qp.H = (qp.H * qp.H.transpose()).eval();
  qp.H.diagonal().array() += 0.01;
  fill(qp.g);
  qp.g *= 10;
  fill(qp.A_eq);
  fill(qp.A_in);
  Eigen::VectorXd point(variables);
  fill(point);
  qp.b_eq = qp.A_eq * point;
  qp.b_in = qp.A_in * point;
  for (int i = inequalities / 2; i < inequalities; ++i) qp.b_in[i] -= std::abs(Uniform(generator));
  return qp;
}

// min (x - 3)^2 / 2 + (y - 2)^2 / 2 in the triangle x, y >= 0, x + y <= 2: (1.5, 0.5), multiplier 1.5.
OwnedQp Triangle() {
  OwnedQp qp(2, 0, 3);
  qp.g << -3, -2;
  qp.A_in << 1, 0, 0, 1, -1, -1;
  qp.b_in << 0, 0, -2;
  return qp;
}

TEST(DualActiveSet, ProjectsOnATriangle) {
  DualActiveSet solver(2, 3);
  const OwnedQp qp = Triangle();
  const QpReport report = solver.Solve(qp.view());
  ASSERT_TRUE(report.ok()) << report.Message();
  EXPECT_THAT(solver.x(), IsNear(Eigen::Vector2d(1.5, 0.5), 1e-14));
  EXPECT_THAT(solver.multipliers(), IsNear(Eigen::Vector3d(0, 0, 1.5), 1e-14));
  EXPECT_THAT(std::vector<int>(solver.active().begin(), solver.active().end()), ::testing::ElementsAre(2));
  EXPECT_TRUE(IsOptimal(qp.view(), solver));
}

TEST(DualActiveSet, WithoutConstraintsItIsANewtonStep) {
  DualActiveSet solver(3, 0);
  OwnedQp qp(3, 0, 0);
  qp.H << 4, 1, 0, 1, 3, 0, 0, 0, 2;
  qp.g << 1, 2, 3;
  ASSERT_TRUE(solver.Solve(qp.view()).ok());
  EXPECT_THAT((qp.H * solver.x()).eval(), IsNear(-qp.g, 1e-14));
}

TEST(DualActiveSet, MeetsTheOptimalityConditionsOfRandomProblems) {
  std::mt19937 generator(1);
  DualActiveSet solver(30, 100);
  int active = 0;
  for (int i = 0; i < 120; ++i) {
    const int variables = 1 + i % 30;
    const int equalities = static_cast<int>(generator() % (variables + 1)) / 2;
    const int inequalities = static_cast<int>(generator() % 70);
    const OwnedQp qp = RandomFeasible(generator, variables, equalities, inequalities);
    const QpReport report = solver.Solve(qp.view());
    ASSERT_TRUE(report.ok()) << report.Message() << " problem " << i;
    ASSERT_TRUE(IsOptimal(qp.view(), solver)) << "problem " << i;
    active += static_cast<int>(solver.active().size());
  }
  EXPECT_GT(active, 240);  // they are not all trivial
}

// H in blocks of one to five variables, whose factors are sparse.
TEST(DualActiveSet, MeetsTheOptimalityConditionsWhereHIsInBlocks) {
  std::mt19937 generator(9);
  DualActiveSet solver(30, 60);
  for (int i = 0; i < 90; ++i) {
    const int variables = 1 + i % 30, equalities = static_cast<int>(generator() % (variables + 1)) / 2;
    OwnedQp qp = RandomFeasible(generator, variables, equalities, static_cast<int>(generator() % 40));
    const int single = static_cast<int>(generator() % (variables + 1));
    for (int begin = 0, end = 0; begin < variables; begin = end) {
      end = std::min(variables, begin + (begin < single ? 1 : 1 + static_cast<int>(generator() % 5)));
      qp.H.block(end, begin, variables - end, end - begin).setZero();
      // The upper triangle is not read.
      qp.H.block(begin, end, end - begin, variables - end).setConstant(NAN);
    }
    const QpReport report = solver.Solve(qp.view());
    ASSERT_TRUE(report.ok()) << report.Message() << " problem " << i;
    ASSERT_TRUE(IsOptimal(qp.view(), solver)) << "problem " << i;
  }
}

TEST(DualActiveSet, SolvesWeightsThatDifferByTenOrdersOfMagnitude) {
  std::mt19937 generator(2);
  DualActiveSet solver(30, 60);
  for (int i = 0; i < 40; ++i) {
    OwnedQp qp = RandomFeasible(generator, 30, 18, 40);
    Eigen::VectorXd scale(30);
    for (int k = 0; k < 30; ++k) scale[k] = std::pow(10, 2.5 * Uniform(generator));
    qp.H = (scale.asDiagonal() * qp.H * scale.asDiagonal()).eval();
    const QpReport report = solver.Solve(qp.view());
    ASSERT_TRUE(report.ok()) << report.Message();
    ASSERT_TRUE(IsOptimal(qp.view(), solver)) << "problem " << i;
  }
}

TEST(DualActiveSet, ARightGuessTakesNoIterationAndAnyGuessIsSafe) {
  std::mt19937 generator(3);
  DualActiveSet solver(12, 40);
  int cold = 0, near = 0;
  for (int i = 0; i < 100; ++i) {
    OwnedQp qp = RandomFeasible(generator, 12, i % 5, 35);
    cold += solver.Solve(qp.view()).iterations;
    const Eigen::VectorXd x = solver.x();
    std::vector<int> guess(solver.active().begin(), solver.active().end());
    const QpReport again = solver.Solve(qp.view(), guess);
    ASSERT_TRUE(again.ok());
    EXPECT_EQ(again.iterations, 0) << "problem " << i;
    EXPECT_THAT(solver.x(), IsNear(x, 1e-9));

    std::vector<int> wrong{-1, 1000};
    for (int k = 0; k < 20; ++k) wrong.push_back(static_cast<int>(generator() % 35));
    ASSERT_TRUE(solver.Solve(qp.view(), wrong).ok());
    EXPECT_TRUE(IsOptimal(qp.view(), solver));
    EXPECT_THAT(solver.x(), IsNear(x, 1e-9));

    for (int k = 0; k < 12; ++k) qp.g[k] += 0.1 * Uniform(generator);
    near += solver.Solve(qp.view(), guess).iterations;
    EXPECT_TRUE(IsOptimal(qp.view(), solver));
  }
  EXPECT_LT(5 * near, cold);
}

// Rows that are nearly parallel in the metric of H, which is 1e8 times steeper along one axis.
TEST(DualActiveSet, RowsThatAreNearlyDependentAreNoContradiction) {
  DualActiveSet solver(2, 4);
  OwnedQp qp(2, 0, 2);  // x + y >= 0, -(1 + 1e-7) x - y >= 1e-3
  qp.H << 1, 0, 0, 1e-8;
  qp.A_in << 1, 1, -(1 + 1e-7), -1;
  qp.b_in << 0, 1e-3;
  const QpReport report = solver.Solve(qp.view());  // x = -1e4, y = 1e4, but not to ten digits
  EXPECT_EQ(report.status, QpStatus::kInaccurate);
  EXPECT_EQ(report.restarts, 1);
}

TEST(DualActiveSet, EqualitiesThatDependOnOthersAreMetInTheEnd) {
  DualActiveSet solver(2, 4);
  OwnedQp qp(2, 2, 1);  // x + y = 0, (1 + 1e-7) x + y = 0, so x = 0, but x >= 1
  qp.H << 1, 0, 0, 1e-12;
  qp.A_eq << 1, 1, 1 + 1e-7, 1;
  qp.b_eq << 0, 0;
  qp.A_in << 1, 0;
  qp.b_in << 1;
  const QpReport report = solver.Solve(qp.view());
  EXPECT_EQ(report.status, QpStatus::kInfeasible) << report.Message();
}

TEST(DualActiveSet, NamesTheConstraintThatContradictsTheOthers) {
  DualActiveSet solver(2, 8);
  OwnedQp qp = Triangle();
  qp.b_in << 1, 1.5, -2;  // x >= 1, y >= 1.5, x + y <= 2
  QpReport report = solver.Solve(qp.view());
  EXPECT_EQ(report.status, QpStatus::kInfeasible);
  EXPECT_GE(report.constraint, 0);
  EXPECT_LT(report.constraint, 3);
  EXPECT_NE(report.Message().find("constraint " + std::to_string(report.constraint)), std::string::npos);

  OwnedQp contradiction(2, 2, 1);  // x + y = 1, 2 x + 2 y = 3
  contradiction.A_eq << 1, 1, 2, 2;
  contradiction.b_eq << 1, 3;
  report = solver.Solve(contradiction.view());
  EXPECT_EQ(report.status, QpStatus::kInfeasible);
  EXPECT_EQ(report.constraint, 1);

  OwnedQp against(2, 1, 2);  // x = 1, x >= 2
  against.A_eq << 1, 0;
  against.b_eq << 1;
  against.A_in << 0, 1, 1, 0;
  against.b_in << -5, 2;
  report = solver.Solve(against.view());
  EXPECT_EQ(report.status, QpStatus::kInfeasible);
  EXPECT_EQ(report.constraint, 2);

  OwnedQp nothing(2, 0, 1);  // 0 >= 1
  nothing.b_in << 1;
  report = solver.Solve(nothing.view());
  EXPECT_EQ(report.status, QpStatus::kInfeasible);
  EXPECT_EQ(report.constraint, 0);
}

// Farkas: a combination of the rows with weights w >= 0 is zero, but that of the bounds is positive.
TEST(DualActiveSet, DetectsRandomInfeasibleProblemsFromAnyGuess) {
  std::mt19937 generator(4);
  DualActiveSet solver(12, 60);
  for (int i = 0; i < 100; ++i) {
    OwnedQp qp = RandomFeasible(generator, 12, i % 4, 30);
    const int combined = 2 + i % 8;
    Eigen::RowVectorXd sum = Eigen::RowVectorXd::Zero(12);
    double bound = 0;
    for (int k = 0; k < combined; ++k) {
      const double weight = std::abs(Uniform(generator)) + 0.1;
      sum += weight * qp.A_in.row(k);
      bound += weight * qp.b_in[k];
    }
    qp.A_in.row(29) = -sum;
    qp.b_in[29] = -bound + 0.01;
    std::vector<int> guess;
    for (int k = 0; k < i % 10; ++k) guess.push_back(static_cast<int>(generator() % 30));
    const QpReport report = solver.Solve(qp.view(), guess);
    EXPECT_EQ(report.status, QpStatus::kInfeasible) << "problem " << i << ": " << report.Message();
  }
}

TEST(DualActiveSet, SolvesDuplicateAndRedundantConstraints) {
  std::mt19937 generator(5);
  DualActiveSet solver(10, 120);
  for (int i = 0; i < 60; ++i) {
    const OwnedQp plain = RandomFeasible(generator, 10, 3, 16);
    OwnedQp qp(10, 6, 64);
    qp.H = plain.H;
    qp.g = plain.g;
    qp.A_eq << plain.A_eq, 2 * plain.A_eq.row(0), plain.A_eq.row(1) - plain.A_eq.row(2), plain.A_eq.row(2);
    qp.b_eq << plain.b_eq, 2 * plain.b_eq[0], plain.b_eq[1] - plain.b_eq[2], plain.b_eq[2];
    // Every constraint scaled by 3, relaxed by 0.1, and added to its neighbour.
    for (int k = 0; k < 16; ++k) {
      const int next = (k + 1) % 16;
      qp.A_in.row(k) = plain.A_in.row(k);
      qp.A_in.row(16 + k) = 3 * plain.A_in.row(k);
      qp.A_in.row(32 + k) = plain.A_in.row(k);
      qp.A_in.row(48 + k) = plain.A_in.row(k) + plain.A_in.row(next);
      qp.b_in[k] = plain.b_in[k];
      qp.b_in[16 + k] = 3 * plain.b_in[k];
      qp.b_in[32 + k] = plain.b_in[k] - 0.1;
      qp.b_in[48 + k] = plain.b_in[k] + plain.b_in[next];
    }
    ASSERT_TRUE(solver.Solve(plain.view()).ok());
    const Eigen::VectorXd x = solver.x();
    std::vector<int> guess(64);
    for (int k = 0; k < 64; ++k) guess[k] = k;
    for (const auto& start : {std::vector<int>{}, guess}) {
      const QpReport report = solver.Solve(qp.view(), start);
      ASSERT_TRUE(report.ok()) << report.Message() << " problem " << i;
      EXPECT_TRUE(IsOptimal(qp.view(), solver));
      EXPECT_THAT(solver.x(), IsNear(x, 1e-8));
    }
  }
}

TEST(DualActiveSet, BlocksOfLargerMatricesServeWithoutCopies) {
  std::mt19937 generator(7);
  const OwnedQp qp = RandomFeasible(generator, 8, 2, 20);
  Eigen::MatrixXd H = Eigen::MatrixXd::Constant(11, 9, 1e9);
  ConstraintMatrix A = ConstraintMatrix::Constant(40, 13, 1e9);
  H.topLeftCorner(8, 8) = qp.H;
  A.topLeftCorner(2, 8) = qp.A_eq;
  A.block(10, 0, 20, 8) = qp.A_in;
  DualActiveSet solver(8, 22), copy = solver;
  ASSERT_TRUE(solver.Solve(qp.view()).ok());
  const Eigen::VectorXd x = solver.x();
  ASSERT_TRUE(copy.Solve(RandomFeasible(generator, 8, 0, 0).view()).ok());
  const AllocationGuard guard;
  ASSERT_TRUE(copy.Solve({H.topLeftCorner(8, 8), qp.g, A.topLeftCorner(2, 8), qp.b_eq, A.block(10, 0, 20, 8),
                          qp.b_in})
                  .ok());
  EXPECT_EQ(guard.count(), 0);
  EXPECT_THAT(copy.x(), IsNear(x, 0));
}

TEST(DualActiveSet, StopsAfterTheIterationsThatItMayTake) {
  std::mt19937 generator(8);
  DualActiveSet unlimited(20, 60), limited(20, 60, 5);
  const OwnedQp qp = RandomFeasible(generator, 20, 0, 60);
  ASSERT_GT(unlimited.Solve(qp.view()).iterations, 5);
  const QpReport report = limited.Solve(qp.view());
  EXPECT_EQ(report.status, QpStatus::kIterationLimit);
  EXPECT_EQ(report.iterations, 5);
}

TEST(DualActiveSet, RefusesProblemsThatAreNotConvexOrNotFinite) {
  DualActiveSet solver(2, 3);
  OwnedQp qp = Triangle();
  qp.H << 1, 2, 2, 1;
  QpReport report = solver.Solve(qp.view());
  EXPECT_EQ(report.status, QpStatus::kNotConvex);
  EXPECT_EQ(report.constraint, 1);
  qp.H << 1, 1, 1, 1;  // only semidefinite
  EXPECT_EQ(solver.Solve(qp.view()).status, QpStatus::kNotConvex);

  const double nan = NAN;
  for (int where = 0; where < 4; ++where) {
    qp = Triangle();
    (where == 0 ? qp.H(1, 0) : where == 1 ? qp.g[0] : where == 2 ? qp.A_in(2, 1) : qp.b_in[1]) = nan;
    EXPECT_EQ(solver.Solve(qp.view()).status, QpStatus::kNotFinite) << where;
  }
  qp = Triangle();
  ASSERT_TRUE(solver.Solve(qp.view()).ok());  // and still solves the next problem
  EXPECT_TRUE(IsOptimal(qp.view(), solver));
}

TEST(DualActiveSet, RefusesSizesThatDoNotFit) {
  EXPECT_TRUE(Throws<ParameterError>([] { DualActiveSet(0, 3); }, "0 variables"));
  DualActiveSet solver(2, 3);
  OwnedQp qp = Triangle();
  qp.g.setZero(3);
  EXPECT_TRUE(Throws<ParameterError>([&] { solver.Solve(qp.view()); }, "H is 2 x 2", "g has 3"));
  qp = Triangle();
  qp.b_in.setZero(2);
  EXPECT_TRUE(Throws<ParameterError>([&] { solver.Solve(qp.view()); }, "A_in is 3 x 2", "b_in has 2"));
  qp = Triangle();
  qp.b_eq.setZero(1);
  EXPECT_TRUE(Throws<ParameterError>([&] { solver.Solve(qp.view()); }, "A_eq is 0 x 2", "b_eq has 1"));
  const OwnedQp large(3, 0, 0), many(2, 1, 3);
  EXPECT_TRUE(Throws<ParameterError>([&] { solver.Solve(large.view()); }, "3 variables"));
  EXPECT_TRUE(Throws<ParameterError>([&] { solver.Solve(many.view()); }, "4 constraints"));
}

}  // namespace tenon::dual_active_set_test
