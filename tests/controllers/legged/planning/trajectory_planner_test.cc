// The program of a planned crawl: its forces one by one, its optimum by another algorithm of NLopt, and the
// plans that follow from it.

#include <tenon/controllers/legged/planning/trajectory_planner.h>
#include <tenon/tests/controllers/legged/planning/test_map.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/derivative_check.h>

#include <Eigen/Geometry>
#include <nlopt.hpp>

namespace tenon::trajectory_planner_test {

using Problem = TrajectoryProblem;

/// A robot that crawls forward from its nominal stance at (0, 0).
class TrajectoryPlannerTest : public ::testing::Test {
 protected:
  TrajectoryPlannerTest() {
    state_.p_WB.head<2>() = -block_.stance.center_B;
    body_.com_W << 0, 0, block_.stance.com_height;
    schedule_.timing = {.num_steps = 4, .step = {1, 3, 0, 2}, .stance = 0.05, .swing = 0.3};
    path_.velocity << 0.15, 0;
    Fix(rig_);
  }
  void Fix(TestRig<TrajectoryPlanner>& rig) {
    rig.Fix(rig->schedule, schedule_).Fix(rig->body, body_).Fix(rig->path, path_).Fix(rig->state, state_);
    rig.Fix(rig->ground, GroundPlane());
  }
  /// Goes on to the next footstep.
  const TrajectoryPlan& Step() {
    if (++schedule_.footsteps > 1) {
      rig_.RunTo(0.35 * (schedule_.footsteps - 1) - 1e-3);
      schedule_.step = (schedule_.step + 1) % 4;
      path_.position_W[0] += 0.15 * 0.35;
    }
    schedule_.gait = Gait::kCrawl;
    Fix(rig_);
    return rig_.Tick()[block_.plan];
  }
  /// The program of a crawl onto a step of 0.1 m, and z of its solution.
  std::pair<Problem, std::vector<double>> Solved() {
    rig_.Fix(block_.map,
             test::MapOf([&](double x, double) { return x > block_.stance.foot[0][0] + 0.03 ? 0.1 : 0; }));
    Step();
    Problem problem = rig_[block_.problem];
    std::vector<double> z(problem.lower.size());
    problem.Guess(problem.U(z.data()).data(), z.data());
    EXPECT_EQ(problem.Solve(200, 1e-8, z.data()), "");
    return {problem, z};
  }

  TestRig<TrajectoryPlanner> rig_{TrajectoryPlannerParams{.robot = test::DogBot()}};
  TrajectoryPlanner& block_ = rig_.system();
  LeggedState state_ = test::Standing(test::DogBot());
  BodyReference body_;
  PlanarPath path_;
  ContactSchedule schedule_;
};

TEST_F(TrajectoryPlannerTest, GradientsAgreeWithFiniteDifferences) {
  auto [problem, z] = Solved();
  const int n = static_cast<int>(z.size()), m = problem.num_equalities(), q = problem.num_inequalities();
  Eigen::VectorXd values(m + q + 1);
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> rows(m + q + 1, n);
  const auto all = [&, &p = problem](const Eigen::VectorXd& at) -> Eigen::VectorXd {
    p.Equalities(at.data(), values.data(), rows.data());
    p.Inequalities(at.data(), values.data() + m, rows.row(m).data());
    values[m + q] = p.Cost(at.data(), rows.row(m + q).data());
    return values;
  };
  const Eigen::VectorXd at = Eigen::VectorXd::LinSpaced(n, -0.7, 0.9).array().sin();
  all(at);
  const Eigen::MatrixXd jacobian = rows;
  EXPECT_TRUE(IsJacobian(jacobian, all, at, 1e-8));
}

TEST_F(TrajectoryPlannerTest, TheFeetsForcesMoveTheComWithoutTurningTheTrunk) {
  auto [problem, z] = Solved();
  const Eigen::VectorXd u = problem.U(z.data());
  Eigen::Vector3d c = problem.start, v = problem.velocity, last = Eigen::Vector3d::Zero();
  for (int k = 0; k < problem.num_knots(); ++k) {
    const Eigen::Vector3d a(u[problem.A(k, 0)], u[problem.A(k, 1)], u[problem.A(k, 2)]);
    const double T = k > 0 ? problem.knots[k].time - problem.knots[k - 1].time : 0;
    c += T * v + T * T / 6 * (2 * last + a);  // the integral of the linear acceleration
    v += T / 2 * (last + a);
    last = a;
    const Eigen::Vector3d F = a + Eigen::Vector3d::UnitZ();
    EXPECT_LE(F.head<2>().norm(), problem.friction * F[2] + 1e-6);
    double sum = 0;
    for (int i = 0; i < kNumLegs; ++i) sum += u[problem.W(k, i)];
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    for (int i = 0; i < kNumLegs; ++i) {
      const Eigen::Vector3d p = u.segment<3>(problem.P(problem.knots[k].foot[i], 0));
      moment += (p - c).cross(u[problem.W(k, i)] / sum * F);
      EXPECT_GE(u[problem.W(k, i)], problem.knots[k].carries[i] ? problem.properties.least_load - 1e-9 : 0);
      const double leg = problem.knots[k].reaches[i] ? (c + problem.knots[k].hip[i] - p).norm() : 0;
      EXPECT_LE(leg, problem.reach[i] + 1e-6);
    }
    EXPECT_THAT(moment, IsNear(Vec<3>(0, 0, 0), 1e-6)) << "knot " << k;
  }
}

template <auto Constraints>
void Call(unsigned, double* values, unsigned, const double* z, double* rows, void* self) {
  (static_cast<Problem*>(self)->*Constraints)(z, values, rows);
}

TEST_F(TrajectoryPlannerTest, AnAugmentedLagrangianFindsTheSameOptimum) {
  auto [problem, z] = Solved();
  std::vector<double> other(z.size());
  nlopt::opt lagrangian(nlopt::LD_AUGLAG, z.size()), local(nlopt::LD_LBFGS, z.size());
  local.set_ftol_rel(1e-12);
  lagrangian.set_local_optimizer(local);
  const auto cost = [](unsigned, const double* at, double* gradient, void* self) {
    return static_cast<Problem*>(self)->Cost(at, gradient);
  };
  lagrangian.set_min_objective(cost, &problem);
  const auto tolerance = [](int count) { return std::vector<double>(count, 1e-7); };
  lagrangian.add_equality_mconstraint(&Call<&Problem::Equalities>, &problem,
                                      tolerance(problem.num_equalities()));
  lagrangian.add_inequality_mconstraint(&Call<&Problem::Inequalities>, &problem,
                                        tolerance(problem.num_inequalities()));
  lagrangian.set_lower_bounds(problem.lower);
  lagrangian.set_upper_bounds(problem.upper);
  lagrangian.set_ftol_rel(1e-9);
  double least = 0;
  lagrangian.optimize(other, least);
  EXPECT_NEAR(problem.Cost(z.data(), nullptr), least, 1e-4 * least);
}

TEST_F(TrajectoryPlannerTest, APlanContinuesTheReferenceAndStartsWarm) {
  EXPECT_THAT(rig_.Tick()[block_.reference].com_W, IsNear(body_.com_W, 0)) << "stands";
  rig_.RunTo(0.1);
  schedule_.footsteps = 1;
  const int cold = Step().diagnostics.iterations;
  rig_.RunTo(0.698);
  const BodyReference before = rig_[block_.reference];
  EXPECT_LE(Step().diagnostics.iterations, cold);
  EXPECT_EQ(rig_[block_.plan].diagnostics.failures, 0);
  EXPECT_THAT(rig_[block_.reference].com_W,
              IsNear(Vec<3>(before.com_W + 2e-3 * before.com_velocity_W), 1e-5));
}

// A gap across the way of the rear left foot, which swings first, and whose nominal place is inside.
TEST_F(TrajectoryPlannerTest, FeetLandOnFlatGroundBesideAGap) {
  const double x = block_.stance.foot[kRearLeft][0] + 0.15 * (0.35 + 0.55);
  rig_.Fix(block_.map, test::MapOf([&](double at, double) { return std::abs(at - x) < 0.1 ? -0.5 : 0; }));
  const double off = std::abs(Step().footholds.position_W[kRearLeft][0] - x) - 0.1;
  EXPECT_GT(off, MapFootholdProperties().radius);
  EXPECT_LT(off, MapFootholdProperties().radius + 4 * 0.03);
}

TEST_F(TrajectoryPlannerTest, WithoutGroundTheLastPlanGoesOnToItsEnd) {
  const TrajectoryPlan first = Step();
  rig_.Fix(block_.map, test::MapOf([](double at, double) { return std::sin(40 * at); }));
  const TrajectoryPlan second = Step();
  EXPECT_EQ(second.diagnostics.failures, 1);
  EXPECT_EQ(second.start, first.start);
  EXPECT_THAT(second.footholds.position_W[kFrontLeft], IsNear(first.footholds.position_W[kFrontLeft], 0));
  Step();
  Step();
  EXPECT_TRUE(Throws<RunError>([&] { Step(); }, "block", "flat ground", "leg"));
}

TEST_F(TrajectoryPlannerTest, RefusesWhatItCannotPlan) {
  TrajectoryPlannerParams params = block_.params;
  params.trajectory.max_evaluations = 1;
  schedule_.gait = Gait::kCrawl;
  const auto tick = [&] {
    TestRig<TrajectoryPlanner> rig(params);
    Fix(rig);
    rig.Tick();
  };
  EXPECT_TRUE(Throws<RunError>(tick, "block", "MAXEVAL_REACHED", "max_evaluations"));
  schedule_.timing.stance = -0.03;
  EXPECT_TRUE(Throws<RunError>(tick, "block", "stance_s"));
  params.trajectory.search = -1;
  EXPECT_TRUE(Throws<ParameterError>(tick, "search_m"));
}

}  // namespace tenon::trajectory_planner_test
