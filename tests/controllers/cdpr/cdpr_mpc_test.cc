#include <tenon/controllers/cdpr/cdpr_clearance.h>
#include <tenon/controllers/cdpr/cdpr_mpc.h>
#include <tenon/plants/signals/euler.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>

#include <numeric>

namespace tenon::cdpr_mpc_test {

CdprMpcParams Holding(const CdprDescription& robot, const Eigen::Vector3d& at) {
  CdprMpcParams params;
  StaticsOptions options;
  if (robot.num_cables() >= 6) options.attitude = Eigen::Vector3d::Zero();
  params.path = std::make_shared<EquilibriumPath>(robot, Path::Hold(at), options);
  params.horizon = 1.2;
  params.num_steps = 25;
  params.weights = {.position = Vec<3>::Constant(1000),
                    .velocity = Vec<3>::Constant(20),
                    .attitude = Vec<3>::Constant(20),
                    .angular_velocity = Vec<3>::Ones(),
                    .tension = 3e-3};
  return params;
}

/// The platform on its reference, displaced by `offset`.
PlatformEstimate At(const CdprMpcParams& params, double time, const Eigen::Vector3d& offset) {
  const CdprReference reference = params.path->At(time);
  return {.time = time,
          .platform = {.p_WB = reference.position + offset,
                       .q_WB = QuaternionFromRotation(RotationFromEuler(reference.euler)),
                       .v_W = reference.velocity}};
}

TEST(CdprMpcSteps, AreUniformOverAShortHorizon) {
  CdprMpcParams params = Holding(test::FourCableRobot(), {0, 0, 2});
  params.horizon = 0.25;
  EXPECT_THAT(CdprMpcSolver::Steps(params), ::testing::Each(1));
}

TEST(CdprMpcSteps, GrowFromOnePeriodToTheHorizon) {
  CdprMpcParams params = Holding(test::FourCableRobot(), {0, 0, 2});
  params.horizon = 2;
  const std::vector<int> steps = CdprMpcSolver::Steps(params);
  ASSERT_EQ(steps.size(), 25u);
  EXPECT_EQ(steps.front(), 1);
  EXPECT_GT(steps.back(), 12);
  EXPECT_GE(*std::min_element(steps.begin(), steps.end()), 1);
  EXPECT_EQ(std::accumulate(steps.begin(), steps.end(), 0), 200);
}

class CdprMpcOfRobots : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Cables, CdprMpcOfRobots, ::testing::Values(4, 5, 6, 7, 8, 12, 16),
                         ::testing::PrintToStringParamName());

// At the equilibrium the command is its tension; beside it the policy pulls back.
TEST_P(CdprMpcOfRobots, HoldsTheEquilibriumAndPullsBackToIt) {
  CdprDescription robot = test::RobotWithCables(GetParam());
  if (GetParam() == 7)
    robot.cables[6] = test::SixCableRobot().cables[0], robot.cables[6].anchor_W = {0, 0, 0};
  const CdprMpcParams params = Holding(robot, {0.1, -0.1, 1.8});
  TestRig<CdprMpc> rig(params);
  rig.Fix(rig->estimate, At(params, 0, {0, 0, 0})).Tick();
  EXPECT_THAT(rig[rig->command], IsNear(params.path->At(0).tension, 1e-4));

  TestRig<CdprMpc> beside(params);
  const Eigen::Vector3d offset(0.1, -0.05, 0.02);
  beside.Fix(beside->estimate, At(params, 0, offset)).Tick();
  const PlatformState platform = At(params, 0, offset).platform;
  const CableKinematics cables = CalcCableKinematics(robot, platform.p_WB, platform.R_WB());
  const Eigen::Vector3d force = (cables.structure * beside[beside->command] + GravityWrench(robot)).head<3>();
  EXPECT_LT(force.dot(offset), 0);
}

TEST(CdprMpc, CommandsStayInsideTheBounds) {
  CdprDescription robot = test::FourCableRobot();
  robot.cable.tension_min = 20;
  robot.cable.tension_max = 200;
  const CdprMpcParams params = Holding(robot, {0, 0, 2});
  for (const Eigen::Vector3d& offset : {Eigen::Vector3d(1, 0, 0.5), Eigen::Vector3d(-1, 1, -1)}) {
    TestRig<CdprMpc> rig(params);
    rig.Fix(rig->estimate, At(params, 0, offset));
    double low = 1e9, high = 0;
    for (int i = 0; i < 50; ++i) {
      rig.Tick();
      low = std::min(low, rig[rig->command].minCoeff());
      high = std::max(high, rig[rig->command].maxCoeff());
      for (const CdprPlan::Node& node : rig[rig->plan].nodes) {
        ASSERT_GE(node.u.minCoeff(), 20);
        ASSERT_LE(node.u.maxCoeff(), 200);
      }
    }
    EXPECT_TRUE(low == 20 || high == 200);
    EXPECT_GE(low, 20);
    EXPECT_LE(high, 200);
  }
}

TEST(CdprMpc, FeedbackActsBetweenTheSolves) {
  const CdprMpcParams params = Holding(test::FourCableRobot(), {0, 0, 2});
  TestRig<CdprMpc> rig(params);
  rig.Fix(rig->estimate, At(params, 0, {0, 0, 0})).Tick();
  const CableVector before = rig[rig->command];
  const Eigen::Vector3d offset(0.01, 0, 0);
  PlatformEstimate moved = At(params, 0, offset);
  moved.time = 0.001;
  rig.Fix(rig->estimate, moved).Tick();
  EXPECT_EQ(rig[rig->plan].diagnostics.solves, 1);
  CentroidalState error = CentroidalState::Zero();
  error.segment<3>(6) = offset;
  EXPECT_THAT(rig[rig->command], IsNear(before + rig[rig->plan].nodes[0].K * error, 1e-3));
}

TEST(CdprMpc, ZeroInputMeansLessTension) {
  CdprMpcParams params = Holding(test::FourCableRobot(), {0, 0, 2});
  params.equilibrium_input = false;
  TestRig<CdprMpc> rig(params);
  rig.Fix(rig->estimate, At(params, 0, {0, 0, 0})).Tick();
  EXPECT_LT(rig[rig->command].sum(), params.path->At(0).tension.sum() - 1);
}

// If the platform moves exactly as planned, the tensions produce the centripetal acceleration of the circle,
// 0.2 m/s^2, by Newton's law.
TEST(CdprMpc, ReferenceAccelerates) {
  const CdprDescription robot = test::FourCableRobot();
  CdprMpcParams params = Holding(robot, {0, 0, 2});
  params.path = std::make_shared<EquilibriumPath>(robot, Path::Circle({0, 0, 2}, 0.5, 10, 1));
  CdprMpcSolver solver(params);
  const CdprMpcCost cost = CdprMpcSolver::Cost(params, params.weights, params.terminal_weights);
  CdprPlan plan = CdprMpcSolver::FirstPlan(params);
  CentroidalState x = plan.nodes[0].x;
  for (int tick = 0; tick < 500; ++tick) {
    const double time = 0.01 * tick;
    ASSERT_TRUE(solver.Solve(time, x, {}, {}, cost, plan).ok()) << time;
    const Eigen::Vector3d p = x.segment<3>(6), from_center = p - Eigen::Vector3d(0, 0, 2);
    const CableKinematics cables = CalcCableKinematics(robot, p, RotationFromEuler(x.tail<3>()));
    const Vector6d wrench = cables.structure * plan.nodes[0].u + GravityWrench(robot);
    x = plan.nodes[1].x;
    if (time < 2) continue;  // the circle is not yet at full rate, or the sway of its start still there
    const double rate = 2 * std::numbers::pi / 10;
    ASSERT_THAT(Eigen::Vector3d(wrench.head<3>() / robot.mass), IsNear(-rate * rate * from_center, 0.006))
        << time;
    const double angle = rate * (time - 0.5);  // half a ramp late
    ASSERT_THAT(from_center, IsNear(Eigen::Vector3d(0.5 * std::cos(angle), 0.5 * std::sin(angle), 0), 1e-4))
        << time;
  }
}

// The command compensates the damping of the winches at the cable rates of the reference, ahead of time by
// the time constant of the motors.
TEST(CdprMpc, LeadsTheReelDampingByTheLagOfTheMotors) {
  CdprDescription robot = test::FourCableRobot();
  robot.winch.time_constant = 0.1;
  const PathPoint moving{{0, 0, 2}, {0.3, 0, 0}, {0, 0.2, 0}};
  const auto command = [&] {
    CdprMpcParams params = Holding(robot, moving.position);
    params.path = std::make_shared<EquilibriumPath>(robot, Path::Move(moving, 0, {0.5, 0.5, 2}, 3));
    TestRig<CdprMpc> rig(params);
    rig.Fix(rig->estimate, At(params, 0, {0, 0, 0})).Tick();
    const CdprReference late = params.path->At(robot.winch.time_constant);
    EXPECT_GT((late.length_rate - params.path->At(0).length_rate).norm(), 0.01);
    return CableVector(rig[rig->command] + robot.winch.reel_damping * late.length_rate);
  };
  const CableVector damped = command();
  robot.winch.reel_damping = 0;
  EXPECT_THAT(damped, IsNear(command(), 1e-9));
}

TEST(CdprMpc, LastPolicyGoesOnWhenASolveFailsAndThenTheRunEnds) {
  CdprMpcParams params = Holding(test::FourCableRobot(), {0, 0, 2});
  params.max_fallbacks_in_a_row = 3;
  TestRig<CdprMpc> rig(params);
  rig.Fix(rig->estimate, At(params, 0, {0.1, 0, 0})).RunTo(0.005);
  const CdprPlan before = rig[rig->plan];
  PlatformEstimate broken = At(params, 0, {0.1, 0, 0});
  broken.platform.p_WB[0] = 1e200;  // its square is not finite
  rig.Fix(rig->estimate, broken).RunTo(0.01);
  const CdprPlan& after = rig[rig->plan];
  EXPECT_EQ(after.diagnostics.fallbacks, 1);
  EXPECT_EQ(after.diagnostics.solves, 2);
  EXPECT_THAT(after.nodes[0].u, IsNear(before.nodes[1].u, 1e-9));  // one period later
  const RunStatus status = rig.simulator().AdvanceTo(1);
  EXPECT_TRUE(status.ended);
  EXPECT_NEAR(status.time, 0.04, 1e-9);
  EXPECT_THAT(status.reason, ::testing::HasSubstr("4 of 5 solves"));
}

/// The equilibrium of a loaded or damaged robot, and the platform at rest in it.
struct Balanced {
  Balanced(const CdprMpcParams& params, const LoadEstimate& load, const CableVector& broken)
      : reference(params.path->robot()), estimate(At(params, 0, {0, 0, 0})) {
    ReferenceShift shift;
    for (int k = 0; k < 20; ++k) reference.Calc(params.path->At(0), load, broken, shift);
    estimate.platform.q_WB = QuaternionFromRotation(reference.R_WB());
  }
  /// Lets the controller run while the platform rests.
  void Run(TestRig<CdprMpc>& rig) {
    for (int k = 0; k < 100; ++k) {
      estimate.time = rig.Tick().time();
      rig.Fix(rig->estimate, estimate);
    }
  }
  BalancedReference reference;
  PlatformEstimate estimate;
};

// At the equilibrium with a load, the command carries platform and load.
TEST(CdprMpc, HoldsTheEstimatedLoad) {
  const CdprMpcParams params = Holding(test::FourCableRobot(), {0.3, 0.4, 2});
  const LoadEstimate load{{2, {0.02, 0.1, -0.05}}, {{3, -2, 1}, {0.1, 0, 0}}};
  Balanced balanced(params, load, {});
  TestRig<CdprMpc> rig(params);
  rig.Fix(rig->estimate, balanced.estimate).Fix(rig->load, load);
  balanced.Run(rig);
  EXPECT_THAT(rig[rig->command], IsNear(balanced.reference.tension(), 0.2));
}

// Without one of twelve cables, the command at the equilibrium carries the platform by the other cables.
TEST(CdprMpc, DoesWithoutACableThatIsBroken) {
  const CdprMpcParams params = Holding(test::TwoRingRobot(12), {0.3, 0.4, 2});
  CableVector broken = CableVector::Zero(12);
  broken[3] = 1;
  Balanced balanced(params, {}, broken);
  TestRig<CdprMpc> rig(params);
  rig.Fix(rig->estimate, balanced.estimate).Tick();
  EXPECT_GT(rig[rig->command][3], 1);
  rig.Fix(rig->broken, broken);
  balanced.Run(rig);
  EXPECT_EQ(rig[rig->command][3], 0);
  EXPECT_THAT(rig[rig->command], IsNear(balanced.reference.tension(), 0.2));
  EXPECT_EQ(AllocationsOf([&] { rig.Tick(); }), 0);
}

// Three cables hold the platform only above the triangle of their anchors. Elsewhere the run ends after
// unheld_time, counted from the first solve.
TEST(CdprMpc, GivesUpWhenTheOthersCannotHoldThePlatform) {
  CdprMpcParams params = Holding(test::FourCableRobot(), {0.8, 1, 2});
  params.unheld_time = 0.15;
  CableVector broken = CableVector::Zero(4);
  broken[0] = 1;
  TestRig<CdprMpc> rig(params);
  rig.Fix(rig->estimate, At(params, 0, {0, 0, 0})).Fix(rig->broken, broken);
  while (!rig.Tick()[rig->statics] && rig.time() < 3) EXPECT_FALSE(rig[rig->plan].shift.held);
  EXPECT_THAT(rig[rig->statics].value_or(""), testing::HasSubstr("cable 0"));
  EXPECT_NEAR(rig.time() + params.rate.period(), params.unheld_time, 1e-9);
}

// The post is 0.15 m beside the reference, of which 0.075 m are platform, and below a cable.
TEST(CdprMpc, KeepsTheDistanceFromAPost) {
  CdprDescription robot = test::FourCableRobot();
  robot.obstacles = {{{0.15, 0, 0}, {0.15, 0, 2.05}, 0}};
  CdprMpcParams params = Holding(robot, {0, 0, 2});
  params.clearance = 0.1;
  CdprMpcSolver solver(params);
  const CdprMpcCost cost = CdprMpcSolver::Cost(params, params.weights, params.terminal_weights);
  CdprPlan plan = CdprMpcSolver::FirstPlan(params);
  const auto solve = [&](double t) { return solver.Solve(t, plan.nodes[1].x, {}, {}, cost, plan).ok(); };
  for (int tick = 0; tick < 300; ++tick) ASSERT_TRUE(solve(0.01 * tick)) << tick;
  EXPECT_EQ(AllocationsOf([&] { solve(3); }), 0);
  double least = 1;
  const Vector6d pose = plan.nodes[0].x.tail<6>();
  CdprClearance(robot, 0.1, {}, {})
      .ForEach(
          pose.head<3>(), RotationFromEuler(pose.tail<3>()), [&](int i) { return robot.cables[i].anchor_W; },
          [&](int, int, const PoseDistance& distance) { least = std::min(least, distance.value); });
  EXPECT_NEAR(least, 0.1, 1e-3);
}

TEST(CdprMpc, RefusesNonsense) {
  const auto refuses = RefusesChanged<CdprMpc>(Holding(test::FourCableRobot(), {0, 0, 2}));
  EXPECT_TRUE(refuses([](auto& p) { p.path = nullptr; }, "path"));
  EXPECT_TRUE(refuses([](auto& p) { p.num_steps = 1; }, "num_steps"));
  EXPECT_TRUE(refuses([](auto& p) { p.horizon = 0.123; }, "horizon"));
  EXPECT_TRUE(refuses([](auto& p) { p.num_steps = 200; }, "horizon"));
  EXPECT_TRUE(refuses([](auto& p) { p.unheld_time = -1; }, "unheld_time"));
  const auto at_any_place = [](auto& p) { p.cable_clearance = 0.1, p.weights.position.setZero(); };
  EXPECT_TRUE(refuses(at_any_place, "weights.position"));
  EXPECT_TRUE(refuses([](auto& p) { p.weights.tension = {1, 1, 1}; }, "weights.tension"));
}

// One weight for all is the matrix R with that diagonal; a cable with a large weight keeps its tension.
TEST(CdprMpc, EveryCableHasAWeightOfItsOwn) {
  CdprMpcParams params = Holding(test::FourCableRobot(), {0, 0, 2});
  const double w = params.weights.tension[0];
  TestRig<CdprMpc> one(params), equal(params), held(params);
  params.weights.tension = {w, w, w, w};
  equal.Set(equal->weights, params.weights);
  params.weights.tension = {w, w, w, 1e6 * w};
  held.Set(held->weights, params.weights);
  for (auto* rig : {&one, &equal, &held})
    rig->Fix(rig->system().estimate, At(params, 0, {0.1, -0.05, 0.02})).Tick().RunTo(0.03);
  EXPECT_EQ(one[one->command], equal[equal->command]);
  const double rest = params.path->At(0).tension[3];
  EXPECT_GT(std::abs(one[one->command][3] - rest), 1);
  EXPECT_NEAR(held[held->command][3], rest, 0.1);
}

// The shipped MPC has no diagonal weights of the final errors.
TEST(CdprMpc, DiagonalTerminalWeightsAreSetInARun) {
  CdprMpcParams params = Holding(test::FourCableRobot(), {0, 0, 2});
  params.terminal = TerminalCost::kGiven;
  params.terminal_weights = params.weights;
  CdprMpcParams changed = params;
  changed.terminal_weights.position = {900, 900, 700};
  TestRig<CdprMpc> plain(params), set(params), built(changed);
  set.Set(set->terminal_weights, changed.terminal_weights);
  for (auto* rig : {&plain, &set, &built})
    rig->Fix(rig->system().estimate, At(params, 0, {0.1, -0.05, 0.02})).Tick().RunTo(0.03);
  EXPECT_EQ(set[set->command], built[built->command]);
  EXPECT_NE(plain[plain->command], built[built->command]);
}

// The Riccati equation is solved when weights are set, not at the next tick.
TEST(CdprMpc, WeightsWithoutACostToGoAreRefused) {
  const CdprMpcParams params = Holding(test::FourCableRobot(), {0, 0, 2});
  TestRig<CdprMpc> rig(params);
  CdprMpcWeights wrong = params.weights;
  wrong.position.setConstant(1e308);
  wrong.tension = 1e-308;
  EXPECT_TRUE(Throws<ParameterError>([&] { rig.Set(rig->weights, wrong); }, "Riccati"));
  wrong.tension = 0;
  EXPECT_TRUE(Throws<ParameterError>([&] { rig.Set(rig->weights, wrong); }, "weights.tension"));
}

}  // namespace tenon::cdpr_mpc_test
