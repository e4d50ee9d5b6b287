#include <tenon/controllers/legged/planning/centroidal_mpc.h>
#include <tenon/controllers/optimization/slq.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

#include <numbers>

namespace tenon::centroidal_mpc_test {

using test::DogBot;

constexpr GaitTiming kTrot{.num_steps = 2, .step = {0, 1, 1, 0}, .stance = 0.05, .swing = 0.2};

/// A robot at rest in its nominal stance, on its path.
class Rig {
 public:
  explicit Rig(const CentroidalMpcProperties& mpc = {})
      : rig_(CentroidalMpcParams{.robot = DogBot(), .mpc = mpc}) {
    state = test::Standing(DogBot());
    const NominalStance& stance = rig_->stance;
    state.p_WB.head<2>() = -stance.com_B.head<2>();
    body.com_W = {0, 0, stance.com_height};
  }
  /// Sets a trot, at this time after the lift-off of the front left and the rear right foot [s].
  void Trot(double time) {
    schedule.gait = Gait::kTrot;
    schedule.timing = kTrot;
    schedule.step_time = kTrot.stance + time;
    for (std::size_t i = 0; i < kNumLegs; ++i) {
      LegContact& leg = schedule.legs[i];
      const bool swings = kTrot.step[i] == 0;
      leg.state = swings ? ContactState::kSwing : ContactState::kStance;
      leg.phase = swings ? time / kTrot.swing : 0.5;
      leg.time_to_touchdown = kTrot.swing - time;
      leg.time_to_lift_off = kTrot.step_duration() + (swings ? kTrot.step_duration() : 0) - time;
    }
  }
  /// Solves, and ticks until just before the next solve.
  const CentroidalPlan& Solve() {
    auto& block = rig_.system();
    rig_.Fix(block.body, body).Fix(block.path, path).Fix(block.schedule, schedule).Fix(block.state, state);
    rig_.Fix(block.ground, GroundPlane()).Fix(block.wrench, wrench);
    for (int tick = 0; tick < 10; ++tick) rig_.Tick();
    return rig_[block.plan];
  }
  const NominalStance& stance() { return rig_->stance; }
  TestRig<CentroidalMpc>& rig() { return rig_; }

  BodyReference body;
  PlanarPath path;
  ContactSchedule schedule;
  LeggedState state;
  WrenchEstimate wrench;

 private:
  TestRig<CentroidalMpc> rig_;
};

TEST(CentroidalMpc, AtRestItStaysAtRest) {
  Rig rig;
  for (int k = 0; k < 5; ++k) rig.Solve();
  const CentroidalPlan& plan = rig.Solve();
  EXPECT_LT(plan.body.com_acceleration_W.norm(), 0.02);
  EXPECT_LT(plan.body.alpha_W.norm(), 0.05);
  EXPECT_EQ(plan.diagnostics.failures, 0);
  Vec<3> sum = Vec<3>::Zero();
  for (const Vec<3>& force : plan.force_W) sum += force;
  EXPECT_NEAR(sum[2], DogBot().mass() * kGravity, 1);
}

TEST(CentroidalMpc, BrakesAMotionOffThePath) {
  Rig rig;
  rig.state.v_W = {0, 0.3, 0};
  const CentroidalPlan& plan = rig.Solve();
  EXPECT_LT(plan.body.com_acceleration_W[1], -0.5);
  EXPECT_LT(std::abs(plan.body.com_acceleration_W[0]), 0.1);
}

// A robot that stands beside its path, as after a stop at speed, is not pulled there until it tips over its
// feet.
TEST(CentroidalMpc, StandsBesideThePath) {
  const auto pull = [](double off) {
    Rig rig;
    rig.path.position_W[1] = off;
    rig.body.com_W[1] += off;
    for (int k = 0; k < 5; ++k) rig.Solve();
    return rig.Solve().body.com_acceleration_W[1];
  };
  EXPECT_GT(pull(0.03), 0.05);
  EXPECT_GT(pull(0.06), pull(0.03));
  EXPECT_NEAR(pull(0.2), pull(0.5), 1e-3);
}

// The steady part of a wrench follows a short push hardly, and a long one entirely.
TEST(CentroidalMpc, AShortPushIsNotExpectedToLast) {
  Rig rig;
  const double weight = DogBot().mass() * kGravity;
  const auto force_after = [&](double push, int solves) {  // lateral ground force [weights]
    rig.wrench.force_W = {0, push * weight, 0};
    for (int k = 0; k < solves; ++k) rig.Solve();
    double force = 0;
    for (const Vec<3>& f : rig.Solve().force_W) force += f[1];
    return force / weight;
  };
  force_after(1.5, 10);  // its mean over 0.5 s is 0.3
  const double after_short = force_after(0, 10);
  force_after(0.3, 100);
  const double lasting = force_after(0.3, 1);
  EXPECT_LT(std::abs(after_short), 0.05);
  EXPECT_LT(lasting, -0.3);
}

// Two feet in the air: they are placed in the direction in which the robot moves off its path. The weight of
// the angular momentum keeps it from braking by a rotation of the trunk.
TEST(CentroidalMpc, FootholdsFollowAPush) {
  double last = 0;
  for (const double v : {0.0, 0.2, 0.4, 0.8}) {
    Rig rig({.weights = {.angular_momentum = 1000}});
    rig.Trot(0.02);
    rig.state.v_W = {0, v, 0};
    for (int k = 0; k < 5; ++k) rig.Solve();  // until they have converged
    const CentroidalPlan& plan = rig.Solve();
    ASSERT_TRUE(plan.footholds.planned);
    const auto& footholds = plan.footholds.position_W;
    const double off = (footholds[kFrontLeft] + footholds[kRearRight])[1] / 2;
    if (v == 0) {
      EXPECT_LT(std::abs(off), 2e-3);
    } else {
      EXPECT_GT(off, last + 0.02) << v;
    }
    last = off;
  }
}

// Both swinging feet follow a motion to the left. The right one may not come closer to the middle than
// least_width allows.
TEST(CentroidalMpc, FeetStayOnTheirSide) {
  const auto distance = [](double least_width) {
    Rig rig({.weights = {.angular_momentum = 1000}, .least_width = least_width});
    rig.Trot(0.02);
    rig.state.v_W = {0, 0.8, 0};
    for (int k = 0; k < 4; ++k) rig.Solve();
    const auto& footholds = rig.Solve().footholds.position_W;
    return footholds[kFrontLeft][1] - footholds[kRearRight][1];
  };
  EXPECT_GT(distance(1), distance(0.3) + 0.01);
}

TEST(CentroidalMpc, LateInTheSwingTheFootholdIsKept) {
  Rig rig;
  rig.Trot(0.13);
  const FootholdPlan before = rig.Solve().footholds;
  rig.Trot(0.15);
  rig.state.v_W = {0, 0.5, 0};
  const FootholdPlan after = rig.Solve().footholds;
  EXPECT_EQ(before.position_W[kFrontLeft], after.position_W[kFrontLeft]);
  rig.Trot(0.135);
  const FootholdPlan earlier = rig.Solve().footholds;
  EXPECT_GT((before.position_W[kFrontLeft] - earlier.position_W[kFrontLeft]).norm(), 0.005);
}

// Forces lie in the friction cone, and along each edge of the pyramid in it they are at most edge_force.
TEST(CentroidalMpc, ForcesAreWithinTheConeAndTheirLimit) {
  for (const double v : {0.5, 2.0, 5.0}) {
    Rig rig({.edge_force = 0.2});
    rig.state.v_W = {v, v / 2, -1};
    const CentroidalPlan& plan = rig.Solve();
    const double most = 4 * 0.2 * DogBot().mass() * kGravity;
    for (const Vec<3>& force : plan.force_W) {
      EXPECT_LE(force.head<2>().norm(), 0.6 * force[2] + 1e-9) << v;
      EXPECT_LE(force[2], most + 1e-9) << v;
    }
  }
}

// A push that the plan knows accelerates the robot, as the whole-body controller compensates it in the
// torques.
TEST(CentroidalMpc, TheForecastCounts) {
  for (const WrenchForecast forecast : {WrenchForecast::kNone, WrenchForecast::kHeld}) {
    Rig rig({.forecast = forecast});
    rig.wrench.force_W = {0, 30, 0};
    const CentroidalPlan& plan = rig.Solve();
    double force = 0;
    for (const Vec<3>& f : plan.force_W) force += f[1];
    if (forecast == WrenchForecast::kNone) {
      EXPECT_NEAR(force, 0, 0.1);
    } else {
      EXPECT_LT(force, -30);  // it also leans against the push
    }
  }
}

// At the zero of a sinusoid the plan already leans against its next half, to the left or to the right.
TEST(CentroidalMpc, ASinusoidIsExtrapolated) {
  const auto force_at_zero = [](WrenchForecast forecast, double phase) {
    Rig rig({.forecast = forecast});
    double force = 0;
    for (int n = 0; n <= 800; ++n) {  // of 1 Hz, at 100 Hz
      rig.wrench.force_W = {0, 20 * std::sin(2 * std::numbers::pi * n / 100.0 + phase), 0};
      const CentroidalPlan& plan = rig.Solve();
      force = 0;
      for (const Vec<3>& f : plan.force_W) force += f[1];
    }
    return force;
  };
  const double rising = force_at_zero(WrenchForecast::kSinusoid, 0);
  const double falling = force_at_zero(WrenchForecast::kSinusoid, std::numbers::pi);
  EXPECT_LT(rising, -5);
  EXPECT_GT(falling, 5);
  EXPECT_NEAR(force_at_zero(WrenchForecast::kHeld, 0), 0, -rising / 3);
}

TEST(CentroidalMpc, BetweenSolvesTheReferenceFollowsThePlan) {
  Rig rig;
  rig.state.v_W = {0.2, 0, 0};
  rig.Solve();
  auto& block = rig.rig().system();
  const BodyReference start = rig.rig()[block.plan].body, now = rig.rig()[block.reference];  // 9 ms later
  const double t = 0.009;
  EXPECT_LT((now.com_acceleration_W - start.com_acceleration_W).norm(), 1e-12);
  EXPECT_LT((now.com_velocity_W - start.com_velocity_W - t * start.com_acceleration_W).norm(), 1e-12);
  EXPECT_LT((now.w_W - start.w_W - t * start.alpha_W).norm(), 1e-12);
  EXPECT_NEAR(now.com_W[0], start.com_W[0] + 0.2 * t, 2e-4);
}

TEST(CentroidalMpc, RefusesParametersThatMakeNoSense) {
  const auto refuses = [](CentroidalMpcParams params, const char* key) {
    params.robot = DogBot();
    return Throws<ParameterError>([&] { TestRig<CentroidalMpc> rig(params); }, "'block'", key);
  };
  EXPECT_TRUE(refuses({.mpc = {.step = 0.025}}, "step"));
  EXPECT_TRUE(refuses({.mpc = {.num_steps = 1}}, "num_steps"));
  EXPECT_TRUE(refuses({.friction = 0}, "friction"));
  EXPECT_TRUE(refuses({.gravity = 0}, "gravity"));
}

using Problem = CentroidalWalkProblem;

/// Two feet on the ground, one that lands and one in the air, at a step with a load and a turn.
Problem SomeStep() {
  Problem problem(1);
  Problem::Node& node = problem.nodes[0];
  node.stands = {1, 0, 0, 0.4};
  node.lands = {false, true, false, false};
  node.nominal = {Eigen::Vector2d(0.5, 0.3), Eigen::Vector2d(0.5, -0.3), Eigen::Vector2d(-0.5, 0.3),
                  Eigen::Vector2d(-0.5, -0.3)};
  node.height = {0, 0.02, 0, 0.1};
  node.load << 0.1, -0.2, 0.05, 0.02, 0.01, -0.03;
  node.inverse_inertia = Eigen::Vector3d(12, 5, 4).asDiagonal();
  node.inverse_inertia(0, 1) = node.inverse_inertia(1, 0) = 0.7;
  node.heading = Eigen::Rotation2Dd(0.3).toRotationMatrix();
  node.turn << 0, 0, 0.2;
  problem.edges << 0.5, -0.5, 0, 0, 0, 0, 0.5, -0.5, 1, 1, 1, 1;
  return problem;
}
Problem::State SomeState() {
  Problem::State x;
  x << 0.01, -0.02, 1.03, 0.3, -0.1, 0.05, 0.1, -0.05, 0.02, 0.01, 0.03, -0.02, 0.4, 0.3, 0.5, -0.3, -0.5,
      0.2, -0.4, -0.3;
  return x;
}
Problem::Input SomeInput() {
  Problem::Input u;
  u << 0.1, 0.2, 0.15, 0.05, 0.04, -0.02, 0, 0, 0, 0, 0, 0, 0.3, 0.1, 0.05, 0.2;
  return u;
}

// One step against 1000 short ones. The acceleration a = F - e_z displaces the CoM within the step, whose
// moment T^3/6 a x F is neglected.
TEST(CentroidalWalkProblem, StepsAreThoseOfARigidBody) {
  Problem problem = SomeStep();
  problem.nodes[0].load.setZero();
  problem.nodes[0].inverse_inertia.setZero();
  const Problem::State x = SomeState();
  const Problem::Input u = SomeInput();
  Problem::State next, fine = x;
  const double T = 0.2;
  problem.Step(0, StepMethod::kMidpoint, T, x, u, next);
  problem.nodes[0].lands[1] = false;
  for (int k = 0; k < 1000; ++k) {
    Problem::State after;
    problem.Step(0, StepMethod::kMidpoint, T / 1000, fine, u, after);
    fine = after;
  }
  EXPECT_LT((next.head<6>() - fine.head<6>()).cwiseAbs().maxCoeff(), 1e-12);
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (const int leg : {0, 3}) force += problem.Force(0, leg, u);
  const Eigen::Vector3d neglected = T * T * T / 6 * Eigen::Vector3d::UnitZ().cross(force);
  EXPECT_LT((next.segment<3>(9) - fine.segment<3>(9) + neglected).norm(), 1e-6);
}

// A load and a landing: the load accelerates CoM and trunk, the foot lands below the CoM of the next node.
TEST(CentroidalWalkProblem, LoadsAndLandings) {
  const Problem problem = SomeStep();
  const Problem::Node& node = problem.nodes[0];
  const Problem::State x = SomeState();
  Problem::Input u = Problem::Input::Zero();
  u.segment<2>(4) << 0.04, -0.02;
  Problem::State next;
  const double T = 0.1;
  problem.Step(0, StepMethod::kMidpoint, T, x, u, next);
  const Eigen::Vector3d a(0.1, -0.2, 0.05 - 1), L = x.segment<3>(9), tau = node.load.tail<3>();
  const Eigen::Vector3d turned = node.inverse_inertia * (L + T / 2 * tau) - Eigen::Vector3d(0, 0, 0.2);
  EXPECT_LT((next.segment<3>(3) - x.segment<3>(3) - T * a).norm(), 1e-15);
  EXPECT_LT((next.segment<3>(9) - L - T * tau).norm(), 1e-15);
  EXPECT_LT((next.segment<3>(6) - x.segment<3>(6) - T * turned).norm(), 1e-15);
  const Eigen::Vector2d landing = x.head<2>() + T * x.segment<2>(3) + Eigen::Vector2d(0.5, -0.3) +
                                  Eigen::Rotation2Dd(0.3) * Eigen::Vector2d(0.04, -0.02);
  EXPECT_LT((next.segment<2>(14) - landing).norm(), 1e-15);
}

// The costs are quadratic, so gradients and Hessians give differences exactly up to rounding.
TEST(CentroidalWalkProblem, GradientsAreThoseOfTheCosts) {
  Problem problem = SomeStep();
  problem.Q = Problem::State::LinSpaced(0.1, 2);
  problem.Q_f = Problem::State::LinSpaced(3, 1);
  problem.final_divergence = 0.7;
  problem.nodes[0].R = Problem::Input::LinSpaced(0.2, 1);
  problem.nodes[1].x.setConstant(0.05);
  const Problem::State x = SomeState();
  const Problem::Input u = SomeInput();
  Problem::State gx = Problem::State::Zero(), gf = gx;
  Problem::Input gu = Problem::Input::Zero();
  Problem::StateMatrix Hxx = Problem::StateMatrix::Zero(), Hf = Hxx;
  Problem::InputMatrix Huu = Problem::InputMatrix::Zero();
  problem.AddStageCost(0, x, u, 1, gx, gu, Hxx, Huu);
  problem.AddTerminalCost(x, gf, Hf);
  const Problem::State dx = Problem::State::LinSpaced(-0.3, 0.5);
  const Problem::Input du = Problem::Input::LinSpaced(0.4, -0.2);
  EXPECT_NEAR(problem.StageCost(0, x + dx, u + du) - problem.StageCost(0, x, u),
              gx.dot(dx) + gu.dot(du) + dx.dot(Hxx * dx) / 2 + du.dot(Huu * du) / 2, 1e-12);
  EXPECT_NEAR(problem.TerminalCost(x + dx) - problem.TerminalCost(x), gf.dot(dx) + dx.dot(Hf * dx) / 2,
              1e-12);
}

TEST(CentroidalWalkProblem, DerivativesAreThoseOfDifferences) {
  const Problem problem = SomeStep();
  const Problem::State x = SomeState();
  const Problem::Input u = SomeInput();
  Problem::StepWorkspace workspace(16);
  Problem::Tangent tangent;
  const double T = 0.15;
  problem.LinearizeSteps(StepMethod::kMidpoint, 1, &T, &x, &u, &tangent, workspace);
  for (int j = 0; j < Problem::kStates + Problem::kInputs; ++j) {
    const double h = 1e-6;
    Problem::State x_plus = x, x_minus = x, plus, minus;
    Problem::Input u_plus = u, u_minus = u;
    (j < Problem::kStates ? x_plus[j] : u_plus[j - Problem::kStates]) += h;
    (j < Problem::kStates ? x_minus[j] : u_minus[j - Problem::kStates]) -= h;
    problem.Step(0, StepMethod::kMidpoint, T, x_plus, u_plus, plus);
    problem.Step(0, StepMethod::kMidpoint, T, x_minus, u_minus, minus);
    EXPECT_LT((tangent.col(j) - (plus - minus) / (2 * h)).cwiseAbs().maxCoeff(), 1e-9) << j;
  }
}

}  // namespace tenon::centroidal_mpc_test
