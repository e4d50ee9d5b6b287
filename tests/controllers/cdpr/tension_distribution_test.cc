#include <tenon/controllers/cdpr/tension_distribution.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Dense>
#include <nlopt.hpp>

#include <random>

namespace tenon::tension_distribution_test {

using Eigen::Matrix3d, Eigen::MatrixXd, Eigen::Vector3d, Eigen::VectorXd, ::testing::HasSubstr;

constexpr double kInfinity = INFINITY;

CableVector All(int num_cables, double tension) {
  return CableVector::Constant(num_cables, tension);
}

CableMatrix6 Structure(const CdprDescription& robot, const Vector3d& p,
                       const Vector3d& euler = Vector3d::Zero()) {
  return CalcCableKinematics(robot, p, RotationFromEuler(euler)).structure;
}

// Stationarity: u + W^T mu is zero where u is free, and pushes outwards where it is at a bound.
void ExpectKkt(const CableMatrix6& W, const Vector6d& b, const CableVector& u, const CableVector& lower,
               const CableVector& upper) {
  EXPECT_LT((W * u - b).norm(), 1e-9 * b.norm());
  std::vector<int> free;
  for (int i = 0; i < u.size(); ++i) {
    EXPECT_GE(u[i], lower[i]);
    EXPECT_LE(u[i], upper[i]);
    if (u[i] > lower[i] + 1e-8 && u[i] < upper[i] - 1e-8) free.push_back(i);
  }
  const MatrixXd columns = MatrixXd(W)(Eigen::all, free).transpose();
  const VectorXd mu = columns.completeOrthogonalDecomposition().solve(-VectorXd(u)(free));
  const VectorXd gradient = VectorXd(u) + MatrixXd(W).transpose() * mu;
  for (const int i : free) EXPECT_NEAR(gradient[i], 0, 1e-8);
  // With fewer free tensions than equations mu is not unique, and its sign says nothing.
  if (free.size() < 6) return;
  for (int i = 0; i < u.size(); ++i) {
    if (u[i] <= lower[i] + 1e-8) {
      EXPECT_GE(gradient[i], -1e-8);
    }
    if (u[i] >= upper[i] - 1e-8) {
      EXPECT_LE(gradient[i], 1e-8);
    }
  }
}

VectorXd SolveWithNlopt(const CableMatrix6& W, const Vector6d& b, const CableVector& lower,
                        const CableVector& upper) {
  struct Problem {
    const CableMatrix6& W;
    const Vector6d& b;
  } problem{W, b};
  const int n = static_cast<int>(W.cols());
  nlopt::opt optimizer(nlopt::LD_SLSQP, n);
  optimizer.set_lower_bounds(std::vector<double>(lower.begin(), lower.end()));
  optimizer.set_upper_bounds(std::vector<double>(upper.begin(), upper.end()));
  optimizer.set_min_objective(
      [](const std::vector<double>& x, std::vector<double>& gradient, void*) {
        double sum = 0;
        for (std::size_t i = 0; i < x.size(); ++i) {
          sum += x[i] * x[i] / 2;
          if (!gradient.empty()) gradient[i] = x[i];
        }
        return sum;
      },
      nullptr);
  optimizer.add_equality_mconstraint(
      [](unsigned, double* result, unsigned size, const double* x, double* gradient, void* data) {
        const auto* p = static_cast<const Problem*>(data);
        Eigen::Map<Vector6d> out(result);
        out = p->W * Eigen::Map<const VectorXd>(x, size) - p->b;
        if (!gradient) return;
        Eigen::Map<Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>>(gradient, 6, size) = p->W;
      },
      &problem, std::vector<double>(6, 1e-9));
  optimizer.set_xtol_rel(1e-12);
  optimizer.set_maxeval(500);
  const CableVector middle = (lower + upper) / 2;
  std::vector<double> x(middle.begin(), middle.end());
  double value = 0;
  try {
    optimizer.optimize(x, value);
  } catch (const nlopt::roundoff_limited&) {
  }
  return Eigen::Map<VectorXd>(x.data(), n);
}

TEST(TensionDistribution, FourCablesAtTheCentreShareTheWeight) {
  const CdprDescription robot = test::FourCableRobot();
  const CableMatrix6 W = Structure(robot, {0, 0, 2});
  const TensionDistribution found = DistributeTension(W, -GravityWrench(robot), All(4, 0), All(4, 800));
  ASSERT_TRUE(found.feasible) << found.reason;
  EXPECT_LT((found.tension.array() - 15 * 9.81 / (4 * W(2, 0))).abs().maxCoeff(), 1e-10);
  EXPECT_TRUE(found.reason.empty());
}

TEST(TensionDistribution, NoWrenchNeedsNoTension) {
  const CableMatrix6 W = Structure(test::FourCableRobot(), {0.5, 0, 2});
  const TensionDistribution found = DistributeTension(W, Vector6d::Zero(), All(4, 0), All(4, 800));
  EXPECT_TRUE(found.feasible) << found.reason;
  EXPECT_EQ(found.tension, CableVector::Zero(4));
}

TEST(TensionDistribution, WithoutActiveBoundsIsThePseudoinverse) {
  const CdprDescription robot = test::EightCableRobot();
  const CableMatrix6 W = Structure(robot, {0.5, -0.4, 2}, {0.02, 0.05, -0.03});
  const Vector6d b = -GravityWrench(robot);
  const TensionDistribution found = DistributeTension(W, b, All(8, -kInfinity), All(8, kInfinity));
  ASSERT_TRUE(found.feasible) << found.reason;
  const VectorXd expected = MatrixXd(W).completeOrthogonalDecomposition().solve(b);
  EXPECT_LT((found.tension - expected).norm(), 1e-10);
}

// At random poses and bounds, different for each cable, solutions meet the optimality conditions and agree
// with NLopt; where there is none, NLopt finds none either.
class TensionDistributionOfRobots : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Cables, TensionDistributionOfRobots, ::testing::Values(8, 12, 16),
                         ::testing::PrintToStringParamName());

TEST_P(TensionDistributionOfRobots, AgreeWithNloptAtRandomPoses) {
  const CdprDescription robot = test::RobotWithCables(GetParam());
  TensionDistributor distributor(GetParam());
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int feasible = 0, bounded = 0;
  for (int trial = 0; trial < 50; ++trial) {
    Vector3d p(2.5 * uniform(random), 3.5 * uniform(random), 2 + uniform(random));
    if (GetParam() > 8) p = {p.x() / 3, p.y() / 3, p.z()};  // nothing pulls down: the room is smaller
    const Vector3d euler(0.15 * uniform(random), 0.15 * uniform(random), 0.15 * uniform(random));
    const CableMatrix6 W = Structure(robot, p, euler);
    Vector6d b = -GravityWrench(robot);
    for (int i = 0; i < 6; ++i) b[i] += (i < 3 ? 30 : 2) * uniform(random);
    CableVector lower(GetParam()), upper(GetParam());
    for (int i = 0; i < GetParam(); ++i) {
      lower[i] = (10 + 5 * uniform(random)) * 8 / GetParam();
      upper[i] = 300 + 150 * uniform(random);
    }

    const TensionDistribution found = distributor.Solve(W, b, lower, upper);
    const VectorXd expected = SolveWithNlopt(W, b, lower, upper);
    const double miss = (W * expected - b).norm();
    if (found.feasible) {
      ++feasible;
      if ((found.tension - lower).minCoeff() < 1e-8) ++bounded;
      ExpectKkt(W, b, found.tension, lower, upper);
      if (miss < 1e-6) {
        EXPECT_LT((found.tension - expected).norm(), 1e-4) << "trial " << trial;
      }
    } else {
      EXPECT_GT(miss, 1e-3) << "trial " << trial << ": " << found.reason;
    }
  }
  EXPECT_GT(feasible, 15);
  EXPECT_LT(feasible, 50);
  EXPECT_GT(bounded, 5);
}

// Eight cables on a point mass, most of them at bounds: the tensions do not depend on which cable is the
// first.
TEST(TensionDistribution, DoesNotDependOnTheOrderOfTheCables) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> uniform(-1, 1);
  int feasible = 0;
  for (int trial = 0; trial < 50; ++trial) {
    CableMatrix6 W = CableMatrix6::Zero(6, 8);
    for (int i = 0; i < 8; ++i) {
      const double z = 0.5 + uniform(random), y = uniform(random), x = uniform(random);
      W.col(i).head<3>() = Vector3d(x, y, z).normalized();
    }
    Vector6d b = Vector6d::Zero();
    b.head<3>() << 50 * uniform(random), 50 * uniform(random), 150;
    const TensionDistribution found = DistributeTension(W, b, All(8, 20), All(8, 80));
    feasible += found.feasible;
    for (int first = 1; first < 8; ++first) {
      CableMatrix6 turned(6, 8);
      turned << W.rightCols(8 - first), W.leftCols(first);
      const TensionDistribution again = DistributeTension(turned, b, All(8, 20), All(8, 80));
      ASSERT_EQ(again.feasible, found.feasible) << trial;
      if (!found.feasible) continue;
      CableVector expected(8);
      expected << found.tension.tail(8 - first), found.tension.head(first);
      ASSERT_LT((again.tension - expected).norm(), 1e-9) << trial;
    }
  }
  EXPECT_GT(feasible, 15);
  EXPECT_LT(feasible, 50);
}

TEST(TensionDistribution, GivesTheReasonIfThereIsNone) {
  struct Case {
    CdprDescription robot;
    Vector3d p_WB, euler;
    double upper;
    const char* reason;
  };
  // Four cables out of balance, a cable that would push, and too small a bound.
  for (const Case& c : {Case{test::FourCableRobot(), {0.5, 0, 2}, {0, 0.2, 0}, 800, "static balance"},
                        Case{test::SixCableRobot(), {-3, 0, 2}, {0, 0, 0}, 800, " of 6 would need -"},
                        Case{test::EightCableRobot(), {0, 0, 2}, {0, 0, 0}, 20, "[0, 20] N"}}) {
    const TensionDistribution found =
        DistributeTension(Structure(c.robot, c.p_WB, c.euler), -GravityWrench(c.robot),
                          All(c.robot.num_cables(), 0), All(c.robot.num_cables(), c.upper));
    EXPECT_FALSE(found.feasible);
    EXPECT_THAT(found.reason, HasSubstr(c.reason));
    EXPECT_EQ(found.residual_force + found.residual_torque > 0.1, c.robot.num_cables() == 4);
  }
}

TEST(TensionDistribution, DoesNotAllocate) {
  for (const int n : {4, 8, 12}) {
    const CdprDescription robot = test::RobotWithCables(n);
    const CableMatrix6 W = Structure(robot, {0, 0, 2});
    const Vector6d b = -GravityWrench(robot);
    TensionDistributor distributor(n);
    const CableVector lower = All(n, n == 4 ? 0 : 15),  // which holds some of the eight and the twelve
        upper = All(n, 800);
    const AllocationGuard guard;
    const bool feasible = distributor.Solve(W, b, lower, upper).feasible;
    EXPECT_EQ(guard.count(), 0) << n;
    EXPECT_TRUE(feasible) << n;
  }
}

TEST(TensionDistribution, RefusesAnotherNumberOfCables) {
  const CdprDescription robot = test::SixCableRobot();
  const CableMatrix6 W = Structure(robot, {0, 0, 2});
  EXPECT_TRUE(Throws<ParameterError>(
      [&] { TensionDistributor(4).Solve(W, -GravityWrench(robot), All(4, 0), All(4, 800)); }, "6", "4"));
}

}  // namespace tenon::tension_distribution_test
