#include <tenon/controllers/legged/planning/thesis_planner.h>
#include <tenon/tests/controllers/optimization/qp_certificate.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>

namespace tenon::zmp_spline_test {

using Feet = std::vector<Eigen::Vector2d>;
constexpr double kHeight = 0.4, kGravity = 9.81;
const Eigen::Vector2d kFrontLeftFoot(0.3, 0.2), kFrontRightFoot(0.3, -0.2), kRearLeftFoot(-0.3, 0.2),
    kRearRightFoot(-0.3, -0.2);

Eigen::Vector2d Zmp(const PlanarPoint& p, double height = kHeight, double vertical_acceleration = 0) {
  return p.position - height / (kGravity + vertical_acceleration) * p.acceleration;
}

/// Stands on four feet, then on pairs at the sides with four in between: a pace on the spot, from rest.
struct Pace {
  explicit Pace(double half_width = 0.03, double margin = 0.01) {
    const Feet all{kFrontLeftFoot, kFrontRightFoot, kRearLeftFoot, kRearRightFoot},
        left{kFrontLeftFoot, kRearLeftFoot}, right{kFrontRightFoot, kRearRightFoot};
    for (const Feet& pair : {left, right}) {
      phases.push_back({0.15, SupportPolygon(all, half_width, margin)});
      phases.push_back({0.115, SupportPolygon(pair, half_width, margin)});
    }
    phases.push_back({0.15, SupportPolygon(all, half_width, margin)});
  }
  ZmpSplineProblem problem() const {
    return {.phases = phases, .begin = begin, .end = end, .path = path, .height = {.rest = kHeight}};
  }
  double duration() const {
    double sum = 0;
    for (const SupportPhase& phase : phases) sum += phase.duration;
    return sum;
  }
  std::vector<SupportPhase> phases;
  PlanarPoint begin, end;
  PlanarPath path;
};

class ZmpSplineTest : public ::testing::TestWithParam<SplineOrder> {
 protected:
  const ZmpSplineParams params_{.order = GetParam()};
  ZmpSpline optimizer_;
  PlanarSpline spline_;
};
INSTANTIATE_TEST_SUITE_P(Order, ZmpSplineTest, ::testing::Values(SplineOrder::kCubic, SplineOrder::kQuintic),
                         [](const auto& info) { return std::string(EnumName(info.param)); });

/// The cost by the trapezoid of many points, from the spline alone.
double Cost(const PlanarSpline& spline, const ZmpSplineProblem& problem, const ZmpSplineParams& params) {
  const int n = 20000;
  double sum = 0;
  for (int i = 0; i <= n; ++i) {
    const double t = spline.duration * i / n;
    const PlanarPoint p = spline.At(t);
    const double value = p.acceleration.squaredNorm() +
                         params.path_weight * (p.position - problem.path.At(t).position_W).squaredNorm();
    sum += (i == 0 || i == n ? 0.5 : 1) * value;
  }
  return sum * spline.duration / n +
         params.end_weight *
             (spline.At(spline.duration).acceleration - problem.end.acceleration).squaredNorm();
}

TEST_P(ZmpSplineTest, BeginsAndEndsAsPrescribedWithoutJumps) {
  Pace pace;
  pace.begin = {{0.01, -0.02}, {0.1, 0.2}, {0.5, -0.3}};
  pace.path.velocity << 0.1, 0;
  pace.end = {{0.0665, 0.005}, {0.1, -0.05}, {0, 0}};
  const QpReport report = optimizer_.Solve(pace.problem(), params_, &spline_);
  ASSERT_TRUE(report.ok()) << report.Message();
  EXPECT_NEAR(spline_.duration, pace.duration(), 1e-14);
  EXPECT_EQ(spline_.num_segments, GetParam() == SplineOrder::kCubic ? 10 : 5);
  const PlanarPoint begin = spline_.At(0), end = spline_.At(spline_.duration);
  EXPECT_EQ(begin.position, pace.begin.position);
  EXPECT_THAT(begin.velocity, IsNear(pace.begin.velocity, 1e-15));
  EXPECT_THAT(begin.acceleration, IsNear(pace.begin.acceleration, 1e-14));
  EXPECT_THAT(end.position, IsNear(pace.end.position, 1e-12));
  EXPECT_THAT(end.velocity, IsNear(pace.end.velocity, 1e-12));
  EXPECT_GT((end.acceleration - pace.end.acceleration).norm(), 0.01);  // but wished for

  double t = 0;
  for (int k = 0; k + 1 < spline_.num_segments; ++k) {
    t += spline_.segments[k].duration;
    const double h = 1e-9;
    const PlanarPoint before = spline_.At(t - h), after = spline_.At(t + h);
    EXPECT_THAT(after.position, IsNear(before.position, 1e-8)) << k;
    EXPECT_THAT(after.velocity, IsNear(before.velocity, 1e-7)) << k;
    EXPECT_THAT(after.acceleration, IsNear(before.acceleration, 1e-5)) << k;
  }
}

TEST_P(ZmpSplineTest, KeepsTheZmpInThePolygons) {
  const Pace pace;
  const QpReport report = optimizer_.Solve(pace.problem(), params_, &spline_);
  ASSERT_TRUE(report.ok()) << report.Message();
  EXPECT_TRUE(test::IsOptimal(optimizer_.quadratic_program(), optimizer_.solver()));
  EXPECT_FALSE(optimizer_.solver().active().empty());
  double begin = 0, least = 1;
  for (const SupportPhase& phase : pace.phases) {
    for (double t = 1e-6; t < phase.duration; t += 1e-3)
      least = std::min(least, phase.polygon.Depth(Zmp(spline_.At(begin + t))));
    begin += phase.duration;
  }
  EXPECT_GT(least, -1e-3);
  EXPECT_LT(least, 1e-4);  // the constraints are met with equality somewhere

  // Without the constraints the optimum is to stay at the start, which is outside the polygons.
  std::vector<SupportPhase> free;
  for (const SupportPhase& phase : pace.phases) free.push_back({phase.duration, SupportPolygon()});
  ZmpSplineProblem problem = pace.problem();
  problem.phases = free;
  ASSERT_TRUE(optimizer_.Solve(problem, params_, &spline_).ok());
  EXPECT_LT(Cost(spline_, problem, params_), 1e-20);
}

/// Without active polygons the minimum also follows from one linear solve for the coefficients of all
/// segments, with junctions and ends as equalities.
TEST_P(ZmpSplineTest, IsTheMinimumOfTheUnconstrainedProblem) {
  Pace pace;
  for (SupportPhase& phase : pace.phases) phase.polygon = SupportPolygon();
  pace.begin = {{0.05, -0.02}, {0.3, 0.2}, {-1, 0.8}};
  pace.end = {{0.12, 0.03}, {-0.1, 0.2}, {0.4, -0.6}};
  pace.path.position_W << 0.02, 0.01;
  pace.path.velocity << 0.15, 0.05;
  ASSERT_TRUE(optimizer_.Solve(pace.problem(), params_, &spline_).ok());

  const int degree = GetParam() == SplineOrder::kCubic ? 3 : 5, size = degree + 1;
  const int segments = spline_.num_segments, n = segments * size;
  const int equalities = 3 + 3 * (segments - 1) + 2;
  const auto row = [&](int k, int derivative, double t) {
    Eigen::RowVectorXd r = Eigen::RowVectorXd::Zero(n);
    for (int i = derivative; i <= degree; ++i) {
      double factor = std::pow(t, i - derivative);
      for (int j = 0; j < derivative; ++j) factor *= i - j;
      r[k * size + i] = factor;
    }
    return r;
  };
  Eigen::MatrixXd kkt = Eigen::MatrixXd::Zero(n + equalities, n + equalities);
  Eigen::MatrixXd right = Eigen::MatrixXd::Zero(n + equalities, 2);
  auto demand = [&, next = n](const Eigen::RowVectorXd& r, const Eigen::Vector2d& value) mutable {
    kkt.row(next).head(n) = r;
    kkt.col(next).head(n) = r.transpose();
    right.row(next++) = value.transpose();
  };
  demand(row(0, 0, 0), pace.begin.position);
  demand(row(0, 1, 0), pace.begin.velocity);
  demand(row(0, 2, 0), pace.begin.acceleration);
  double begin = 0;
  for (int k = 0; k < segments; ++k) {
    const double T = spline_.segments[k].duration;
    if (k + 1 < segments) {
      for (int d = 0; d < 3; ++d) demand(row(k, d, T) - row(k + 1, d, 0), {0, 0});
    } else {
      demand(row(k, 0, T), pace.end.position);
      demand(row(k, 1, T), pace.end.velocity);
    }
    for (int i = 0; i <= degree; ++i) {  // the integrals of t^i and their products
      for (int j = 0; j <= degree; ++j) {
        kkt(k * size + i, k * size + j) += params_.path_weight * std::pow(T, i + j + 1) / (i + j + 1);
        if (i < 2 || j < 2) continue;
        kkt(k * size + i, k * size + j) += i * (i - 1) * j * (j - 1) * std::pow(T, i + j - 3) / (i + j - 3);
      }
      const Eigen::Vector2d at_begin = pace.path.At(begin).position_W;
      right.row(k * size + i) += params_.path_weight * (std::pow(T, i + 1) / (i + 1) * at_begin +
                                                        std::pow(T, i + 2) / (i + 2) * pace.path.VelocityW());
    }
    begin += T;
  }
  const Eigen::RowVectorXd last = row(segments - 1, 2, spline_.segments[segments - 1].duration);
  kkt.topLeftCorner(n, n) += params_.end_weight * last.transpose() * last;
  right.topRows(n) += params_.end_weight * last.transpose() * pace.end.acceleration.transpose();
  const Eigen::MatrixXd solution = test::Solve(kkt, right);

  double t = 0;
  for (int k = 0; k < segments; ++k) {
    const double T = spline_.segments[k].duration;
    for (const double s : {0.0, 0.4, 0.9}) {
      const PlanarPoint p = spline_.At(t + s * T);
      const auto coefficients = solution.topRows(n);
      EXPECT_THAT(p.position, IsNear((row(k, 0, s * T) * coefficients).transpose(), 1e-8)) << k;
      EXPECT_THAT(p.acceleration, IsNear((row(k, 2, s * T) * coefficients).transpose(), 1e-5)) << k;
    }
    t += T;
  }
}

/// Near the optimum, in any feasible direction, the cost rises; measured from the splines alone.
TEST_P(ZmpSplineTest, MinimisesTheCost) {
  Pace pace;
  pace.begin = {{0.02, 0.01}, {0.1, 0.1}, {0.2, -0.1}};
  pace.path.velocity << 0.2, 0;
  pace.path.yaw_rate = 0.5;
  pace.end = {{0.1, 0.02}, {0.2, 0.05}, {0, 0}};
  const ZmpSplineProblem problem = pace.problem();
  ASSERT_TRUE(optimizer_.Solve(problem, params_, &spline_).ok());
  const PlanarSpline bounded = spline_;
  const QuadraticProgram qp = optimizer_.quadratic_program();
  const auto value = [&] {
    const Eigen::VectorXd x = optimizer_.solver().x();
    const Eigen::MatrixXd H = qp.H.selfadjointView<Eigen::Lower>();
    return 0.5 * x.dot(H * x) + qp.g.dot(x);
  };
  const double programme = value();
  ZmpSplineProblem unbounded_problem = problem;
  for (SupportPhase& phase : pace.phases) phase.polygon = SupportPolygon();
  unbounded_problem.phases = pace.phases;
  ASSERT_TRUE(optimizer_.Solve(unbounded_problem, params_, &spline_).ok());
  const double rise = programme - value();
  EXPECT_GT(rise, 0.01);
  EXPECT_NEAR(Cost(bounded, problem, params_) - Cost(spline_, problem, params_), rise, 1e-5 * (1 + rise));
}

TEST_P(ZmpSplineTest, APrescribedHeightCounts) {
  Pace pace;
  ZmpSplineProblem problem = pace.problem();
  const double T = 0.15 + 0.115 + 0.15;  // 5 cm too high, until the second swing begins
  problem.height = {
      .rest = kHeight, .fade_duration = T, .fade = {0.05, 0, -0.15 / (T * T), 0.1 / (T * T * T)}};
  EXPECT_NEAR(problem.height.At(T / 2), kHeight + 0.025, 1e-15);
  EXPECT_NEAR(problem.height.Acceleration(T / 4), -0.15 / (T * T), 1e-14);
  EXPECT_EQ(problem.height.At(T), kHeight);
  EXPECT_EQ(problem.height.Acceleration(T), 0);
  ASSERT_TRUE(optimizer_.Solve(problem, params_, &spline_).ok());
  double begin = 0, least = 1, as_if_level = 1;
  for (const SupportPhase& phase : pace.phases) {
    for (double t = 1e-6; t < phase.duration; t += 1e-3) {
      const PlanarPoint p = spline_.At(begin + t);
      const HeightProfile& z = problem.height;
      least = std::min(least, phase.polygon.Depth(Zmp(p, z.At(begin + t), z.Acceleration(begin + t))));
      as_if_level = std::min(as_if_level, phase.polygon.Depth(Zmp(p)));
    }
    begin += phase.duration;
  }
  EXPECT_GT(least, -1e-3);
  EXPECT_LT(as_if_level, -3e-3);
}

TEST_P(ZmpSplineTest, FarFromTheOriginNothingChanges) {
  Pace here, there;
  const Eigen::Vector2d far(2e3, -1e3);
  const Feet all{kFrontLeftFoot + far, kFrontRightFoot + far, kRearLeftFoot + far, kRearRightFoot + far};
  const std::array<Feet, 2> pairs{Feet{all[0], all[2]}, Feet{all[1], all[3]}};
  for (std::size_t k = 0; k < there.phases.size(); ++k)
    there.phases[k].polygon = SupportPolygon(k % 2 == 0 ? all : pairs[k / 2], 0.03, 0.01);
  there.begin.position = there.end.position = there.path.position_W = far;
  PlanarSpline moved;
  ASSERT_TRUE(optimizer_.Solve(here.problem(), params_, &spline_).ok());
  ASSERT_TRUE(optimizer_.Solve(there.problem(), params_, &moved).ok());
  for (double t = 0; t < spline_.duration; t += 0.01)
    EXPECT_THAT(moved.At(t).position - far, IsNear(spline_.At(t).position, 1e-9)) << t;
}

TEST_P(ZmpSplineTest, AnInfeasibleProblemKeepsTheSpline) {
  Pace pace;
  ASSERT_TRUE(optimizer_.Solve(pace.problem(), params_, &spline_).ok());
  const Eigen::Vector2d before = spline_.At(0.2).position;
  pace.begin.velocity << 0, 3;  // out of the feet's reach before it can be stopped
  EXPECT_EQ(optimizer_.Solve(pace.problem(), params_, &spline_).status, QpStatus::kInfeasible);
  EXPECT_EQ(spline_.At(0.2).position, before);
}

TEST(PlanarSpline, DerivativesAreThoseOfThePosition) {
  RandomStream random(1);
  PlanarSpline spline;
  spline.origin << 1, 2;
  spline.num_segments = 2;
  for (int k = 0; k < 2; ++k) {
    spline.segments[k].duration = 0.3 + 0.2 * k;
    spline.duration += spline.segments[k].duration;
    for (Vec<2>& c : spline.segments[k].coefficients) c << random.Uniform(-1, 1), random.Uniform(-1, 1);
  }
  const double h = 1e-5;
  for (const double t : {0.1, 0.25, 0.35, 0.7}) {
    const PlanarPoint p = spline.At(t), before = spline.At(t - h), after = spline.At(t + h);
    EXPECT_THAT((after.position - before.position) / (2 * h), IsNear(p.velocity, 1e-6));
    EXPECT_THAT((after.velocity - before.velocity) / (2 * h), IsNear(p.acceleration, 1e-5));
  }
  EXPECT_EQ(spline.At(0.3).position, spline.origin + spline.segments[1].coefficients[0]);
  EXPECT_EQ(PlanarSpline().At(1).position, Eigen::Vector2d(0, 0));
}

// A polynomial of degree five is one of the splines, so without polygons and with a great weight it is the
// solution.
TEST(ZmpSpline, FollowsARegularisedPath) {
  const PlanarPoint begin{{0.01, -0.02}, {0.1, 0.2}, {0.5, -0.3}}, end{.position = {0.07, 0.01}};
  const PlanarSpline path = QuinticBetween(begin, end, 0.4);
  const std::vector<SupportPhase> phases{{0.4, SupportPolygon()}};
  PlanarSpline spline;
  const QpReport report =
      ZmpSpline().Solve({.phases = phases, .begin = begin, .end = end, .regularized = &path},
                        {.order = SplineOrder::kQuintic, .path_weight = 1e9}, &spline);
  ASSERT_TRUE(report.ok()) << report.Message();
  for (double t = 0; t <= 0.4; t += 0.05)
    EXPECT_THAT(spline.At(t).position, IsNear(path.At(t).position, 1e-6)) << t;
}

TEST(ZmpSpline, RefusesNonsense) {
  ZmpSpline optimizer;
  PlanarSpline spline;
  const std::vector<SupportPhase> many(10, {0.1, SupportPolygon()});
  EXPECT_TRUE(Throws<RunError>([&] { optimizer.Solve({}, {}, &spline); }, "0 support phases"));
  EXPECT_TRUE(Throws<RunError>([&] { optimizer.Solve({.phases = many}, {}, &spline); }, "10 support phases"));
}

}  // namespace tenon::zmp_spline_test
