#include <tenon/controllers/optimization/box_newton.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>

#include <random>

namespace tenon::box_newton_test {

template <int N>
struct Problem {
  Eigen::Matrix<double, N, N> H;
  Eigen::Matrix<double, N, 1> g, lower, upper;
};

template <int N>
Problem<N> RandomProblem(std::mt19937& generator, int size) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  const Eigen::MatrixXd root = Eigen::MatrixXd::NullaryExpr(size, size, [&] { return uniform(generator); });
  Problem<N> problem;
  problem.H = root * root.transpose() + 0.01 * Eigen::MatrixXd::Identity(size, size);
  problem.g = 3 * Eigen::VectorXd::NullaryExpr(size, [&] { return uniform(generator); });
  problem.lower = Eigen::VectorXd::NullaryExpr(size, [&] { return uniform(generator) - 1; });
  problem.upper = Eigen::VectorXd::NullaryExpr(size, [&] { return uniform(generator) + 1; });
  return problem;
}

// The minimum of a convex function over a box is where the gradient is zero, or points out of the box.
template <int N>
void ExpectOptimal(const Problem<N>& problem, const Eigen::VectorXd& x) {
  const Eigen::VectorXd gradient = problem.H * x + problem.g;
  for (int i = 0; i < x.size(); ++i) {
    ASSERT_GE(x[i], problem.lower[i]);
    ASSERT_LE(x[i], problem.upper[i]);
    if (x[i] > problem.lower[i]) {
      EXPECT_LE(gradient[i], 1e-10);
    }
    if (x[i] < problem.upper[i]) {
      EXPECT_GE(gradient[i], -1e-10);
    }
  }
}

TEST(BoxNewton, SolvesRandomProblemsToTheOptimalityConditions) {
  std::mt19937 generator(1);
  int held = 0;
  BoxNewton<5> box;
  for (int i = 0; i < 100; ++i) {
    const auto problem = RandomProblem<5>(generator, 5);
    Eigen::Matrix<double, 5, 1> x = 3 * problem.g;  // may be out of bounds
    ASSERT_TRUE(box.Solve(problem.H, problem.g, problem.lower, problem.upper, x));
    ExpectOptimal(problem, x);
    held += 5 - static_cast<int>(box.free().sum());
  }
  EXPECT_GT(held, 100);
}

TEST(BoxNewton, SizeMayBeKnownAtRunTimeOnly) {
  std::mt19937 generator(2);
  BoxNewton<Eigen::Dynamic> box(7);
  auto problem = RandomProblem<Eigen::Dynamic>(generator, 7);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(7);
  EXPECT_EQ(
      AllocationsOf([&] { ASSERT_TRUE(box.Solve(problem.H, problem.g, problem.lower, problem.upper, x)); }),
      0);
  ExpectOptimal(problem, x);
}

TEST(BoxNewton, SensitivityIsThatOfTheSolution) {
  std::mt19937 generator(3);
  const auto problem = RandomProblem<4>(generator, 4);
  BoxNewton<4> box;
  Eigen::Vector4d x = Eigen::Vector4d::Zero(), moved = x;
  ASSERT_TRUE(box.Solve(problem.H, problem.g, problem.lower, problem.upper, x));
  ASSERT_GT(box.free().sum(), 0);
  ASSERT_LT(box.free().sum(), 4);
  Eigen::Matrix<double, 4, 3> G = Eigen::Matrix<double, 4, 3>::Random();
  Eigen::Matrix<double, 3, 4> K = G.transpose();
  box.Sensitivity(K);
  const Eigen::Vector3d y(1e-4, -2e-4, 3e-4);
  ASSERT_TRUE(box.Solve(problem.H, problem.g + G * y, problem.lower, problem.upper, moved));
  EXPECT_THAT(moved, IsNear(x + K.transpose() * y, 1e-12));
}

TEST(BoxNewton, WithinTheBoundsItIsTheSolutionWithoutThem) {
  std::mt19937 generator(5);
  auto problem = RandomProblem<4>(generator, 4);
  const Eigen::Vector4d best = -test::Solve(problem.H, problem.g);
  BoxNewton<4> box;
  Eigen::Vector4d x = Eigen::Vector4d::Zero(), free = x;
  ASSERT_TRUE(box.SolveFree(problem.H, problem.g, free));
  EXPECT_THAT(free, IsNear(best, 1e-10));
  problem.lower = free;  // one bound of each is just reached
  problem.upper = free;
  problem.lower.head<2>().array() -= 100;
  problem.upper.tail<2>().array() += 100;
  ASSERT_TRUE(box.Solve(problem.H, problem.g, problem.lower, problem.upper, x));
  EXPECT_EQ(x, free);
  EXPECT_EQ(box.free().sum(), 4);
  problem.upper[1] -= 1e-3;
  ASSERT_TRUE(box.Solve(problem.H, problem.g, problem.lower, problem.upper, x));
  EXPECT_EQ(x[1], problem.upper[1]);
  EXPECT_LT(box.free().sum(), 4);
  ExpectOptimal(problem, x);
}

// H need not be convex along entries that are at their bounds.
TEST(BoxNewton, NeedsToBeConvexOnTheFreeEntriesOnly) {
  BoxNewton<2> box;
  Eigen::Vector2d x(0.2, 1), lower(-1, -1), upper(1, 1), g(0.1, -3);
  const Eigen::Matrix2d H = Eigen::Vector2d(1, -1).asDiagonal();
  ASSERT_TRUE(box.Solve(H, g, lower, upper, x));
  EXPECT_THAT(x, IsNear(Eigen::Vector2d(-0.1, 1), 1e-12));
}

TEST(BoxNewton, RefusesProblemsThatAreNotConvexOrNotFinite) {
  BoxNewton<2> box;
  Eigen::Vector2d x(0, 0), lower(-1, -1), upper(1, 1), g(0.1, 0.1);
  Eigen::Matrix2d H = Eigen::Vector2d(1, -1).asDiagonal();
  EXPECT_FALSE(box.Solve(H, g, lower, upper, x));
  EXPECT_FALSE(box.SolveFree(H, g, x));
  H.setIdentity();
  g[0] = NAN;
  EXPECT_FALSE(box.Solve(H, g, lower, upper, x));
  const double infinity = INFINITY;
  g[0] = -infinity;
  lower.setConstant(-infinity);
  upper.setConstant(infinity);
  EXPECT_FALSE(box.Solve(H, g, lower, upper, x));
}

}  // namespace tenon::box_newton_test
