#include <tenon/diagrams/recommended_options.h>
#include <tenon/diagrams/unitree/unitree_server.h>
#include <tenon/diagrams/unitree/unitree_world.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/tests/systems/dds/dds_peer.h>
#include <tenon/tests/systems/framework/test_blocks.h>

#include <unitree_go.h>

#include <cstddef>
#include <cstring>
#include <functional>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

namespace tenon::unitree_test {

using test::DdsPeer;
using test::kOwnLink;
using LowCmd = unitree_go_msg_dds__LowCmd_;
using LowState = unitree_go_msg_dds__LowState_;

/// The checksum as the maker's programs compute it, bit by bit.
std::uint32_t CrcOfTheMaker(const void* message, std::size_t words) {
  std::uint32_t crc = 0xFFFFFFFF;
  for (std::size_t i = 0; i < words; ++i) {
    std::uint32_t word = 0;
    std::memcpy(&word, static_cast<const char*>(message) + 4 * i, 4);
    for (std::uint32_t bit = 1u << 31; bit != 0; bit >>= 1) {
      const std::uint32_t carry = crc & 1u << 31;
      crc <<= 1;
      if (carry != 0) crc ^= 0x04C11DB7;
      if ((word & bit) != 0) crc ^= 0x04C11DB7;
    }
  }
  return crc;
}

/// A command as a client of the maker's SDK sends it, before its checksum.
LowCmd Stand() {
  LowCmd message;
  std::memset(&message, 0, sizeof message);
  message.head[0] = 0xFE;
  message.head[1] = 0xEF;
  message.level_flag = 0xFF;
  for (int i = 0; i < 20; ++i) {
    auto& motor = message.motor_cmd[i];
    motor.mode = 1;
    motor.q = 0.1f * static_cast<float>(i);
    motor.dq = 0.5f;
    motor.tau = 1.5f * static_cast<float>(i);
    motor.kp = 20;
    motor.kd = 3.5f;
  }
  return message;
}
LowCmd Signed(LowCmd message) {
  message.crc = CrcOfTheMaker(&message, sizeof message / 4 - 1);
  return message;
}

using Input = DdsInput<UnitreeCommand>;
const DdsInputParams<UnitreeCommand> kInput{.topic = "rt/lowcmd", .link = kOwnLink};

TEST(UnitreeCrcTest, HasKnownValues) {
  // CRC-32/MPEG-2 of the bytes 00 00 00 00, FE EF FF 00, and "12345678", the first byte most
  // significant.
  EXPECT_EQ(UnitreeCrc({{0}}), 0xC704DD7Bu);
  EXPECT_EQ(UnitreeCrc({{0xFEEFFF00}}), 0x70101273u);
  EXPECT_EQ(UnitreeCrc({{0x31323334, 0x35363738}}), 0x49E3C2FBu);
}

// The layouts of the robots, on which the checksum depends, byte for byte.
TEST(UnitreeMessagesTest, HaveTheLayoutsOfTheRobots) {
  EXPECT_EQ(sizeof(LowCmd), 812u);
  EXPECT_EQ(sizeof(unitree_go_msg_dds__MotorCmd_), 36u);
  EXPECT_EQ(offsetof(LowCmd, motor_cmd), 24u);
  EXPECT_EQ(offsetof(LowCmd, bms_cmd), 744u);
  EXPECT_EQ(offsetof(LowCmd, crc), 808u);
  EXPECT_EQ(sizeof(LowState), 1180u);
  EXPECT_EQ(sizeof(unitree_go_msg_dds__MotorState_), 48u);
  EXPECT_EQ(offsetof(LowState, imu_state), 24u);
  EXPECT_EQ(offsetof(LowState, motor_state), 80u);
  EXPECT_EQ(offsetof(LowState, foot_force), 1084u);
  EXPECT_EQ(offsetof(LowState, tick), 1100u);
  EXPECT_EQ(offsetof(LowState, crc), 1176u);
  EXPECT_STREQ(unitree_go_msg_dds__LowCmd__desc.m_typename, "unitree_go::msg::dds_::LowCmd_");
  EXPECT_STREQ(unitree_go_msg_dds__LowState__desc.m_typename, "unitree_go::msg::dds_::LowState_");
}

TEST(UnitreeMessagesTest, ACommandIsReadInTheOrderOfLegs) {
  TestRig<Input> rig(kInput);
  const DdsPeer peer("rt/lowcmd", unitree_go_msg_dds__LowCmd__desc);
  LowCmd message = Stand();
  message.motor_cmd[0].q = 2.146e9f;  // front right abduction: no position
  message.motor_cmd[1].dq = 16000;    // front right hip: no speed
  message.motor_cmd[2].mode = 0;      // front right knee: off
  message = Signed(message);
  peer.Send(&message, 0);
  const UnitreeCommand& command = rig.Tick()[rig->y];
  EXPECT_EQ(rig[rig->refused].reason, "");
  EXPECT_THAT(std::vector<double>(command.torque.begin(), command.torque.end()),
              testing::ElementsAre(4.5, 6, 7.5, 0, 1.5, 0, 13.5, 15, 16.5, 9, 10.5, 12));
  EXPECT_THAT(std::vector<double>(command.kp.begin(), command.kp.begin() + 6),
              testing::ElementsAre(20, 20, 20, 0, 20, 0));
  EXPECT_THAT(std::vector<double>(command.kd.begin(), command.kd.begin() + 6),
              testing::ElementsAre(3.5, 3.5, 3.5, 3.5, 0, 0));
  EXPECT_FLOAT_EQ(static_cast<float>(command.q[0]), 0.3f);
  EXPECT_EQ(command.q[3], 0);
  EXPECT_EQ(command.qd[4], 0);
}

TEST(UnitreeMessagesTest, DamagedCommandsAreCountedAndNamed) {
  TestRig<Input> rig(kInput);
  const DdsPeer peer("rt/lowcmd", unitree_go_msg_dds__LowCmd__desc);
  std::uint64_t count = 0;
  const auto expect_refused = [&](const LowCmd& message, const char* reason) {
    peer.Send(&message, 1);
    EXPECT_TRUE(rig.Tick()[rig->y].kp.isZero(0)) << reason;
    EXPECT_EQ(rig[rig->refused].count, ++count);
    EXPECT_THAT(rig[rig->refused].reason, testing::HasSubstr(reason));
  };
  LowCmd message = Signed(Stand());
  message.motor_cmd[5].q += 0.5f;
  expect_refused(message, "wrong checksum");
  message = Stand();
  message.motor_cmd[3].tau = std::numeric_limits<float>::quiet_NaN();
  expect_refused(Signed(message), "'torque.front_left_abduction' = nan");
  message = Stand();
  message.motor_cmd[3].q = std::numeric_limits<float>::infinity();
  expect_refused(Signed(message), "'q.front_left_abduction' = inf");
  message = Stand();
  message.motor_cmd[4].kd = -1;
  expect_refused(Signed(message), "motor 4");
}

// The fields are read as a client does that knows nothing of Tenon.
TEST(UnitreeMessagesTest, AStateIsWrittenAsTheRobotsDo) {
  UnitreeState state;
  state.time = 1.234;
  for (int j = 0; j < kNumJoints; ++j) state.joints.q[j] = j, state.torque[j] = -j;
  state.q_WB = Vec<4>(std::cos(0.1), 0, 0, std::sin(0.1));
  state.inertial.specific_force_B = Vec<3>(1, 2, 9.5);
  state.foot_force = Vec<4>(10.4, 20.6, 30, 1e6);
  state.buttons = 1 << UnitreeState::kL2 | 1 << UnitreeState::kB;
  LowState message{};
  std::memset(&message, 0, sizeof message);
  DdsMessageOf<UnitreeState>::Get().write(&state, &message);
  EXPECT_EQ(message.crc, CrcOfTheMaker(&message, 294));
  EXPECT_EQ(ChecksumOf(state), message.crc);
  EXPECT_EQ(message.head[0], 0xFE);
  EXPECT_EQ(message.tick, 1234u);
  EXPECT_EQ(message.wireless_remote[2], 0x20);
  EXPECT_EQ(message.wireless_remote[3], 0x02);
  EXPECT_EQ(message.motor_state[0].q, 3);
  EXPECT_EQ(message.motor_state[11].tau_est, -8);
  EXPECT_FLOAT_EQ(message.imu_state.rpy[2], 0.2f);
  EXPECT_EQ(message.imu_state.accelerometer[2], 9.5);
  EXPECT_THAT(message.foot_force, testing::ElementsAre(21, 10, 32767, 30));
}

// ---- The server ----

/// A client that raises and lowers the trunk of the robot, tick by tick.
void Client(double end, const UnitreeCommand& stance) {
  DiagramBuilder builder;
  auto& state = builder.Add<DdsInput<UnitreeState>>(
      "state", {.topic = "rt/lowstate", .link = kOwnLink, .rate = Hz(500), .lock_step = true});
  auto& command = builder.AddFunction({"command"}, Uses(state.y), [stance](const UnitreeState& x) {
    UnitreeCommand command = stance;
    for (int leg = 0; leg < kNumLegs; ++leg) {
      command.q[3 * leg + 1] += 0.2 * std::sin(10 * x.time);
      command.q[3 * leg + 2] -= 0.4 * std::sin(10 * x.time);
    }
    return command;
  });
  auto& to_robot = builder.Add<DdsPublisher<UnitreeCommand>>(
      "to_robot", {.topic = "rt/lowcmd", .link = kOwnLink, .rate = Hz(500), .lock_step = true});
  builder.Connect(command, to_robot.u);
  Simulator(builder.Build()).RunTo(end);
}

TEST(UnitreeServerTest, AClientInAnotherProcessMovesTheRobotAndTheRunRepeats) {
  constexpr double kEnd = 0.4;
  const QuadrupedDescription robot = LoadQuadruped(std::string(TENON_ROBOTS_DIR) + "/go2.yaml");
  UnitreeServerParams params{.link = kOwnLink, .lock_step = true, .record = true};
  std::vector<LeggedState> ends;
  std::vector<std::uint32_t> checksums;
  const auto run = [&] {
    DiagramBuilder builder;
    auto& world = builder.Add<QuadrupedWorld>("world", MakeQuadrupedWorld(robot));
    auto& server = builder.Add<UnitreeServer>("server", params);
    builder.Connect(world.joints, server.joints);
    builder.Connect(server.torque, world.torque);
    server.ConnectSensors(builder, world);
    Simulator simulator(builder.Build(), RecommendedOptions(world));
    simulator.RunTo(kEnd);
    ends.push_back(simulator.context().Eval(world.state));
    checksums.push_back(simulator.context().Eval(server.checksum));
    return simulator.context().Eval(server.command.taken).recording;
  };
  for (int i = 0; i < 2; ++i) {
    test::SecondProcess client([&] { Client(kEnd, HoldStance(MakeJointPd(robot))); });
    const Recording<UnitreeCommand> recording = run();
    EXPECT_TRUE(client.Succeeds());
    EXPECT_EQ(recording.size(), 201u) << "one command for each state";
    if (i == 1) params.replay = recording;
  }
  EXPECT_GT(std::abs(ends[0].q[2] - robot.stance[2]), 0.1) << "the knee follows the client";
  run();
  EXPECT_EQ(checksums[2], checksums[0]);
  for (const LeggedState& x : {ends[1], ends[2]}) {
    EXPECT_EQ(x.p_WB, ends[0].p_WB);
    EXPECT_EQ(x.q, ends[0].q);
    EXPECT_EQ(x.qd, ends[0].qd);
  }
}

// ---- The robot as the plant ----

/// A walk of a Go2 by inertial unit and encoders, without foot sensors.
QuadrupedWalkParams WalkOfGo2() {
  const QuadrupedDescription robot = LoadQuadruped(std::string(TENON_ROBOTS_DIR) + "/go2.yaml");
  QuadrupedWalkParams params = MakeQuadrupedWalk(robot);
  params.world.foot_sensor.mounted = FootSensing::kNone;
  params.walk.segments = {{.gait = Gait::kStand, .duration = 0.5},
                          {.gait = Gait::kTrot, .forward = 0.3, .duration = 2.5}};
  params.estimator.emplace();
  params.estimator->robot = robot;
  params.estimator->initial = params.world.plant.initial;
  params.deployment = DeploymentParams{.robot = robot, .initial = DeploymentMode::kWalk};
  return params;
}

/// Where the robot is, with the mean height and the largest tilt of its trunk.
struct Walked {
  LeggedState end;
  double height = 0, tilt = 0;
};
Walked Follow(DiagramBuilder& builder, const QuadrupedWorld& world, double end) {
  Simulator simulator(builder.Build(), RecommendedOptions(world));
  Walked walked;
  for (int i = 0; i <= std::lround(100 * end); ++i) {
    simulator.RunTo(0.01 * i);
    const LeggedState& x = simulator.context().Eval(world.state);
    walked.height += (x.p_WB[2] - walked.height) / (i + 1);
    walked.tilt = std::max(walked.tilt, std::acos(std::min(1.0, x.R_WB()(2, 2))));
    walked.end = x;
  }
  return walked;
}

// In 3 s, 0.614 m in two processes and 0.615 m in one.
TEST(UnitreeWorldTest, AControllerInAnotherProcessWalksAsInOne) {
  constexpr double kEnd = 3;
  const QuadrupedWalkParams params = WalkOfGo2();
  const auto alone = [&] {
    DiagramBuilder builder;
    return Follow(builder, builder.Add<QuadrupedWalk>("walk", params).world, kEnd);
  }();
  const auto apart = [&] {
    test::SecondProcess controller([&] {
      DiagramBuilder builder;
      auto& walk = builder.Add<QuadrupedWalk>("walk", params);
      DriveUnitree(builder, walk,
                   {.link = kOwnLink, .initial = params.world.plant.initial, .lock_step = true});
      Simulator simulator(builder.Build());
      simulator.RunTo(kEnd);
      if (simulator.context().Eval(walk.deployment->status).mode != DeploymentMode::kWalk)
        throw RunError("the joints were damped");
    });
    DiagramBuilder builder;
    auto& world = builder.Add<QuadrupedWorld>("world", params.world);
    auto& server = builder.Add<UnitreeServer>("server", {.link = kOwnLink, .lock_step = true});
    builder.Connect(world.joints, server.joints);
    builder.Connect(server.torque, world.torque);
    server.ConnectSensors(builder, world);
    Walked walked = Follow(builder, world, kEnd);
    EXPECT_TRUE(controller.Succeeds());
    return walked;
  }();
  EXPECT_GT(apart.end.p_WB[0], 0.6);
  EXPECT_NEAR(apart.end.p_WB[0], alone.end.p_WB[0], 0.03);
  EXPECT_NEAR(apart.end.p_WB[1], alone.end.p_WB[1], 0.03);
  EXPECT_NEAR(apart.height, alone.height, 0.003);
  EXPECT_NEAR(apart.tilt, alone.tilt, 0.02);
}

/// A robot that sends states, and the supervisor that watches them.
struct Watched {
  Watched() {
    DiagramBuilder builder;
    const QuadrupedDescription robot = LoadQuadruped(std::string(TENON_ROBOTS_DIR) + "/go2.yaml");
    LeggedState initial;
    initial.q = robot.stance;
    world = &builder.Add<UnitreeWorld>("world", {.link = kOwnLink, .initial = initial});
    deployment = &builder.Add<Deployment>("deployment", {.robot = robot, .initial = DeploymentMode::kWalk});
    builder.Connect(world->joints, deployment->joints);
    builder.Connect(world->state, deployment->state);
    builder.Connect(world->heartbeat, deployment->heartbeat);
    builder.Connect(world->goal, deployment->goal);
    builder.Connect(builder.AddFunction({"torque", "N m"}, Uses(world->joints),
                                        [](const JointMotion&) -> Vec<12> { return Vec<12>::Ones(); }),
                    deployment->torque);
    builder.Connect(deployment->command, world->command);
    simulator.emplace(builder.Build());
    peer.emplace("rt/lowstate", unitree_go_msg_dds__LowState__desc);  // after a block has joined
    state.joints.q = robot.stance;
  }
  /// A message with the next state; `damage` changes it.
  template <class F>
  void Send(const F& damage) {
    state.time += 0.002;
    state.joints.qd[0] = random.Uniform(-0.1, 0.1);
    LowState message;
    std::memset(&message, 0, sizeof message);
    DdsMessageOf<UnitreeState>::Get().write(&state, &message);
    damage(message);
    peer->Send(&message, state.time);
  }
  /// One period of 2 ms; true if the command damps the joints.
  bool Damps() {
    time += 0.002;
    simulator->RunTo(time);
    const JointCommand& c = simulator->context().Eval(deployment->command);
    return c.kp.isZero(0) && c.torque.isZero(0) && c.kd.minCoeff() > 0;
  }
  UnitreeWorld* world;
  Deployment* deployment;
  std::optional<Simulator> simulator;
  std::optional<DdsPeer> peer;
  UnitreeState state;
  RandomStream random{5, "robot"};
  double time = 0;
};

TEST(UnitreeWorldTest, DamagedStatesAndTheRemoteDampTheJointsWithin20Milliseconds) {
  const auto sign = [](LowState& m) { m.crc = CrcOfTheMaker(&m, sizeof m / 4 - 1); };
  using Damage = std::function<void(LowState&)>;
  const std::pair<DeploymentFault, Damage> cases[] = {
      {DeploymentFault::kLost, nullptr},  // nothing is sent
      {DeploymentFault::kLost, [](LowState& m) { ++m.crc; }},
      {DeploymentFault::kLost,
       [&](LowState& m) { m.motor_state[3].q = std::numeric_limits<float>::quiet_NaN(), sign(m); }},
      {DeploymentFault::kMissed, [&](LowState& m) { m.tick += 1000, sign(m); }},
      {DeploymentFault::kStop, [&](LowState& m) {
         m.wireless_remote[2] = 0x20, m.wireless_remote[3] = 0x02;  // L2 and B
         sign(m);
       }}};
  for (const auto& [fault, damage] : cases) {
    Watched robot;
    for (int i = 0; i < 20; ++i) {
      robot.Send([](LowState&) {});
      EXPECT_FALSE(robot.Damps()) << "the robot lives";
    }
    int periods = 1;
    for (; periods < 20; ++periods) {
      if (damage) robot.Send(damage);
      if (robot.Damps()) break;
    }
    EXPECT_LE(2 * periods, 20) << EnumName(fault);
    EXPECT_EQ(robot.simulator->context().Eval(robot.deployment->status).fault, fault);
  }
}

}  // namespace tenon::unitree_test
