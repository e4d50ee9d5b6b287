#include <tenon/controllers/cdpr/equilibrium_path.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::equilibrium_path_test {

using Eigen::Vector3d;

constexpr double kInfinity = INFINITY;
constexpr double kStep = 1e-4;

Path TestCircle() {
  return Path::Circle({0.2, -0.1, 2}, 1, 8, 2);
}

Path TestSpline() {
  return Path::Spline({{0, 0, 2}, {0.5, 0.2, 2.1}, {0.7, 1, 1.9}, {-0.5, 0.6, 1.8}}, {1, 2.5, 4, 7});
}

// Velocity and acceleration against central differences of the position and the velocity.
void ExpectConsistent(const Path& path, double from, double to) {
  for (double t = from; t < to; t += 0.0371) {
    const PathPoint before = path.At(t - kStep), now = path.At(t), after = path.At(t + kStep);
    EXPECT_LT((now.velocity - (after.position - before.position) / (2 * kStep)).norm(), 1e-6) << "t = " << t;
    EXPECT_LT((now.acceleration - (after.velocity - before.velocity) / (2 * kStep)).norm(), 1e-3)
        << "t = " << t;
    EXPECT_LT((path.PositionOf(path.ParameterAt(t).value) - now.position).norm(), 1e-14);
  }
}

void ExpectAtRest(const Path& path, double time, const Vector3d& position) {
  const PathPoint point = path.At(time);
  EXPECT_LT((point.position - position).norm(), 1e-13);
  EXPECT_LT(point.velocity.norm(), 1e-12);
  EXPECT_LT(point.acceleration.norm(), 1e-11);
}

TEST(Path, CircleStartsAtRestAndKeepsItsPeriod) {
  const Path path = TestCircle();
  ExpectConsistent(path, -0.5, 12);
  ExpectAtRest(path, -1, {1.2, -0.1, 2});
  ExpectAtRest(path, 0, {1.2, -0.1, 2});
  EXPECT_LT((path.At(3).position - path.At(11).position).norm(), 1e-14);
  EXPECT_NEAR(path.At(5).velocity.norm(), 2 * std::numbers::pi / 8, 1e-14);
  EXPECT_NEAR(path.At(5).acceleration.norm(), std::pow(2 * std::numbers::pi / 8, 2), 1e-14);
  EXPECT_EQ(path.end_time(), kInfinity);
}

TEST(Path, TimeOfInvertsTheParameterOfACircle) {
  const Path path = TestCircle();
  for (const double t : {0.3, 1.7, 2.0, 5.5, 20.0})
    EXPECT_NEAR(path.TimeOf(path.ParameterAt(t).value), t, 1e-9);
}

TEST(Path, LineIsTheQuintic) {
  const Vector3d from(0, 0, 2), to(1, -0.5, 1.5);
  const Path path = Path::Line(from, to, 4);
  ExpectConsistent(path, -0.5, 5);
  ExpectAtRest(path, -1, from);
  ExpectAtRest(path, 4, to);
  ExpectAtRest(path, 9, to);
  for (const double x : {0.1, 0.5, 0.8}) {
    const double share = x * x * x * (10 - 15 * x + 6 * x * x);
    EXPECT_LT((path.At(4 * x).position - (from + share * (to - from))).norm(), 1e-14);
  }
}

TEST(Path, SplinePassesItsPointsWithFourContinuousDerivatives) {
  const Path path = TestSpline();
  ExpectConsistent(path, 0.5, 7.5);
  ExpectAtRest(path, 1, {0, 0, 2});
  ExpectAtRest(path, 7, {-0.5, 0.6, 1.8});
  EXPECT_LT((path.At(2.5).position - Vector3d(0.5, 0.2, 2.1)).norm(), 1e-14);
  EXPECT_LT((path.At(4).position - Vector3d(0.7, 1, 1.9)).norm(), 1e-14);
  // The acceleration of a quintic is a cubic: its jerk and snap follow from four values on either side.
  for (const double knot : {2.5, 4.0}) {
    const double h = 0.1;
    const auto a = [&](double steps) { return path.At(knot + steps * h).acceleration; };
    for (const int order : {1, 2}) {
      const auto derivative = [&](double side) -> Vector3d {
        if (order == 1)
          return side * (-11 * a(0) + 18 * a(side) - 9 * a(2 * side) + 2 * a(3 * side)) / (6 * h);
        return (2 * a(0) - 5 * a(side) + 4 * a(2 * side) - a(3 * side)) / (h * h);
      };
      EXPECT_LT((derivative(1) - derivative(-1)).norm(), 1e-10) << "derivative " << order << " at " << knot;
    }
  }
}

TEST(Path, WaypointsRestBetweenEqualPoints) {
  const Vector3d a(0, 0, 2), b(0.5, 0.2, 2.1), c(0.7, 1, 1.9), d(-0.5, 0.6, 1.8);
  const Path path = Path::Waypoints({a, a, b, c, c, d, d}, {1, 1.5, 3, 4.5, 6, 8, 9});
  ExpectConsistent(path, 0.5, 9.5);
  for (const double t : {0.0, 1.0, 1.2, 1.5}) ExpectAtRest(path, t, a);
  for (const double t : {4.5, 5.0, 6.0}) ExpectAtRest(path, t, c);
  for (const double t : {8.0, 8.5, 9.0, 12.0}) ExpectAtRest(path, t, d);
  // In between it is a spline from rest to rest, which does not stop at b.
  const Path spline = Path::Spline({a, b, c}, {1.5, 3, 4.5});
  for (double t = 1.5; t < 4.5; t += 0.1) {
    EXPECT_EQ(path.At(t).position, spline.At(t).position) << t;
    EXPECT_EQ(path.At(t).acceleration, spline.At(t).acceleration) << t;
  }
  EXPECT_GT(path.At(3).velocity.norm(), 0.3);
  EXPECT_EQ(path.start_time(), 1);
  EXPECT_EQ(path.end_time(), 9);
}

// A sine through as many points as a file may have, interpolated to the order of the spline.
TEST(Path, WaypointsMayBeThousands) {
  std::vector<Vector3d> points;
  std::vector<double> times;
  for (int i = 0; i <= 3000; ++i) {
    times.push_back(0.05 * i);
    points.emplace_back(std::sin(times.back()), 0, 2);
  }
  const Path path = Path::Waypoints(points, times);
  for (double t = 10; t < 100; t += 0.777) {
    EXPECT_NEAR(path.At(t).position[0], std::sin(t), 1e-9);
    EXPECT_NEAR(path.At(t).acceleration[0], -std::sin(t), 1e-5);
  }
}

TEST(Path, HoldStays) {
  const Path path = Path::Hold({0.1, 0.2, 2});
  ExpectAtRest(path, -1, {0.1, 0.2, 2});
  ExpectAtRest(path, 100, {0.1, 0.2, 2});
}

TEST(Path, RefusesNonsense) {
  const Vector3d p(0, 0, 2), bad(0, INFINITY, 2);
  struct Case {
    std::function<void()> call;
    const char *where, *what;
  };
  const Case cases[] = {{[=] { Path::Circle(bad, 1, 8, 2); }, "Path::Circle", "centre"},
                        {[=] { Path::Circle(p, 0, 8, 2); }, "Path::Circle", "radius"},
                        {[=] { Path::Circle(p, 1, -8, 2); }, "Path::Circle", "period"},
                        {[=] { Path::Circle(p, 1, 8, 0); }, "Path::Circle", "ramp"},
                        {[=] { Path::Line(p, bad, 1); }, "Path::Line", "end"},
                        {[=] { Path::Line(p, p, 0); }, "Path::Line", "duration"},
                        {[=] { Path::Spline({p}, {0}); }, "Path::Spline", "1 point"},
                        {[=] {
                           Path::Spline({p, p}, {0, 1, 2});
                         },
                         "2 points", "3 times"},
                        {[=] {
                           Path::Spline({p, bad}, {0, 1});
                         },
                         "Path::Spline", "point 2"},
                        {[=] {
                           Path::Spline({p, p, p}, {0, 2, 1});
                         },
                         "Path::Spline", "time 3"},
                        {[=] { Path::Waypoints({p}, {0}); }, "Path::Spline", "1 point"},
                        {[=] {
                           Path::Waypoints({p, p, p}, {0, 2, 1});
                         },
                         "Path::Spline", "time"},
                        {[=] { Path::Hold(bad); }, "Path::Hold", "position"}};
  for (const auto& [call, where, what] : cases) EXPECT_TRUE(Throws<ParameterError>(call, where, what));
}

// Expects balance also between the nodes, and rates that are the derivatives of their values.
void ExpectGoodReference(const EquilibriumPath& equilibria, double from, double to) {
  const CdprDescription& robot = equilibria.robot();
  for (double t = from; t < to; t += 0.0731) {
    SCOPED_TRACE(t);
    const CdprReference before = equilibria.At(t - kStep), now = equilibria.At(t),
                        after = equilibria.At(t + kStep);
    const PathPoint point = equilibria.path().At(t);
    EXPECT_EQ(now.position, point.position);
    EXPECT_EQ(now.velocity, point.velocity);
    EXPECT_EQ(now.acceleration, point.acceleration);
    const CableKinematics cables = CalcCableKinematics(robot, now.position, RotationFromEuler(now.euler));
    EXPECT_LT((cables.structure * now.tension + GravityWrench(robot)).norm(), 1e-5);
    EXPECT_EQ(now.length, cables.length);
    EXPECT_LT((now.euler_rate - (after.euler - before.euler) / (2 * kStep)).norm(), 1e-6);
    EXPECT_LT((now.length_rate - (after.length - before.length) / (2 * kStep)).norm(), 1e-6);
    // Twice differentiable: the rate has no step.
    EXPECT_LT((after.euler_rate - before.euler_rate).norm(), 1e-3);
  }
}

TEST(EquilibriumPath, CircleIsInBalanceForManyTurns) {
  const EquilibriumPath equilibria(test::FourCableRobot(), TestCircle());
  ExpectGoodReference(equilibria, -0.3, 10);
  ExpectGoodReference(equilibria, 7.9, 9.2);
  const CdprReference first = equilibria.At(3), later = equilibria.At(3 + 8 * 1000);
  EXPECT_LT((first.euler - later.euler).norm(), 1e-11);
  EXPECT_LT((first.tension - later.tension).norm(), 1e-8);
}

TEST(EquilibriumPath, LineAndSplineAreInBalanceAndStartAtRest) {
  const CdprDescription robot = test::FourCableRobot();
  ExpectGoodReference(EquilibriumPath(robot, Path::Line({0, 0, 2}, {1.5, 1, 1.5}, 3)), -0.2, 3.2);
  const EquilibriumPath spline(robot, TestSpline());
  ExpectGoodReference(spline, 0.8, 7.2);
  for (const double t : {-1.0, 1.0, 7.0, 8.0}) {
    EXPECT_LT(spline.At(t).euler_rate.norm(), 1e-12);
    EXPECT_LT(spline.At(t).length_rate.norm(), 1e-12);
  }
}

TEST(EquilibriumPath, IsTheSolutionOfTheInverseGeometricoStaticProblem) {
  const CdprDescription robot = test::FourCableRobot();
  const EquilibriumPath equilibria(robot, Path::Circle({0, 0, 2}, 2, 20, 3));
  for (const double t : {0.0, 2.22, 7.77, 15.3}) {
    const CdprReference reference = equilibria.At(t);
    const StaticEquilibrium direct = SolveInverseGeometricoStatic(robot, reference.position);
    EXPECT_LT((reference.euler - direct.euler).norm(), 1e-8);
    EXPECT_LT((reference.tension - direct.tension).norm(), 1e-5);
  }
}

TEST(EquilibriumPath, HoldIsOneEquilibrium) {
  const CdprDescription robot = test::FourCableRobot();
  const EquilibriumPath equilibria(robot, Path::Hold({0.5, 0, 2}));
  const StaticEquilibrium expected = SolveInverseGeometricoStatic(robot, {0.5, 0, 2});
  const CdprReference reference = equilibria.At(12);
  EXPECT_EQ(equilibria.num_nodes(), 1);
  EXPECT_EQ(reference.euler, expected.euler);
  EXPECT_EQ(reference.tension, expected.tension);
  EXPECT_EQ(reference.length, expected.length);
  EXPECT_EQ(reference.length_rate.norm(), 0);
}

TEST(EquilibriumPath, PrescribedAttitudeIsKept) {
  const StaticsOptions options{.attitude = Vector3d(0.02, 0, 0.1)};
  const EquilibriumPath equilibria(test::EightCableRobot(), Path::Circle({0, 0, 2}, 0.5, 6, 1), options);
  ExpectGoodReference(equilibria, 0, 3);
  EXPECT_LT((equilibria.At(2.7).euler - *options.attitude).norm(), 1e-14);
}

// Attitude and position pass their points together.
TEST(EquilibriumPath, TurnsOnItsWay) {
  const std::vector<Vector3d> points{{0, 0, 1.6}, {0.4, 0.3, 1.8}, {0, 0.6, 1.5}},
      attitudes{{0, 0, 0}, {0.2, 0, 0}, {0, 0.2, -0.1}};
  const std::vector<double> times{0, 2, 3};
  const Path attitude = Path::Spline(attitudes, times);
  for (const char* name : {"cdpr_8", "cdpr_12"}) {
    const CdprDescription robot = LoadCdpr(FindResource("robots", name));
    const EquilibriumPath equilibria(robot, Path::Spline(points, times), {.tension_aim = 100}, attitude);
    ExpectGoodReference(equilibria, 0, 3);
    for (const double t : {0.0, 0.7, 2.0, 2.6, 3.5}) {
      EXPECT_LT((equilibria.At(t).euler - attitude.At(t).position).norm(), 1e-6) << t;
      EXPECT_LT((equilibria.At(t).euler_rate - attitude.At(t).velocity).norm(), 1e-4) << t;
    }
    const Path circle = Path::Circle({0, 0, 2}, 0.1, 6, 1);
    EXPECT_TRUE(Throws<ParameterError>([&] { EquilibriumPath(robot, circle, {}, attitude); }, "circle"));
  }
}

// The tensions nearest to an aim are unique and change continuously with the pose: between close points of a
// path by little more than on average, also where a tension reaches or leaves a bound.
TEST(EquilibriumPath, TensionsNearestToAnAimChangeContinuously) {
  struct Bounds {
    const char* robot;
    double lower, upper;
  };
  for (const auto& [name, lower, upper] : {Bounds{"cdpr_8", 50, 200}, Bounds{"cdpr_12", 60, 140}}) {
    CdprDescription robot = LoadCdpr(FindResource("robots", name));
    robot.cable.tension_min = lower;
    robot.cable.tension_max = upper;
    const StaticsOptions options{.attitude = Vector3d(0, 0, 0), .tension_aim = 100};
    double travelled = 0, largest = 0;
    int at_bound = 0;
    CableVector last;
    constexpr int kSteps = 1000;
    for (int i = 0; i <= kSteps; ++i) {
      const double s = 1.0 * i / kSteps;
      const CableVector tension =
          SolveInverseGeometricoStatic(robot, {0.5 * s, 0.4 * s, 1.6 + 0.4 * s}, options).tension;
      if (i > 0) {
        travelled += (tension - last).norm();
        largest = std::max(largest, (tension - last).norm());
      }
      last = tension;
      if (tension.minCoeff() == lower || tension.maxCoeff() == upper) ++at_bound;
    }
    EXPECT_GT(at_bound, 50) << name << ": the path would prove little";
    EXPECT_LT(at_bound, 950) << name << ": the path would prove little";
    EXPECT_LT(largest, 10 * travelled / kSteps) << name;
  }
}

TEST(EquilibriumPath, KeepsTensionsWithinTheBoundsWhereACableReachesOne) {
  CdprDescription robot = test::FourCableRobot();
  robot.cable.tension_min = 15;
  const EquilibriumPath equilibria(robot, Path::Line({2, 0.8, 2}, {3, 0.8, 2}, 4));
  for (double t = 0; t < 4; t += 0.01) EXPECT_GE(equilibria.At(t).tension.minCoeff(), 15);
  EXPECT_EQ(equilibria.At(4).tension.minCoeff(), 15);
}

TEST(EquilibriumPath, APathOutOfTheWorkspaceIsRefusedWithTimeAndPlace) {
  const CdprDescription robot = test::FourCableRobot();
  const auto refuses = [&](const Path& path, const char* place) {
    return Throws<ParameterError>([&] { EquilibriumPath(robot, path); }, "t = ", "'four'", place);
  };
  EXPECT_TRUE(refuses(Path::Line({0, 0, 2}, {0, 0, 5}, 10), "(0, 0, 3.657) m"));
  EXPECT_TRUE(refuses(Path::Circle({-3, 0, 2}, 2, 10, 2), "(-3."));
}

// A platform that hangs far below its attachments also rests turned by 180 deg, with crossed cables, until
// these are too steep. The path follows this branch from a warm start on it, and does not jump to the other
// one.
TEST(EquilibriumPath, EndOfTheBranchIsRefused) {
  CdprDescription robot = test::FourCableRobot();
  for (CableDescription& cable : robot.cables) cable.attachment_B.z() = 0.6;
  StaticsOptions options{.warm_start = SolveInverseGeometricoStatic(robot, {0, 0.14, 2})};
  options.warm_start->euler = {0, 0, std::numbers::pi};
  const EquilibriumPath turned(robot, Path::Line({0, 0.14, 2}, {0, 0.14, 2.1}, 2), options);
  EXPECT_NEAR(turned.At(1).euler[2], std::numbers::pi, 0.1);

  const Path beyond = Path::Line({0, 0.14, 2}, {0, 0.14, 3.2}, 10);
  EXPECT_TRUE(Throws<ParameterError>([&] { EquilibriumPath(robot, beyond, options); }, "'four'", "(0, 0.14, ",
                                     "180 deg"));
}

// A platform at rest between anchors that all move like it has the tensions of standing anchors, at any
// velocity.
TEST(EquilibriumPath, MovesWithItsAnchorsAsIfTheyStood) {
  const std::vector<double> times{0.5, 2, 4};
  const std::vector<Vector3d> offsets{{0, 0, 0}, {1, 0.3, 0}, {3, -0.5, 0.4}};
  const Vector3d place(0.3, -0.2, 2);
  std::vector<Vector3d> points;
  for (const Vector3d& offset : offsets) points.push_back(place + offset);
  for (const double pulley_radius : {0.0, 0.05}) {
    const CdprDescription robot = test::FourCableRobot(0, pulley_radius);
    const EquilibriumPath still(robot, Path::Hold(place));
    const EquilibriumPath moves(test::WithAnchorsOn(robot, {times, offsets}), Path::Spline(points, times));
    const CdprReference expected = still.At(0);
    double fastest = 0;
    for (const double t : {0.0, 0.9, 1.6, 2.5, 3.1, 5.0}) {
      const CdprReference now = moves.At(t);
      EXPECT_THAT(now.tension, IsNear(expected.tension, 1e-6));
      EXPECT_THAT(now.euler, IsNear(expected.euler, 1e-8));
      EXPECT_THAT(now.length, IsNear(expected.length, 1e-8));
      EXPECT_LT(now.length_rate.norm(), 1e-7);
      fastest = std::max(fastest, now.velocity.norm());
    }
    EXPECT_GT(fastest, 1);
  }
}

// A platform that holds its place while each anchor has a path of its own: equilibria with the anchors at
// their places, and rates that are the derivatives of the lengths.
TEST(EquilibriumPath, HoldsItsPlaceBetweenMovingAnchors) {
  const CdprDescription robot = test::WithMovingAnchors(test::FourCableRobot(0, 0.05));
  const EquilibriumPath path(robot, Path::Hold({0.3, -0.2, 2}));
  for (const double t : {0.05, 0.2, 0.44, 0.7, 0.86, 1.5}) {
    const CdprReference now = path.At(t);
    const CdprDescription there = path.anchors().RobotAt(robot, t);
    const CableMatrix6 W = CalcCableKinematics(there, now.position, RotationFromEuler(now.euler)).structure;
    EXPECT_THAT(W * now.tension, IsNear(-GravityWrench(robot), 2e-3));
    const CableVector rate = (path.At(t + kStep).length - path.At(t - kStep).length) / (2 * kStep);
    EXPECT_THAT(now.length_rate, IsNear(rate, 1e-5));
  }
  EXPECT_GT(path.At(0.3).length_rate.norm(), 0.1);
}

TEST(EquilibriumPath, ACircleHasNoEndForMovingAnchors) {
  EXPECT_TRUE(Throws<ParameterError>(
      [] { EquilibriumPath(test::WithMovingAnchors(test::FourCableRobot()), TestCircle()); }, "'four' move",
      "circle", "spline"));
}

}  // namespace tenon::equilibrium_path_test
