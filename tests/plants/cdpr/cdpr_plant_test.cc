#include <tenon/plants/signals/euler.h>
#include <tenon/tests/plants/cdpr/cdpr_plant_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

namespace tenon::cdpr_plant_test {

using test::FourCableRobot, test::Hanging, test::RandomPlatform;
using Rig = TestRig<CdprPlant>;

CableVector Same(double value, int n = 4) {
  return CableVector::Constant(n, value);
}

CdprPlantParams Locked(CdprPlantParams params) {
  params.lock_winches = true;
  return params;
}

/// The rest lengths of all cables.
void SetRestLength(Rig& rig, double rest_length) {
  rig.Set(rig->rest_length, Eigen::VectorXd::Constant(rig->params.robot.num_cables(), rest_length));
}

double Total(Rig& rig) {
  return rig[rig->energy].total();
}

TEST(CdprPlantTest, LengthRatesAreDerivativesOfLengths) {
  RandomStream random(5);
  CdprDescription robot = test::FourCableRobot();
  robot.winch.pulleys_on_platform = true;
  robot.cables[1].pulley_radius = 0.1;
  Rig rig(Hanging(robot));
  const double h = 1e-6;
  for (int i = 0; i < 10; ++i) {
    const PlatformState x = RandomPlatform(random);
    rig.Set(rig->platform_state, x);
    const CableVector rate = rig[rig->cables].length_rate;
    CableVector length[2];
    for (const int side : {0, 1}) {
      const double dt = side == 0 ? -h : h;
      PlatformState moved = x;
      moved.p_WB += dt * x.v_W;
      moved.q_WB = QuaternionProduct(QuaternionFromRotationVector(dt * x.w_W), x.q_WB);
      rig.Set(rig->platform_state, moved);
      length[side] = rig[rig->cables].length;
    }
    EXPECT_THAT(rate, IsNear((length[1] - length[0]) / (2 * h), 1e-8));
  }
}

/// The acceleration of a free rigid body on which the cables' tensions, a payload and a wrench act.
PlatformAcceleration UnderItsCables(const CdprDescription& robot, const PlatformState& x,
                                    const CableVector& tension, const Payload& payload,
                                    PlatformWrench wrench) {
  for (int i = 0; i < robot.num_cables(); ++i) {
    const CableDescription& cable = robot.cables[i];
    const Vec<3> arm = x.R_WB() * cable.attachment_B;
    const Vec<3> pull = tension[i] * (cable.anchor_W - x.p_WB - arm).normalized();
    wrench.force_W += pull;
    wrench.torque_W += arm.cross(pull);
  }
  FreeRigidBody body(robot.mass, robot.inertia_B);
  body.Calc(x, wrench, payload, 9.81);
  return body.acceleration();
}

class CdprPlantOfRobots : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Cables, CdprPlantOfRobots, ::testing::Values(4, 12),
                         ::testing::PrintToStringParamName());

TEST_P(CdprPlantOfRobots, IsAFreeRigidBodyUnderItsCables) {
  RandomStream random(6);
  Rig rig(Hanging(test::RobotWithCables(GetParam())));
  const double rest_length = 1.02 * rig[rig->rest_length][0];
  double largest = 0;
  for (int i = 0; i < 50; ++i) {
    const PlatformState x = RandomPlatform(random);
    const Payload payload{i % 2 == 0 ? 0 : random.Uniform(0, 20), test::RandomVector(random, 0.5)};
    const PlatformWrench wrench{test::RandomVector(random, 50), test::RandomVector(random, 5)};
    rig.Set(rig->platform_state, x).Fix(rig->payload, payload).Fix(rig->wrench, wrench);
    SetRestLength(rig, rest_length);
    const PlatformAcceleration expected =
        UnderItsCables(rig->params.robot, x, rig[rig->cables].tension, payload, wrench);
    const double size = 1 + expected.a_W.norm() + expected.alpha_W.norm();
    EXPECT_THAT(rig[rig->acceleration].a_W, IsNear(expected.a_W, 1e-10 * size));
    EXPECT_THAT(rig[rig->acceleration].alpha_W, IsNear(expected.alpha_W, 1e-10 * size));
    const PlatformState& rate = rig[rig->platform_rate];
    EXPECT_EQ(rate.p_WB, x.v_W);
    EXPECT_EQ(rate.v_W, rig[rig->acceleration].a_W);
    EXPECT_EQ(rate.w_W, rig[rig->acceleration].alpha_W);
    largest = std::max(largest, rig[rig->cables].tension.maxCoeff());
  }
  EXPECT_GT(largest, 100);  // cables took part
}

// In the frame of anchors that move together, at any velocity, forces and cables are those of standing
// anchors.
TEST(CdprPlantTest, AnchorsThatMoveTogetherAreAMovingFrame) {
  const AnchorPath path{{0.1, 0.9}, {{0, 0, 0}, {0.8, -0.5, 0.3}}};
  for (const CdprDescription& robot :
       {FourCableRobot(), FourCableRobot(0.05), FourCableRobot(0, 0.05), FourCableRobot(0.05, 0.05)}) {
    Rig still(Hanging(robot)), moves(Hanging(test::WithAnchorsOn(robot, path)));
    const Eigen::VectorXd rest_length = still[still->rest_length];
    RandomStream random(9);
    for (const double time : {0.05, 0.3, 0.5, 0.7, 1.2}) {
      moves.Fix(moves->command, Same(100)).RunTo(time);
      const PathPoint frame = moves->anchors.At(2, time);
      PlatformState x = RandomPlatform(random);
      still.Set(still->platform_state, x).Set(still->rest_length, rest_length);
      x.p_WB += frame.position;
      x.v_W += frame.velocity;
      moves.Set(moves->platform_state, x)
          .Set(moves->rest_length, rest_length)
          .Set(moves->motor_tension, still[still->motor_tension]);
      const CableSignals &expected = still[still->cables], &cables = moves[moves->cables];
      EXPECT_THAT(cables.length, IsNear(expected.length, 1e-12));
      EXPECT_THAT(cables.length_rate, IsNear(expected.length_rate, 1e-12));
      EXPECT_THAT(cables.tension, IsNear(expected.tension, 1e-8));
      EXPECT_THAT(moves[moves->acceleration].a_W, IsNear(still[still->acceleration].a_W, 1e-8));
      EXPECT_THAT(moves[moves->acceleration].alpha_W, IsNear(still[still->acceleration].alpha_W, 1e-6));
      EXPECT_THAT(moves[moves->rest_length_rate], IsNear(still[still->rest_length_rate], 1e-9));
      const double lift = frame.position[2];
      EXPECT_NEAR(moves[moves->energy].potential - still[still->energy].potential,
                  9.81 * lift * (robot.mass + robot.cable.mass_per_length * rest_length.sum()), 1e-9);
      const auto &drawn = moves[moves->geometry], &before = still[still->geometry];
      for (std::size_t i = 0; i < drawn.size(); ++i) {
        if (drawn[i].role == ShapeRole::kFixture && !drawn[i].name.starts_with("post"))
          EXPECT_THAT(drawn[i].p_W - before[i].p_W, IsNear(frame.position, 1e-12)) << drawn[i].name;
      }
    }
  }
}

// Without damping and with locked winches, the energy grows by the work of the anchors, and the momentum by
// the impulse of cables and weight.
TEST(CdprPlantTest, AnchorsDoTheWorkThatTheEnergyGainsAndNoOther) {
  CdprDescription robot = test::WithMovingAnchors(FourCableRobot());
  robot.cable.axial_damping = 0;
  Rig rig(Locked(Hanging(robot)));
  rig.Fix(rig->command, Same(0));
  const double before = Total(rig), h = 2.5e-4;
  Vec<3> impulse = Vec<3>::Zero();
  double work = 0, largest = 0;
  const int intervals = 4800;
  for (int k = 0; k <= intervals; ++k) {
    if (k > 0) rig.RunTo(k * h);
    const PlatformState& x = rig[rig->platform];
    const double weight = (k == 0 || k == intervals ? 1 : k % 2 == 1 ? 4 : 2) * h / 3;  // Simpson's rule
    for (int i = 0; i < 4; ++i) {
      const PathPoint moved = rig->anchors.At(i, k * h);
      const CableDescription& cable = robot.cables[i];
      const Vec<3> pull =
          rig[rig->cables].tension[i] *
          (cable.anchor_W + moved.position - x.p_WB - x.R_WB() * cable.attachment_B).normalized();
      work += weight * pull.dot(moved.velocity);
      impulse += weight * pull;
    }
    impulse[2] -= weight * 9.81 * robot.mass;
    largest = std::max(largest, std::abs(work));
  }
  EXPECT_NEAR(Total(rig) - before, work, 1e-5);
  // Tensions have kinks where cables become slack, so that the quadrature errs by O(h^2).
  EXPECT_THAT(robot.mass * rig[rig->platform].v_W, IsNear(impulse, 3e-5));
  EXPECT_GT(largest, 5);  // J
}

TEST(CdprPlantTest, ATumblingBodyKeepsEnergyAndAngularMomentum) {
  for (const double gravity : {0.0, 9.81}) {
    CdprPlantParams params = Locked(Hanging());
    params.gravity = gravity;
    params.w_W = {3, 0.1, -2};
    params.v_W = {0.5, 0, 4};
    Rig rig(params);
    rig.Fix(rig->command, Same(0));
    SetRestLength(rig, 1000);
    const auto momentum = [&]() -> Vec<3> {
      const PlatformState& x = rig[rig->platform];
      return x.R_WB() * params.robot.inertia_B * x.R_WB().transpose() * x.w_W;
    };
    const Vec<3> momentum_before = momentum();
    const double energy_before = Total(rig);
    rig.RunTo(5);
    EXPECT_THAT(momentum(), IsNear(momentum_before, 1e-8));
    EXPECT_NEAR(Total(rig), energy_before, 1e-8 * (1 + std::abs(energy_before)));
    EXPECT_NEAR(rig[rig->platform_state].q_WB.norm(), 1, 1e-8);
  }
}

TEST_P(CdprPlantOfRobots, UndampedCablesAndSpringsKeepEnergy) {
  CdprDescription robot = test::WithSprings(test::RobotWithCables(GetParam()));
  robot.cable.axial_damping = 0;
  for (const double payload : {0.0, 5.0}) {
    CdprPlantParams params = Locked(Hanging(robot));
    params.v_W = {0.3, 0.2, 0};
    params.w_W = {0.2, -0.3, 0.1};
    Rig rig(params);
    rig.Fix(rig->command, Same(0, GetParam()));
    rig.Fix(rig->payload, Payload{payload, {0.1, 0, -0.2}});
    const double before = Total(rig);
    EXPECT_GT(rig[rig->energy].elastic, 0);
    rig.RunTo(3);
    EXPECT_NEAR(Total(rig), before, 1e-6);
    EXPECT_GT((rig[rig->platform].p_WB - params.p_WB).norm(), 0.001);  // it did move
  }
}

// With broken cables, a platform hangs on a spring: z = z0 - h cos(sqrt(k / m) t), 1 m below its anchor plus
// m g / k at rest; with Simbody's dynamics, too.
TEST(CdprPlantTest, OscillatesOnASpring) {
  constexpr double k = 600, h = 0.05;
  for (const bool simbody : {false, true}) {
    CdprPlantParams params = Hanging();
    params.robot.springs = {{{0, 0, 4}, {0, 0, 0}, k, 1}};
    const double rest = 4 - 1 - params.robot.mass * params.gravity / k;
    params.p_WB = {0, 0, rest - h};
    if (simbody) params.extend = [](CdprMultibody&) {};
    Rig rig(params);
    rig.Fix(rig->command, Same(0)).Fix(rig->faults, CableFaults{.stuck = {}, .broken = Same(1)});
    for (const double t : {0.1, 0.25, 0.6}) {
      rig.RunTo(t);
      EXPECT_THAT(rig[rig->platform].p_WB,
                  IsNear(Vec<3>(0, 0, rest - h * std::cos(std::sqrt(k / params.robot.mass) * t)), 1e-6));
    }
  }
}

TEST(CdprPlantTest, StaysAtItsEquilibrium) {
  for (const bool locked : {false, true}) {
    for (const WinchMode mode : {WinchMode::kTension, WinchMode::kTorque}) {
      CdprPlantParams params = Hanging();
      params.robot.winch.mode = mode;
      params.lock_winches = locked;
      Rig rig(params);
      rig.Fix(rig->command, params.initial_tension);
      EXPECT_THAT(rig[rig->cables].tension, IsNear(params.initial_tension, 1e-9));
      EXPECT_LT(rig.context().EvalTimeDerivatives().norm(), 1e-11);
      rig.RunTo(3);
      EXPECT_THAT(rig[rig->platform].p_WB, IsNear(params.p_WB, 1e-7));
      EXPECT_THAT(rig[rig->euler], IsNear(Vec<3>(0, 0, 0), 1e-7));
    }
  }
}

TEST(CdprPlantTest, TheLengthOfTheQuaternionMeansNothingAndReturnsToOne) {
  RandomStream random(7);
  const PlatformState x = RandomPlatform(random);
  PlatformState scaled = x;
  scaled.q_WB *= 1.3;
  Rig rig(Locked(Hanging()));
  rig.Fix(rig->command, Same(0)).Set(rig->platform_state, x);
  SetRestLength(rig, 100);
  const PlatformState before = rig[rig->platform_rate];
  rig.Set(rig->platform_state, scaled);
  EXPECT_THAT(rig[rig->platform].q_WB, IsNear(x.q_WB, 1e-15));
  EXPECT_THAT(rig[rig->platform_rate].w_W, IsNear(before.w_W, 1e-12));
  rig.RunTo(2);
  EXPECT_NEAR(rig[rig->platform_state].q_WB.norm(), 1, 1e-6);
}

TEST(CdprPlantTest, StartsInItsInitialState) {
  CdprPlantParams params = Hanging();
  params.p_WB = {0.3, -0.4, 1.2};
  params.euler = {0.1, -0.2, 0.7};
  params.v_W = {1, 2, 3};
  params.w_W = {-1, -2, -3};
  params.initial_tension << 40, 50, 60, 0;
  params.lock_winches = true;
  Rig rig(params);
  const PlatformState& x = rig[rig->platform];
  EXPECT_EQ(x.p_WB, params.p_WB);
  EXPECT_EQ(x.v_W, params.v_W);
  EXPECT_EQ(x.w_W, params.w_W);
  EXPECT_THAT(x.R_WB(), IsNear(RotationFromEuler(params.euler), 1e-15));
  EXPECT_THAT(rig[rig->euler], IsNear(params.euler, 1e-14));
  const CableSignals cables = rig[rig->cables];
  EXPECT_THAT(CableVector(27e3 * (cables.length.array() / cables.rest_length.array() - 1)),
              IsNear(params.initial_tension, 1e-9));
  EXPECT_THAT(rig[rig->motor_tension], IsNear(params.initial_tension, 0));
}

TEST(CdprPlantTest, APayloadIsHungAndReleased) {
  // Below the CoM in the middle: all stays symmetric. Hung at rest, the platform sinks until the cables carry
  // it; released there, it starts upwards with the payload's weight over its mass.
  CdprDescription robot = FourCableRobot();
  robot.cable.axial_damping = 2000;
  const CdprPlantParams params = Locked(Hanging(robot));
  DiagramBuilder builder;
  auto& plant = builder.Add<CdprPlant>("plant", params);
  auto& payload = builder.AddFunction("payload", Sampled{Hz(10)}, Uses(builder.time), [](double t) {
    return t > 0.45 && t < 8.95 ? Payload{5, {0, 0, -0.2}} : Payload{};
  });
  auto& command = builder.AddFunction("command", Uses(builder.time), [](double) { return Same(0); });
  builder.Connect(payload, plant.payload);
  builder.Connect(command, plant.command);
  auto diagram = builder.Build();
  Simulator simulator(*diagram, {.order = 5, .rtol = 1e-9, .atol = 1e-11});
  Context& context = simulator.context();

  simulator.RunTo(0.4);
  EXPECT_NEAR(context.Eval(plant.acceleration).a_W[2], 0, 1e-9);
  simulator.RunTo(0.5);  // the tick has hung it: only the added weight pulls, on both masses
  EXPECT_NEAR(context.Eval(plant.acceleration).a_W[2], -9.81 * 5 / 20, 1e-9);
  simulator.RunTo(8.9);
  const PlatformState low = context.Eval(plant.platform);
  EXPECT_LT(low.p_WB[2], 1.499);
  EXPECT_NEAR(low.v_W.norm(), 0, 1e-8);
  const double vertical = context.Eval(plant.cables).tension.sum() * (4 - 0.093 - low.p_WB[2]) /
                          context.Eval(plant.cables).length[0];
  EXPECT_NEAR(vertical, 20 * 9.81, 1e-6);
  simulator.RunTo(9);
  EXPECT_NEAR(context.Eval(plant.acceleration).a_W[2], 9.81 * 5 / 15, 1e-6);
  EXPECT_NEAR((context.Eval(plant.platform).v_W - low.v_W).norm(), 0, 1e-7);
}

TEST(CdprPlantTest, APayloadLeavesTheVelocityAsItIs) {
  CdprPlantParams params = Hanging();
  params.v_W = {1, 0, 0};
  params.w_W = {0, 0, 2};
  Rig rig(params);
  rig.Fix(rig->command, Same(0));
  const double bare = rig[rig->energy].kinetic;
  rig.Fix(rig->payload, Payload{2, {0, 0.5, 0}});  // its point rests: v - w y = 1 - 2 * 0.5
  EXPECT_EQ(rig[rig->platform].v_W, params.v_W);
  EXPECT_NEAR(rig[rig->energy].kinetic, bare, 1e-14);
  EXPECT_NEAR(rig[rig->energy].potential, 17 * 9.81 * 1.5, 1e-12);
}

TEST(CdprPlantTest, MotorsFollowTheCommandWithALag) {
  Rig rig(Hanging());
  const double start = rig[rig->motor_tension][0];
  CableVector command(4);
  command << 100, 0, -50, start;
  rig.Fix(rig->command, command).RunTo(0.03);
  const double left = std::exp(-0.03 / 0.02);
  Eigen::Vector4d expected;
  expected << 100 + (start - 100) * left, start * left, start * left, start;  // below 0 counts as 0
  EXPECT_THAT(rig[rig->motor_tension], IsNear(expected, 1e-7));
}

TEST(CdprPlantTest, InTensionModeDrumAndCableAgree) {
  const CdprPlantParams params = Hanging();
  Rig rig(params);
  RandomStream random(8);
  int pulling = 0, idle = 0, slack = 0;
  for (int i = 0; i < 50; ++i) {
    PlatformState x = RandomPlatform(random);
    x.p_WB = {0, 0, 1.5 + random.Uniform(-0.01, 0.01)};
    x.q_WB = {1, 0, 0, 0};
    Eigen::VectorXd rest_length(4), motor_tension(4);
    for (int c = 0; c < 4; ++c) {
      rest_length[c] = random.Uniform(6.07, 6.11);
      motor_tension[c] = random.Uniform(0, 200);
    }
    rig.Set(rig->platform_state, x).Set(rig->rest_length, rest_length);
    rig.Set(rig->motor_tension, motor_tension).Fix(rig->command, Same(0));
    const CableSignals cables = rig[rig->cables];
    const Eigen::VectorXd rest_rate = rig.Derivative(rig->rest_length);
    for (int c = 0; c < 4; ++c) {
      const double rest = rest_length[c];
      EXPECT_NEAR(rest_rate[c], (cables.tension[c] - motor_tension[c]) / 90, 1e-12);
      const double law =
          (27e3 * (cables.length[c] - rest) + 135 * (cables.length_rate[c] - rest_rate[c])) / rest;
      EXPECT_NEAR(cables.tension[c], cables.length[c] > rest ? std::max(0.0, law) : 0, 1e-9);
      ++(cables.length[c] <= rest ? slack : cables.tension[c] > 0 ? pulling : idle);
    }
  }
  EXPECT_GT(pulling, 20);
  EXPECT_GT(idle, 2);
  EXPECT_GT(slack, 20);
}

TEST(CdprPlantTest, InTorqueModeTheDrumIsAMass) {
  CdprPlantParams params = Hanging();
  params.robot.winch = {
      .mode = WinchMode::kTorque, .time_constant = 0.02, .reel_damping = 30, .effective_mass = 8};
  Rig rig(params);
  const double pull = params.initial_tension[0];
  rig.Fix(rig->command, params.initial_tension);
  SetRestLength(rig, 20);
  rig.RunTo(0.4);  // slack all the way: m v' = -T_m - b v
  const double fade = std::exp(-30.0 / 8 * 0.4);
  EXPECT_THAT(rig[rig->reel_speed], IsNear(Same(-pull / 30 * (1 - fade)), 1e-9));
  EXPECT_THAT(rig[rig->rest_length], IsNear(Same(20 - pull / 30 * (0.4 - 8.0 / 30 * (1 - fade))), 1e-9));
}

TEST(CdprPlantTest, InTorqueModeTheReelSpeedDampsTheCable) {
  CdprPlantParams params = Hanging();
  params.robot.winch.mode = WinchMode::kTorque;
  Rig rig(params);
  rig.Fix(rig->command, params.initial_tension);
  rig.Set(rig->reel_speed, Eigen::Vector4d(0, -0.2, 0, 0));
  const double extra = 135 * 0.2 / rig[rig->rest_length][1];
  EXPECT_NEAR(rig[rig->cables].tension[1], params.initial_tension[1] + extra, 1e-9);
  EXPECT_NEAR(rig.Derivative(rig->reel_speed)[1], (extra + 90 * 0.2) / 8, 1e-9);
  EXPECT_EQ(rig.Derivative(rig->rest_length)[1], -0.2);
}

TEST(CdprPlantTest, LockedWinchesHoldTheirRestLength) {
  CdprPlantParams params = Locked(Hanging());
  params.v_W = {0, 0, 0.5};
  Rig rig(params);
  const Eigen::VectorXd before = rig[rig->rest_length];
  rig.Fix(rig->command, Same(500)).RunTo(0.5);
  EXPECT_EQ(rig[rig->rest_length], before);
}

TEST(CdprPlantTest, HasOneEntryPerCable) {
  Rig rig(Hanging(test::TwoRingRobot(12)));
  rig.Fix(rig->command, Same(10, 12));
  EXPECT_EQ(rig[rig->cables].length.size(), 12);
  EXPECT_EQ(rig->cables.elements().size(), 48);
  EXPECT_EQ(rig.diagram().num_continuous_states(), 13 + 36);
  EXPECT_EQ(rig.diagram().ContinuousStateNames()[2], "block.platform_state.p_WB.z");
  EXPECT_EQ(rig.diagram().ContinuousStateNames()[13 + 23], "block.motor_tension.11");
  rig.RunTo(0.01);
}

TEST(CdprPlantTest, LengthsAtTheStartAreThoseOfHoming) {
  CdprPlantParams params = Hanging();
  params.homed_length = Same(7);
  Rig rig(params);
  const CableSignals& cables = rig[rig->cables];
  EXPECT_THAT(cables.length, IsNear(Same(7), 1e-14));
  // The rest lengths are shifted by as much, so that length and rest length still give the strain.
  Rig true_rig(Hanging());
  const CableSignals& truth = true_rig[true_rig->cables];
  EXPECT_THAT(CableVector(cables.length - cables.rest_length),
              IsNear(truth.length - truth.rest_length, 1e-13));
}

TEST(CdprPlantTest, RefusesParametersThatMakeNoSense) {
  const auto refuses = RefusesChanged<CdprPlant>(Hanging());
  EXPECT_TRUE(Refuses<CdprPlant>({}, "mass"));
  EXPECT_TRUE(refuses([](auto& p) { p.initial_tension = Same(60, 3); }, "initial_tension", "four"));
  EXPECT_TRUE(refuses([](auto& p) { p.initial_tension[2] = -1; }, "initial_tension", "cable 2"));
  EXPECT_TRUE(refuses([](auto& p) { p.homed_length = Same(5, 3); }, "homed_length", "four"));
  EXPECT_TRUE(refuses([](auto& p) { p.p_WB[1] = NAN; }, "p_WB"));
  EXPECT_TRUE(refuses([](auto& p) { p.gravity = INFINITY; }, "gravity"));
  EXPECT_TRUE(refuses([](auto& p) { p.p_WB = p.robot.cables[1].anchor_W - p.robot.cables[1].attachment_B; },
                      "cable 1", "p_WB"));
}

TEST(CdprPlantTest, ImpossibleSignalsAndStatesEndTheRun) {
  Rig rig(Hanging());
  rig.Fix(rig->command, Same(0, 5));
  EXPECT_TRUE(Throws<RunError>([&] { rig.Derivative(rig->motor_tension); }, "block", "command"));
  rig.Fix(rig->payload, Payload{.mass = -1});
  EXPECT_TRUE(Throws<RunError>([&] { rig[rig->acceleration]; }, "payload"));
  rig.Fix(rig->payload, Payload{});
  SetRestLength(rig, 0);
  EXPECT_TRUE(Throws<RunError>([&] { rig[rig->acceleration]; }, "cable 0"));

  CdprDescription robot = FourCableRobot();
  robot.cables[3].attachment_B = {0, 0, 0};
  Rig reached(Hanging(robot));
  PlatformState x = reached[reached->platform_state];
  x.p_WB = robot.cables[3].anchor_W;
  reached.Set(reached->platform_state, x);
  EXPECT_TRUE(Throws<RunError>([&] { reached[reached->cables]; }, "cable 3"));
}

}  // namespace tenon::cdpr_plant_test
