#include <tenon/controllers/cdpr/pose_feasibility.h>
#include <tenon/plants/model/platform_springs.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>

#include <Eigen/Geometry>

#include <random>
#include <set>

namespace tenon::pose_feasibility_test {

using Eigen::Matrix3d, Eigen::MatrixXd, Eigen::Vector2d, Eigen::Vector3d, Eigen::VectorXd;

class Draws {
 public:
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Vector3d Direction() {
    std::normal_distribution<double> normal;
    return Vector3d(normal(random_), normal(random_), normal(random_)).normalized();
  }

 private:
  std::mt19937_64 random_{11};
};

struct Case {
  const char* name;
  int cables;
  PlatformDemand demand;
  double angle;          ///< of a ball, per metre of its radius [rad/m]
  bool unequal = false;  ///< whether each cable has limits of its own
  bool springs = false;
};

class PoseFeasibilityTest : public ::testing::TestWithParam<Case> {};

// Balls of poses all over the frame, with radii down to 1 mm. If the verdict is kHolds, every pose of the
// ball is feasible by the quadratic program of tension_distribution.h; if it is kFails, none is. Small balls
// are undecided only at the boundary.
TEST_P(PoseFeasibilityTest, ProofsHoldAtEveryPoseOfTheBall) {
  const auto [name, num_cables, demand, angle, unequal, springs] = GetParam();
  CdprDescription robot = test::RobotWithCables(num_cables);
  for (int i = 0; unequal && i < num_cables; ++i) {
    robot.cables[i].tension_min = robot.cable.tension_min * (0.5 + 0.3 * (i % 3));
    robot.cables[i].tension_max = robot.cable.tension_max * (0.2 + 0.1 * (i % 4));
  }
  if (springs) robot = test::WithSprings(robot);
  const WrenchBox required = RequiredWrenches(robot, demand);
  PoseFeasibility feasibility(robot, required);
  TensionDistributor distributor(num_cables);
  const auto feasible = [&](const PoseBall& at) {
    const CableMatrix6 W = CalcCableKinematics(robot, at.p_WB, at.R_WB).structure;
    for (int bits = 0; bits < 64; ++bits) {
      Vector6d wrench = required.centre - CalcSpringWrench(robot.springs, at.p_WB, at.R_WB);
      for (int k = 0; k < 6; ++k) wrench[k] += ((bits >> k & 1) != 0 ? 1 : -1) * required.half_width[k];
      if (!distributor.Solve(W, wrench, robot.tension_min(), robot.tension_max(), 1e-7).feasible)
        return false;
      if (required.half_width.isZero()) return true;
    }
    return true;
  };
  Draws draw;
  int holds = 0, fails = 0, undecided_small = 0, small = 0;
  for (int k = 0; k < 500; ++k) {
    PoseBall ball;
    ball.p_WB << draw.Uniform(-3.5, 3.5), draw.Uniform(-4.5, 4.5), draw.Uniform(0, 3.8);
    ball.R_WB = Eigen::AngleAxisd(draw.Uniform(0, 0.3), draw.Direction()).toRotationMatrix();
    ball.distance = std::pow(10, draw.Uniform(-3, -0.3));
    ball.angle = angle * ball.distance;
    const PoseVerdict verdict = feasibility.Over(ball);
    holds += verdict == PoseVerdict::kHolds ? 1 : 0;
    fails += verdict == PoseVerdict::kFails ? 1 : 0;
    if (ball.distance < 0.003) {
      ++small;
      undecided_small += verdict == PoseVerdict::kUndecided ? 1 : 0;
    }
    if (verdict == PoseVerdict::kUndecided) continue;
    for (int i = 0; i < (required.half_width.isZero() ? 20 : 3); ++i) {
      // Mostly on the surface of the ball, where it is most likely to be wrong.
      const double share = i % 4 == 0 ? draw.Uniform(0, 1) : 1;
      PoseBall at = ball;
      at.p_WB += share * ball.distance * draw.Direction();
      at.R_WB = Eigen::AngleAxisd(share * ball.angle, draw.Direction()).toRotationMatrix() * ball.R_WB;
      EXPECT_EQ(feasible(at), verdict == PoseVerdict::kHolds)
          << "ball " << k << " of radius " << ball.distance << " at " << ball.p_WB.transpose();
    }
  }
  EXPECT_GT(holds, 20);
  EXPECT_GT(fails, 30);
  EXPECT_LT(undecided_small, 0.1 * small);
}

INSTANTIATE_TEST_SUITE_P(
    Robots, PoseFeasibilityTest,
    ::testing::Values(Case{"six", 6, {}, 0}, Case{"eight", 8, {}, 0.5},
                      Case{"eight_accelerating", 8, {.load = 3, .acceleration = 1, .torque = 1}, 0.5},
                      Case{"eight_with_limits_of_their_own", 8, {.load = 10}, 0.5, true},
                      Case{"eight_with_springs", 8, {.load = 10}, 0.5, true, true},
                      Case{"twelve", 12, {.load = 10}, 0.5}),
    [](const auto& info) { return info.param.name; });

// Verdicts on interference against the clearance at poses of the ball.
TEST(PoseFeasibilityClearTest, ProofsHoldAtEveryPoseOfTheBall) {
  const CdprDescription robot = test::EightCableRobot();
  PoseFeasibility feasibility(robot, RequiredWrenches(robot, {}));
  const CableInterference interference(robot);
  constexpr double kDiameter = 0.05;
  Draws draw;
  int holds = 0, fails = 0;
  for (int k = 0; k < 800; ++k) {
    PoseBall ball;
    ball.p_WB << draw.Uniform(-3.5, 3.5), draw.Uniform(-4.5, 4.5), draw.Uniform(0, 3.8);
    ball.R_WB = Eigen::AngleAxisd(draw.Uniform(0, 1.2), draw.Direction()).toRotationMatrix();
    ball.distance = std::pow(10, draw.Uniform(-3, -1));
    ball.angle = ball.distance;
    const PoseVerdict verdict = feasibility.IsClearOver(ball, kDiameter);
    if (verdict == PoseVerdict::kUndecided) continue;
    ++(verdict == PoseVerdict::kHolds ? holds : fails);
    for (int i = 0; i < 10; ++i) {
      const Vector3d p = ball.p_WB + ball.distance * draw.Direction();
      const Matrix3d R = Eigen::AngleAxisd(ball.angle, draw.Direction()).toRotationMatrix() * ball.R_WB;
      const CableClearance at = interference.At(CalcCableKinematics(robot, p, R), R);
      EXPECT_EQ(at.cables >= kDiameter && at.platform >= 0, verdict == PoseVerdict::kHolds) << k;
    }
  }
  EXPECT_GT(holds, 40);
  EXPECT_GT(fails, 40);
}

TEST(PoseFeasibilityTest, DemandIsWeightLoadAccelerationAndForces) {
  const CdprDescription robot = test::EightCableRobot();
  const WrenchBox box = RequiredWrenches(robot, {.load = 5, .acceleration = 2, .force = 7, .torque = 3});
  EXPECT_LT((box.centre - 20 * 9.81 * Vector6d::Unit(2)).norm(), 1e-12);
  EXPECT_LT((box.half_width.head(3) - Vector3d::Constant(47)).norm(), 1e-12);
  EXPECT_LT((box.half_width.tail(3) - Vector3d::Constant(3)).norm(), 1e-12);
  EXPECT_TRUE(Throws<ParameterError>([&] { RequiredWrenches(robot, {.load = -1}); }, "load"));
}

TEST(PoseFeasibilityTest, TreatsPulleysAsPoints) {
  CdprDescription robot = test::RobotWithCables(8);
  const WrenchBox required = RequiredWrenches(robot, {});
  const PoseBall ball{.p_WB = {0.3, -0.4, 1.7}, .distance = 0.05, .angle = 0.05};
  PoseFeasibility points(robot, required);
  robot.winch.pulley_radius = 0.2;
  PoseFeasibility pulleys(robot, required);
  EXPECT_EQ(pulleys.Over(ball), points.Over(ball));
  EXPECT_EQ(pulleys.margins().tension, points.margins().tension);
}

// A cable without length has no margin, and a ball that contains such a place is undecided.
TEST(PoseFeasibilityTest, AtAnAnchor) {
  const CdprDescription robot = test::EightCableRobot();
  PoseFeasibility feasibility(robot, RequiredWrenches(robot, {}));
  const Vector3d at = robot.cables[0].anchor_W - robot.cables[0].attachment_B;
  EXPECT_FALSE(feasibility.At(at, Matrix3d::Identity()).feasible());
  EXPECT_EQ(feasibility.Over({.p_WB = at, .distance = 0.1}), PoseVerdict::kUndecided);
  EXPECT_EQ(feasibility.Over({.p_WB = at + Vector3d(0.05, 0, 0), .distance = 0.1}), PoseVerdict::kUndecided);
  EXPECT_EQ(feasibility.IsClearOver({.p_WB = at, .distance = 0.1}, 0), PoseVerdict::kUndecided);
}

TEST(PoseFeasibilityTest, AllocatesNothingInTheLoop) {
  const CdprDescription robot = test::EightCableRobot();
  PoseFeasibility feasibility(robot, RequiredWrenches(robot, {}));
  feasibility.At({0, 0, 1.5}, Matrix3d::Identity());
  const AllocationGuard guard;
  EXPECT_EQ(feasibility.Over({.p_WB = {0, 0, 2}, .distance = 0.01}), PoseVerdict::kHolds);
  EXPECT_EQ(feasibility.Over({.p_WB = {3.4, 4.4, 2}, .distance = 0.01}), PoseVerdict::kFails);
  EXPECT_EQ(guard.count(), 0);
}

TEST(PoseFeasibilityTest, RefusesRobotsThatHaveNoSuchWorkspace) {
  CdprDescription robot = test::FourCableRobot();
  EXPECT_TRUE(Throws<ParameterError>([&] { PoseFeasibility(robot, RequiredWrenches(robot, {})); }, "'four'"));
  const CdprDescription planar = test::PlanarRobot(2);
  EXPECT_TRUE(Throws<ParameterError>([&] { PoseFeasibility(planar, RequiredWrenches(planar, {})); },
                                     "'planar'", "takes 3"));
  for (CableDescription& cable : robot.cables) cable.attachment_B.setZero();
  EXPECT_NO_THROW(PoseFeasibility(robot, RequiredWrenches(robot, {})));
  EXPECT_TRUE(Throws<ParameterError>([&] { PoseFeasibility(robot, RequiredWrenches(robot, {.torque = 1})); },
                                     "torque"));
}

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

}  // namespace tenon::pose_feasibility_test
