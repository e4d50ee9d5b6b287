#include <tenon/controllers/cdpr/tension_distribution.h>
#include <tenon/controllers/cdpr/wrench_feasibility.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <random>
#include <set>
#include <vector>

namespace tenon::wrench_feasibility_test {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

std::mt19937_64& Random() {
  static std::mt19937_64 random(5);
  return random;
}
double Uniform(double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(Random());
}

CableVector All(int num_cables, double tension) {
  return CableVector::Constant(num_cables, tension);
}

WrenchBox Point(const VectorXd& wrench) {
  return {wrench, VectorXd::Zero(wrench.size())};
}

/// Unit vectors from a point mass in the vertical plane to its anchors.
MatrixXd Directions(const std::vector<Vector2d>& anchors, const Vector2d& p) {
  MatrixXd W(2, anchors.size());
  for (std::size_t i = 0; i < anchors.size(); ++i) W.col(static_cast<int>(i)) = (anchors[i] - p).normalized();
  return W;
}

double Cross(const Vector2d& a, const Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// The wrenches of three cables in a plane are a hexagon, the convex hull of the eight corners of the
// tensions.
TEST(WrenchFeasibilityTest, CapacityIsTheDistanceFromTheHexagon) {
  const Vector3d low(5, 0, 12), high(60, 40, 75);
  WrenchFeasibility feasibility(2, low, high);
  for (int k = 0; k < 50; ++k) {
    const MatrixXd W = Directions({{-3, 4}, {3, 4.5}, {0.5, 0}}, {Uniform(-3, 3), Uniform(0.5, 4)});
    std::vector<Vector2d> corners;
    for (int bits = 0; bits < 8; ++bits) {
      Vector3d u;
      for (int i = 0; i < 3; ++i) u[i] = ((bits >> i & 1) != 0 ? high : low)[i];
      corners.emplace_back(W * u);
    }
    const Vector2d wrench(Uniform(-60, 60), Uniform(-40, 100));
    // Lines through two corners with all others on one side are edges; the least distance inwards counts.
    double least = INFINITY;
    for (const Vector2d& a : corners) {
      for (const Vector2d& b : corners) {
        if ((b - a).norm() < 1e-9) continue;
        const Vector2d along = (b - a).normalized();
        if (std::ranges::all_of(corners, [&](const Vector2d& c) { return Cross(along, c - a) > -1e-9; }))
          least = std::min(least, Cross(along, wrench - a));
      }
    }
    feasibility.SetStructure(W);
    EXPECT_EQ(feasibility.num_facets(), 3);
    EXPECT_NEAR(feasibility.Margins(Point(wrench)).capacity, least, 1e-7);
    // With a share of the range, the hexagon is that of the corners up to it.
    WrenchFeasibility part(2, low, low + 0.3 * (high - low));
    part.SetStructure(W);
    EXPECT_NEAR(feasibility.Margins(Point(wrench), 0.3).capacity, part.Margins(Point(wrench)).capacity, 1e-9);
    EXPECT_NEAR(feasibility.Margins(Point(wrench), 0.3).tension, part.Margins(Point(wrench)).tension, 1e-9);
  }
}

/// Whether the quadratic program of tension_distribution.h finds tensions for all corners of the box.
bool Produces(const CableMatrix6& W, const WrenchBox& box, const CableVector& low, const CableVector& high) {
  TensionDistributor distributor(static_cast<int>(W.cols()));
  for (int bits = 0; bits < 64; ++bits) {
    Vector6d wrench = box.centre;
    bool seen = false;
    for (int k = 0; k < 6; ++k) {
      const bool up = (bits >> k & 1) != 0;
      wrench[k] += (up ? 1 : -1) * box.half_width[k];
      seen |= up && box.half_width[k] == 0;
    }
    if (!seen && !distributor.Solve(W, wrench, low, high).feasible) return false;
  }
  return true;
}

class MarginTest : public ::testing::TestWithParam<int> {};

// The bounds of all cables are different. With bounds tightened by less than the margin, a quadratic program
// finds tensions for every corner of the required wrenches; tightened by more, it does not. A negative margin
// widens the bounds.
TEST_P(MarginTest, IsWhereTheQuadraticProgramBecomesInfeasible) {
  const CdprDescription robot = test::RobotWithCables(GetParam());
  const int n = robot.num_cables();
  CableVector low = All(n, 10), high = All(n, 400);
  for (int i = 0; i < n; ++i) {
    low[i] -= 0.5 * i;
    high[i] -= 15 * (i % 4);
  }
  WrenchFeasibility feasibility(6, low, high);
  int feasible = 0, checked = 0;
  for (int k = 0; k < 60; ++k) {
    const Vector3d p(Uniform(-2.5, 2.5), Uniform(-3, 3), Uniform(0.5, 3)),
        euler(Uniform(-0.3, 0.3), Uniform(-0.3, 0.3), Uniform(-0.3, 0.3));
    const CableMatrix6 W = CalcCableKinematics(robot, p, RotationFromEuler(euler)).structure;
    WrenchBox box = Point(-GravityWrench(robot));
    if (k % 2 == 1) box.half_width << 20, 10, 30, 0, 2, 0;
    feasibility.SetStructure(W);
    const double margin = feasibility.Margins(box).tension;
    if (std::abs(margin) > 150) continue;  // bounds would meet, or be far from what cables do
    const CableVector inner = All(n, margin - 4e-4), outer = All(n, margin + 4e-4);
    EXPECT_TRUE(Produces(W, box, low + inner, high - inner)) << k << ": " << margin;
    EXPECT_FALSE(Produces(W, box, low + outer, high - outer)) << k << ": " << margin;
    feasible += margin > 0 ? 1 : 0;
    ++checked;
  }
  EXPECT_GT(checked, 20);
  EXPECT_GT(checked, feasible);
  EXPECT_GT(feasible, 0);
}

INSTANTIATE_TEST_SUITE_P(Cables, MarginTest, ::testing::Values(6, 8, 12),
                         ::testing::PrintToStringParamName());

// All wrenches within the capacity margin are feasible; along the normal of the nearest facet, none beyond
// is.
TEST(WrenchFeasibilityTest, CapacityIsTheRadiusOfTheLargestBall) {
  const CdprDescription robot = test::EightCableRobot();
  const CableMatrix6 W = CalcCableKinematics(robot, {0.3, -0.4, 1.7}, Eigen::Matrix3d::Identity()).structure;
  CableVector low = All(8, 10), high = All(8, 800);
  low[3] = 30;
  high[5] = 120;
  WrenchFeasibility feasibility(6, low, high);
  feasibility.SetStructure(W);
  const Vector6d weight = -GravityWrench(robot);
  const double capacity = feasibility.Margins(Point(weight)).capacity;
  ASSERT_GT(capacity, 0);
  int beyond = 0;
  for (int facet = 0; facet < feasibility.num_facets(); ++facet) {
    const Vector6d direction = feasibility.normal(facet).normalized();
    for (const double sign : {1, -1}) {
      EXPECT_TRUE(DistributeTension(W, weight + 0.999 * sign * capacity * direction, low, high).feasible);
      beyond +=
          DistributeTension(W, weight + 1.001 * sign * capacity * direction, low, high).feasible ? 0 : 1;
    }
  }
  EXPECT_GE(beyond, 1);
}

// Every facet has its own choice of cables and is normal to their columns, also if some columns are
// dependent.
TEST(WrenchFeasibilityTest, NormalsAreNormalToTheirCables) {
  for (const int n : {6, 8, 12}) {
    const CdprDescription robot = test::RobotWithCables(n);
    for (const int same : {-1, 0, 3}) {
      CableMatrix6 W =
          CalcCableKinematics(robot, {0.3, -0.4, 1.7}, RotationFromEuler({0.1, 0, 0.2})).structure;
      if (same >= 0) W.col(same + 2) = 2 * W.col(same);
      WrenchFeasibility feasibility(6, All(n, 0), All(n, 800));
      feasibility.SetStructure(W);
      std::set<std::vector<int>> choices;
      int none = 0;
      for (int facet = 0; facet < feasibility.num_facets(); ++facet) {
        const Eigen::VectorXi cables = feasibility.cables(facet);
        const std::vector<int> choice(cables.begin(), cables.end());
        EXPECT_TRUE(std::ranges::is_sorted(choice));
        choices.insert(choice);
        const Vector6d normal = feasibility.normal(facet);
        none += normal.norm() < 1e-12 ? 1 : 0;
        for (const int cable : choice) EXPECT_LT(std::abs(normal.dot(W.col(cable))), 1e-13) << facet;
      }
      const int facets = n == 6 ? 6 : n == 8 ? 56 : 792;
      EXPECT_EQ(feasibility.num_facets(), facets);
      EXPECT_EQ(static_cast<int>(choices.size()), facets);
      // Normals vanish for choices of both dependent columns and three others.
      EXPECT_EQ(none, same < 0 ? 0 : (n - 2) * (n - 3) * (n - 4) / 6);
    }
  }
}

// Parallel cables, as of a platform that only translates, have fewer facets.
TEST(WrenchFeasibilityTest, ParallelCables) {
  MatrixXd W(2, 4);
  W << 1, 1, -1, 0, 0, 0, 0, 1;
  WrenchFeasibility feasibility(2, All(4, 0), All(4, 10));
  feasibility.SetStructure(W);
  const WrenchMargins margins = feasibility.Margins(Point(Vector2d(0, 4)));
  EXPECT_NEAR(margins.tension, 10.0 / 3, 1e-12);  // the first two together against the third: 2 m = 10 - m
  EXPECT_NEAR(margins.capacity, 4, 1e-12);        // down, the last one goes slack
}

TEST(WrenchFeasibilityTest, NothingIsProducedOutOfThePlaneOfAllCables) {
  MatrixXd W = MatrixXd::Zero(3, 4);
  W.topRows(2) << 1, -1, 0, 0, 0, 0, 1, -1;
  WrenchFeasibility feasibility(3, All(4, 0), All(4, 10));
  feasibility.SetStructure(W);
  EXPECT_FALSE(feasibility.Margins(Point(Vector3d(0, 0, 1))).feasible());
  EXPECT_NEAR(feasibility.Margins(Point(Vector3d(0, 0, 1))).capacity, -1, 1e-12);
  feasibility.SetStructure(MatrixXd::Ones(3, 4));
  EXPECT_FALSE(feasibility.Margins(Point(Vector3d(1, 1, 1))).feasible());
}

TEST(WrenchFeasibilityTest, RefusesTooFewCablesAndOtherSizes) {
  EXPECT_TRUE(Throws<ParameterError>([] { WrenchFeasibility(6, All(5, 0), All(5, 10)); }, "5 cables"));
  EXPECT_TRUE(Throws<ParameterError>([] { WrenchFeasibility(1, All(5, 0), All(5, 10)); }, "two rows"));
  EXPECT_TRUE(Throws<ParameterError>([] { WrenchFeasibility(6, All(8, 10), All(8, 10)); }, "bounds"));
  EXPECT_TRUE(Throws<ParameterError>([] { WrenchFeasibility(6, All(8, 0), All(8, INFINITY)); }, "bounds"));
  WrenchFeasibility feasibility(6, All(8, 0), All(8, 10));
  EXPECT_TRUE(Throws<ParameterError>([&] { feasibility.SetStructure(MatrixXd::Zero(6, 7)); }, "6 x 7"));
}

}  // namespace tenon::wrench_feasibility_test
