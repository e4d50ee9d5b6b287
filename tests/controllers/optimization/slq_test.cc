#include <tenon/controllers/cdpr/cdpr_tracking_problem.h>
#include <tenon/controllers/cdpr/inverse_geometrico_static.h>
#include <tenon/controllers/optimization/slq.h>
#include <tenon/tests/controllers/optimization/slq_test_problems.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/dense_algebra.h>

#include <nlopt.hpp>

namespace tenon::slq_test {

using test::LinearProblem, test::PendulumProblem, test::SomeLinearProblem;

const std::vector<double> kUneven{0.02, 0.02, 0.03, 0.05, 0.05, 0.08, 0.1, 0.1};

/// All inputs of a policy in one vector.
template <class Problem>
Eigen::VectorXd InputsOf(const Slq<Problem>& slq) {
  const int m = slq.problem().num_inputs();
  Eigen::VectorXd u(m * slq.num_steps());
  for (int k = 0; k < slq.num_steps(); ++k) u.segment(m * k, m) = slq.policy()[k].u;
  return u;
}

/// The cost of a sequence of inputs, by a roll-out of its own.
template <class Problem>
double CostOf(const Problem& problem, const std::vector<double>& steps, typename Problem::State x,
              const Eigen::VectorXd& inputs) {
  RungeKutta<Problem> step(problem.num_states(), problem.num_inputs());
  const int m = problem.num_inputs();
  double cost = 0;
  for (std::size_t k = 0; k < steps.size(); ++k) {
    const typename Problem::Input u = inputs.segment(m * k, m);
    cost += steps[k] * problem.StageCost(k, x, u);
    typename Problem::State next = x;
    step.Step(problem, static_cast<int>(k), StepMethod::kRungeKutta4, steps[k], x, u, next);
    x = next;
  }
  return cost + problem.TerminalCost(x);
}

/// The best inputs by NLopt's SLSQP on the transcribed problem, with gradients by differences.
template <class Problem>
Eigen::VectorXd Transcribed(const Problem& problem, const std::vector<double>& steps,
                            const typename Problem::State& x0, Eigen::VectorXd u) {
  const auto cost = [&](const Eigen::VectorXd& v) { return CostOf(problem, steps, x0, v); };
  struct Data {
    const decltype(cost)& function;
    double step;
  } data{cost, 1e-5 * (1 + u.cwiseAbs().maxCoeff())};
  nlopt::opt solver(nlopt::LD_SLSQP, static_cast<unsigned>(u.size()));
  std::vector<double> lower(u.size()), upper(u.size()), v(u.data(), u.data() + u.size());
  const int m = problem.num_inputs();
  for (int i = 0; i < u.size(); ++i) {
    lower[i] = problem.Lower(i / m)[i % m];
    upper[i] = problem.Upper(i / m)[i % m];
  }
  solver.set_lower_bounds(lower);
  solver.set_upper_bounds(upper);
  solver.set_ftol_rel(1e-14);
  solver.set_xtol_rel(1e-12);
  solver.set_maxeval(2000);
  solver.set_min_objective(
      [](unsigned size, const double* x, double* gradient, void* raw) {
        const Data& data = *static_cast<const Data*>(raw);
        Eigen::VectorXd at = Eigen::Map<const Eigen::VectorXd>(x, size);
        for (unsigned i = 0; gradient != nullptr && i < size; ++i) {
          at[i] = x[i] + data.step;
          const double above = data.function(at);
          at[i] = x[i] - data.step;
          gradient[i] = (above - data.function(at)) / (2 * data.step);
          at[i] = x[i];
        }
        return data.function(at);
      },
      &data);
  double best = 0;
  try {
    solver.optimize(v, best);
  } catch (const nlopt::roundoff_limited&) {
  }
  return Eigen::Map<Eigen::VectorXd>(v.data(), u.size());
}

/// Solves, and expects every iteration to lower the cost and no input ever out of bounds.
template <class Problem>
SlqReport SolveStepByStep(Slq<Problem>& slq, const typename Problem::State& x0, int iterations) {
  SlqReport report;
  double last = INFINITY;
  for (int i = 0; i < iterations; ++i) {
    report = slq.Solve(x0);
    EXPECT_TRUE(report.ok()) << i;
    EXPECT_LE(report.cost, last + 1e-12 * (1 + std::abs(last))) << i;
    last = report.cost;
    for (int k = 0; k < slq.num_steps(); ++k) {
      EXPECT_GE((slq.policy()[k].u - slq.problem().Lower(k)).minCoeff(), 0);
      EXPECT_LE((slq.policy()[k].u - slq.problem().Upper(k)).maxCoeff(), 0);
    }
    if (report.status == SlqStatus::kConverged) break;
  }
  return report;
}

/// The Riccati recursion in its textbook form, for x' = A x + B u + c by augmenting the state with a one: of
/// a linear problem without bounds the inputs u_k = gains[k] (x_k, 1) are the best.
struct Textbook {
  std::vector<Eigen::MatrixXd> gains, As, Bs;
  Eigen::MatrixXd P;  // twice the cost to go is quadratic in (x_0, 1) by it
};
Textbook RiccatiOf(const LinearProblem<3, 2>& problem, const std::vector<double>& steps) {
  const auto augmented = [](const Eigen::MatrixXd& W, const Eigen::VectorXd& at) {
    const Eigen::Index size = at.size();
    Eigen::MatrixXd out(size + 1, size + 1);
    out << W, -W * at, -(W * at).transpose(), at.dot(W * at);
    return out;
  };
  Textbook out;
  Eigen::MatrixXd& P = out.P = augmented(problem.Q_f, problem.x_des);
  for (std::vector<Eigen::MatrixXd>* all : {&out.gains, &out.As, &out.Bs}) all->resize(steps.size());
  for (std::size_t k = steps.size(); k-- > 0;) {
    const double h = steps[k];
    const Eigen::Matrix3d Z = h * problem.A, one = Eigen::Matrix3d::Identity();
    const Eigen::Matrix3d series = one + Z / 2 + Z * Z / 6 + Z * Z * Z / 24;  // of order 4, as the step
    Eigen::MatrixXd A = Eigen::Matrix4d::Identity(), B = Eigen::MatrixXd::Zero(4, 2);
    A.topLeftCorner(3, 3) = one + Z * series;
    B.topRows(3) = h * series * problem.B;
    const Eigen::MatrixXd R = h * problem.R;
    Eigen::MatrixXd S = Eigen::MatrixXd::Zero(2, 4);
    S.col(3) = -h * problem.R * problem.u_des;
    out.gains[k] = -test::Solve(R + B.transpose() * P * B, B.transpose() * P * A + S);
    P = (h * augmented(problem.Q, problem.x_des) + A.transpose() * P * A +
         (B.transpose() * P * A + S).transpose() * out.gains[k])
            .eval();
    P(3, 3) += h * problem.u_des.dot(problem.R * problem.u_des);
    out.As[k] = A;
    out.Bs[k] = B;
  }
  return out;
}

TEST(Slq, TheFirstStepCanChange) {
  const auto problem = SomeLinearProblem();
  std::vector<double> steps = kUneven;
  Slq<LinearProblem<3, 2>> changed(problem, steps);
  steps[0] = 0.005;
  Slq<LinearProblem<3, 2>> fresh(problem, steps);
  changed.SetFirstStep(0.005);
  const Eigen::Vector3d x0(1, -2, 0.5);
  EXPECT_EQ(changed.Solve(x0).cost, fresh.Solve(x0).cost);
  for (std::size_t k = 0; k <= steps.size(); ++k)
    EXPECT_NEAR(changed.policy()[k].time, fresh.policy()[k].time, 1e-15);
}

TEST(Slq, SolvesALinearQuadraticProblemInOneIteration) {
  const auto problem = SomeLinearProblem();
  Slq<LinearProblem<3, 2>> slq(problem, kUneven);
  const Eigen::Vector3d x0(1, -2, 0.5);
  const SlqReport report = slq.Solve(x0);
  EXPECT_EQ(report.status, SlqStatus::kStepped);
  EXPECT_EQ(report.step_length, 1);

  const Textbook best = RiccatiOf(problem, kUneven);
  Eigen::Vector4d x(x0[0], x0[1], x0[2], 1);
  EXPECT_NEAR(report.cost, x.dot(best.P * x) / 2, 1e-9);
  for (std::size_t k = 0; k < kUneven.size(); ++k) {
    const Eigen::Vector2d u = best.gains[k] * x;
    EXPECT_THAT(slq.policy()[k].K, IsNear(best.gains[k].leftCols(3), 1e-9));
    EXPECT_THAT(slq.policy()[k].u, IsNear(u, 1e-9));
    EXPECT_THAT(slq.policy()[k].x, IsNear(x.head<3>(), 1e-9));
    x = best.As[k] * x + best.Bs[k] * u;
  }
  EXPECT_EQ(slq.Solve(x0).status, SlqStatus::kConverged);
}

TEST(Slq, SizesMayBeKnownAtRunTimeOnly) {
  Slq<LinearProblem<3, 2>> fixed(SomeLinearProblem(), kUneven);
  Slq<LinearProblem<Eigen::Dynamic, Eigen::Dynamic>> dynamic(
      SomeLinearProblem<Eigen::Dynamic, Eigen::Dynamic>(), kUneven);
  const Eigen::VectorXd x0 = Eigen::Vector3d(1, -2, 0.5);
  fixed.Solve(x0);
  EXPECT_EQ(AllocationsOf([&] { dynamic.Solve(x0); }), 0);
  EXPECT_THAT(InputsOf(dynamic), IsNear(InputsOf(fixed), 1e-12));
}

TEST(Slq, BoundedLinearProblemMatchesTheTranscription) {
  auto problem = SomeLinearProblem();
  problem.lower = Eigen::Vector2d(-2, -1);
  problem.upper = Eigen::Vector2d(3, 0.05);
  Slq<LinearProblem<3, 2>> slq(problem, kUneven);
  const Eigen::Vector3d x0(1, -2, 0.5);
  EXPECT_EQ(SolveStepByStep(slq, x0, 30).status, SlqStatus::kConverged);
  const Eigen::VectorXd u = InputsOf(slq);
  const Eigen::VectorXd expected = Transcribed(problem, kUneven, x0, Eigen::VectorXd::Zero(u.size()));
  EXPECT_NEAR(CostOf(problem, kUneven, x0, u), CostOf(problem, kUneven, x0, expected), 1e-8);
  EXPECT_THAT(u, IsNear(expected, 1e-4));
  EXPECT_EQ(u.maxCoeff(), 3);
}

TEST(Slq, BoundedPendulumMatchesTheTranscription) {
  const PendulumProblem problem;
  const std::vector<double> steps(30, 0.05);
  Slq<PendulumProblem> slq(problem, steps);
  const Eigen::Vector2d x0(1.5, 0);
  EXPECT_EQ(SolveStepByStep(slq, x0, 300).status, SlqStatus::kConverged);
  const Eigen::VectorXd u = InputsOf(slq);
  EXPECT_EQ(u.maxCoeff(), 6);  // a bound is active
  const Eigen::VectorXd expected = Transcribed(problem, steps, x0, 0.9 * u);
  const double cost = CostOf(problem, steps, x0, expected);
  EXPECT_NEAR(CostOf(problem, steps, x0, u), cost, 1e-6 * cost);
  EXPECT_THAT(u, IsNear(expected, 1e-2));
}

CdprTrackingProblem<4> CdprProblem(int steps, Eigen::Vector4d* tension = nullptr) {
  const CdprDescription robot = test::FourCableRobot();
  const StaticEquilibrium rest = SolveInverseGeometricoStatic(robot, {0.3, 0.2, 2});
  CdprTrackingProblem<4> problem(robot, steps);
  problem.Q << 1, 1, 1, 1, 1, 1, 100, 100, 100, 1, 1, 1;
  problem.R.setConstant(1e-5);
  problem.Q_f = (10 * problem.Q).asDiagonal();
  for (auto& target : problem.targets) {
    target.x << Eigen::VectorXd::Zero(6), rest.p_WB, rest.euler;
    target.u = rest.tension;
    target.lower.setConstant(30);
    target.upper.setConstant(180);
  }
  if (tension != nullptr) *tension = rest.tension;
  return problem;
}

TEST(Slq, BoundedCableRobotMatchesTheTranscription) {
  Eigen::Vector4d tension;
  const std::vector<double> steps(12, 0.06);
  const auto problem = CdprProblem(12, &tension);
  Slq<CdprTrackingProblem<4>> slq(problem, steps);
  CentroidalState x0 = problem.targets[0].x;
  x0[6] += 0.4;
  x0[8] -= 0.3;
  slq.SetPolicy(x0, tension);
  EXPECT_EQ(SolveStepByStep(slq, x0, 50).status, SlqStatus::kConverged);
  const Eigen::VectorXd u = InputsOf(slq);
  EXPECT_EQ(u.minCoeff(), 30);  // bounds are active
  EXPECT_EQ(u.maxCoeff(), 180);
  const Eigen::VectorXd expected =
      Transcribed(problem, steps, x0, Eigen::VectorXd(tension.replicate(steps.size(), 1)));
  const double cost = CostOf(problem, steps, x0, expected);
  EXPECT_NEAR(CostOf(problem, steps, x0, u), cost, 1e-7 * cost);
  EXPECT_THAT(u, IsNear(expected, 0.2));
}

// The first iteration for a linear problem, with projection in the roll-out or without bounds, is the
// unbounded optimal feedback, cut off at the bounds by the projection. Inputs at a bound keep their feedback.
TEST(Slq, WithoutBoundsInTheModelItIsTheUnboundedFeedback) {
  auto problem = SomeLinearProblem();
  const Textbook best = RiccatiOf(problem, kUneven);
  problem.lower = Eigen::Vector2d(-8, -3.7);
  problem.upper = Eigen::Vector2d(6.8, 4);
  const Eigen::Vector3d x0(1, -2, 0.5);
  for (const SlqBounds bounds : {SlqBounds::kRollOutProjection, SlqBounds::kNone}) {
    Slq<LinearProblem<3, 2>> slq(problem, kUneven, {.bounds = bounds});
    const SlqReport report = slq.Solve(x0);
    ASSERT_EQ(report.status, SlqStatus::kStepped);
    ASSERT_EQ(report.step_length, 1);
    Eigen::Vector4d x(x0[0], x0[1], x0[2], 1);
    int beyond = 0;
    for (std::size_t k = 0; k < kUneven.size(); ++k) {
      Eigen::Vector2d u = best.gains[k] * x;
      const Eigen::Vector2d projected = u.cwiseMax(problem.lower).cwiseMin(problem.upper);
      beyond += u != projected;
      if (bounds == SlqBounds::kRollOutProjection) u = projected;
      EXPECT_THAT(slq.policy()[k].u, IsNear(u, 1e-9)) << k;
      EXPECT_THAT(slq.policy()[k].K, IsNear(best.gains[k].leftCols(3), 1e-9)) << k;
      x = best.As[k] * x + best.Bs[k] * u;
    }
    EXPECT_GT(beyond, 2);
    EXPECT_LT(beyond, static_cast<int>(kUneven.size()));
    EXPECT_NEAR(report.cost, CostOf(problem, kUneven, x0, InputsOf(slq)), 1e-9);
  }
}

// Where the projection is active, the iteration with the unbounded model stops above the optimum, which the
// projected Newton iteration finds.
TEST(Slq, ProjectionInTheRollOutDescendsWithinTheBounds) {
  const PendulumProblem problem;
  const std::vector<double> steps(30, 0.05);
  const Eigen::Vector2d x0(1.5, 0);
  Slq<PendulumProblem> slq(problem, steps, {.bounds = SlqBounds::kRollOutProjection});
  double last = CostOf(problem, steps, x0, InputsOf(slq));
  int descents = 0;
  while (descents < 20) {
    const SlqReport report = slq.Solve(x0);
    if (!report.ok()) break;
    ASSERT_LT(report.cost, last);
    last = report.cost;
    ++descents;
    EXPECT_LE(InputsOf(slq).cwiseAbs().maxCoeff(), 6);
  }
  EXPECT_GE(descents, 3);
  EXPECT_EQ(InputsOf(slq).maxCoeff(), 6) << "a bound is active";
  EXPECT_NEAR(CostOf(problem, steps, x0, InputsOf(slq)), last, 1e-9 * last) << "what it reports it has";
  Slq<PendulumProblem> newton(problem, steps, {.max_iterations = 300});
  const SlqReport best = newton.Solve(x0);
  ASSERT_EQ(best.status, SlqStatus::kConverged);
  EXPECT_LE(best.cost, last + 1e-9);
}

TEST(Slq, AllIterationsInOneCall) {
  Slq<PendulumProblem> one(PendulumProblem(), std::vector<double>(30, 0.05));
  Slq<PendulumProblem> all(PendulumProblem(), std::vector<double>(30, 0.05), {.max_iterations = 7});
  const Eigen::Vector2d x0(1.5, 0);
  for (int i = 0; i < 7; ++i) one.Solve(x0);
  EXPECT_EQ(all.Solve(x0).iterations, 7);
  EXPECT_THAT(InputsOf(all), IsNear(InputsOf(one), 1e-6));
}

TEST(Slq, ShiftMovesThePolicyInTime) {
  Slq<LinearProblem<3, 2>> slq(SomeLinearProblem(), kUneven);
  slq.Solve(Eigen::Vector3d(1, -2, 0.5));
  const auto before = slq.policy();
  slq.Shift(0.02);
  EXPECT_THAT(slq.policy()[0].u, IsNear(before[1].u, 1e-14));
  EXPECT_THAT(slq.policy()[0].K, IsNear(before[1].K, 1e-14));
  EXPECT_THAT(slq.policy()[1].x, IsNear((before[2].x * 1 + before[2].x * 0), 1e-14));
  EXPECT_THAT(slq.policy()[2].x, IsNear(before[2].x + (before[3].x - before[2].x) * 0.02 / 0.03, 1e-14));
  EXPECT_THAT(slq.policy().back().x, IsNear(before.back().x, 0));
  slq.Shift(100);
  EXPECT_THAT(slq.policy()[0].x, IsNear(before.back().x, 0));
}

TEST(Slq, WarmStartSavesIterations) {
  const auto problem = CdprProblem(50);
  Slq<CdprTrackingProblem<4>> slq(problem, std::vector<double>(50, 0.02), {.max_iterations = 50});
  CentroidalState x0 = problem.targets[0].x;
  x0[6] += 0.3;
  slq.SetPolicy(x0, problem.targets[0].u);
  const SlqReport cold = slq.Solve(x0);
  const CentroidalState next = slq.policy()[1].x;
  slq.Shift(0.02);
  const SlqReport warm = slq.Solve(next);
  EXPECT_LT(warm.iterations, cold.iterations);
  // The warm start has little left to gain compared with the cold start.
  EXPECT_LT(warm.initial_cost - warm.cost, 0.01 * (cold.initial_cost - cold.cost));
}

TEST(Slq, LeavesThePolicyAloneWhenItFails) {
  Slq<PendulumProblem> slq(PendulumProblem(), std::vector<double>(10, 0.05));
  ASSERT_TRUE(slq.Solve({1, 0}).ok());
  const Eigen::VectorXd u = InputsOf(slq);
  EXPECT_EQ(slq.Solve({NAN, 0}).status, SlqStatus::kNotFinite);
  EXPECT_EQ(slq.Solve({1e200, 1e200}).status, SlqStatus::kNotFinite);
  EXPECT_THAT(InputsOf(slq), IsNear(u, 0));
  EXPECT_TRUE(slq.Solve({1, 0}).ok());
}

/// A pendulum with an adjustable error of its gradient, so that no step is a descent.
struct LyingPendulum : PendulumProblem {
  double lie = 0;
  void AddStageCost(int k, const State& x, const Input& u, double h, State& gx, Input& gu,
                    Eigen::Matrix2d& Hxx, Eigen::Matrix<double, 1, 1>& Huu) const {
    PendulumProblem::AddStageCost(k, x, u, h, gx, gu, Hxx, Huu);
    gu[0] += lie;
  }
};
TEST(Slq, ReportsWhenThereIsNoDescent) {
  LyingPendulum problem;
  problem.upper.setConstant(1000);
  problem.lower = -problem.upper;
  Slq<LyingPendulum> slq(problem, std::vector<double>(10, 0.05), {.max_iterations = 100});
  ASSERT_EQ(slq.Solve({1, 0}).status, SlqStatus::kConverged);
  const Eigen::VectorXd u = InputsOf(slq);
  slq.problem().lie = 100;
  const SlqReport report = slq.Solve({1, 0});
  EXPECT_EQ(report.status, SlqStatus::kNoDescent);
  EXPECT_FALSE(report.ok());
  EXPECT_THAT(InputsOf(slq), IsNear(u, 0));
}

/// A problem whose cost is a fraction of the cost that its gradients and Hessians belong to.
struct Understated : LinearProblem<3, 2> {
  double part = 1;
  double StageCost(int k, const State& x, const Input& u) const {
    return part * LinearProblem::StageCost(k, x, u);
  }
  double TerminalCost(const State& x) const { return part * LinearProblem::TerminalCost(x); }
};
// For a linear problem every step then decreases the cost by this fraction of the expected decrease; Armijo's
// rule requires 1e-4.
TEST(Slq, AcceptsStepsByArmijosRule) {
  Slq<Understated> fair({SomeLinearProblem(), 1.01e-4}, kUneven),
      unfair({SomeLinearProblem(), 0.99e-4}, kUneven);
  EXPECT_EQ(fair.Solve({1, -2, 0.5}).step_length, 1);
  EXPECT_GT(unfair.Solve({1, -2, 0.5}).regularisation, 0) << "no step was good";
}

/// dx/dt = u from x = 0 towards 2, with the path constraint x <= 1 at all nodes but the last:
/// min sum_k 1/2 ((x_k - 2)^2 + u_k^2) + 1/2 (x_2 - 2)^2 over two steps of 1 s.
struct Fenced : LinearProblem<1, 1> {
  AugmentedLagrangian lagrangian;
  std::array<double, 2> multipliers{};

  Fenced() {
    for (auto* one : {&B, &Q, &Q_f, &R}) one->setOnes();
    A.setZero(), u_des.setZero(), x_des.setConstant(2), upper.setConstant(1e6), lower.setConstant(-1e6);
  }
  double StageCost(int k, const State& x, const Input& u) const {
    return LinearProblem::StageCost(k, x, u) + lagrangian.Cost(1 - x[0], multipliers[k]);
  }
  void AddStageCost(int k, const State& x, const Input& u, double h, State& gx, Input& gu, StateMatrix& Hxx,
                    InputMatrix& Huu) const {
    LinearProblem::AddStageCost(k, x, u, h, gx, gu, Hxx, Huu);
    const double next = lagrangian.Multiplier(1 - x[0], multipliers[k]);
    gx[0] += h * next;
    if (next > 0) Hxx(0, 0) += h * lagrangian.penalty;
  }
};
// With x_1 = 1 the last input minimises u^2 + (1 + u - 2)^2, so it is 1/2, and the multiplier balances the
// derivative by x_1: u_0 + (x_1 - 2) - u_1 + multiplier = 0. Each solve leaves 5/2 / (5/2 + penalty) of its
// error.
TEST(Slq, MultipliersOfAPathConstraintConverge) {
  Slq<Fenced> slq(Fenced(), {1, 1}, {.max_iterations = 5, .tolerance = 0});
  slq.problem().lagrangian.penalty = 2.5;
  double& multiplier = slq.problem().multipliers[1];
  for (double error = 0.25; error > 1e-7; error /= 2) {
    ASSERT_TRUE(slq.Solve(Fenced::State(0)).ok());
    multiplier = slq.problem().lagrangian.Multiplier(1 - slq.policy()[1].x[0], multiplier);
    ASSERT_NEAR(multiplier, 0.5 - error, 1e-9);
  }
  EXPECT_NEAR(slq.policy()[1].x[0], 1, 1e-6);
}

TEST(Slq, RefusesStepsThatMakeNoSense) {
  EXPECT_TRUE(Throws<ParameterError>([] { Slq<PendulumProblem>(PendulumProblem(), {}); }, "steps"));
  EXPECT_TRUE(Throws<ParameterError>([] { Slq<PendulumProblem>(PendulumProblem(), {0.1, -0.1}); }, "step 1"));
  EXPECT_TRUE(Throws<ParameterError>(
      [] { Slq<PendulumProblem>(PendulumProblem(), {0.1}, {.max_iterations = 0}); }, "max_iterations"));
}

}  // namespace tenon::slq_test
