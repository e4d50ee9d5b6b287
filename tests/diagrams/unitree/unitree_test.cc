#include <tenon/diagrams/recommended_options.h>
#include <tenon/diagrams/unitree/unitree_server.h>
#include <tenon/diagrams/unitree/unitree_world.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/tests/systems/dds/dds_peer.h>
#include <tenon/tests/systems/framework/test_blocks.h>

#include <unitree_api.h>
#include <unitree_go.h>

#include <atomic>
#include <thread>

namespace tenon::unitree_test {

using test::DdsPeer, test::kOwnLink;
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

void Sign(auto& message) {
  message.crc = CrcOfTheMaker(&message, sizeof message / 4 - 1);
}

LowCmd Signed(LowCmd message) {
  Sign(message);
  return message;
}

QuadrupedDescription Go2() {
  return LoadQuadruped(std::string(TENON_ROBOTS_DIR) + "/go2.yaml");
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

// Layouts inside of messages; their sizes and the place of the checksum are asserted when the library is
// compiled.
TEST(UnitreeMessagesTest, HaveTheLayoutsOfTheRobots) {
  EXPECT_EQ(sizeof(unitree_go_msg_dds__MotorCmd_), 36u);
  EXPECT_EQ(offsetof(LowCmd, motor_cmd), 24u);
  EXPECT_EQ(offsetof(LowCmd, bms_cmd), 744u);
  EXPECT_EQ(sizeof(unitree_go_msg_dds__MotorState_), 48u);
  EXPECT_EQ(offsetof(LowState, imu_state), 24u);
  EXPECT_EQ(offsetof(LowState, motor_state), 80u);
  EXPECT_EQ(offsetof(LowState, foot_force), 1084u);
  EXPECT_EQ(offsetof(LowState, tick), 1100u);
  EXPECT_STREQ(unitree_go_msg_dds__LowCmd__desc.m_typename, "unitree_go::msg::dds_::LowCmd_");
  EXPECT_STREQ(unitree_go_msg_dds__LowState__desc.m_typename, "unitree_go::msg::dds_::LowState_");
  EXPECT_STREQ(unitree_api_msg_dds__Request__desc.m_typename, "unitree_api::msg::dds_::Request_");
  EXPECT_STREQ(unitree_api_msg_dds__Response__desc.m_typename, "unitree_api::msg::dds_::Response_");
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
  UnitreeState state{.time = 1.234};
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
  const QuadrupedDescription robot = Go2();
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

/// Whether a command damps all joints; torques of the command stay within the limits. The torque of damping
/// exceeds them at a speed beyond the limit, where the drive limits it.
bool Damps(const JointCommand& command, const JointMotion& joints, const QuadrupedDescription& robot) {
  const Vec<12> torque = command.TorqueAt(joints);
  for (int j = 0; j < kNumJoints; ++j) {
    const double too_fast = std::max(1.0, std::abs(joints.qd[j]) / robot.joint(j).speed_limit);
    EXPECT_LE(std::abs(torque[j]), robot.joint(j).torque_limit * too_fast * (1 + 1e-9)) << j;
  }
  return command.kp.isZero(0) && command.torque.isZero(0) && command.kd.minCoeff() > 0;
}

/// A robot that sends states, and the supervisor that watches them.
struct Watched {
  Watched() {
    DiagramBuilder builder;
    world = &builder.Add<UnitreeWorld>("world", {.link = kOwnLink, .initial = {.q = robot.stance}});
    deployment = &builder.Add<Deployment>("deployment", {.robot = robot, .initial = DeploymentMode::kWalk});
    builder.Connect(world->joints, deployment->joints);
    builder.Connect(world->state, deployment->state);
    builder.Connect(world->heartbeat, deployment->heartbeat);
    builder.Connect(world->goal, deployment->goal);
    builder.Connect(builder.AddFunction({"torque", "N m"}, Uses(world->joints),
                                        [](const JointMotion&) -> Vec<12> { return Vec<12>::Ones(); }),
                    deployment->torque);
    builder.Connect(deployment->command, world->command);
    diagram = builder.Build();
    peer.emplace("rt/lowstate", unitree_go_msg_dds__LowState__desc);  // after a block has joined
  }
  void Start() {
    simulator.emplace(*diagram);
    ticks = 0;
  }
  /// A message with the next state; `damage` changes it.
  template <class F>
  void Send(const F& damage) {
    state.time += 0.002;
    state.joints.q = robot.stance;
    state.joints.qd[0] = random.Uniform(-0.1, 0.1);
    LowState message;
    std::memset(&message, 0, sizeof message);
    DdsMessageOf<UnitreeState>::Get().write(&state, &message);
    damage(message);
    peer->Send(&message, state.time);
  }
  /// One period of 2 ms; true if the command damps the joints.
  bool Damps() {
    simulator->RunTo(0.002 * ++ticks);
    const Context& context = simulator->context();
    return unitree_test::Damps(context.Eval(deployment->command), context.Eval(world->joints), robot);
  }
  const QuadrupedDescription robot = Go2();
  UnitreeWorld* world;
  Deployment* deployment;
  std::shared_ptr<const Diagram> diagram;
  std::optional<Simulator> simulator;
  std::optional<DdsPeer> peer;
  UnitreeState state;
  RandomStream random{5, "robot"};
  int ticks = 0;
};

/// Faults of the state set in at random times, `repetitions` of each kind.
void ExpectThatFaultsOfTheStateDamp(int repetitions) {
  using Damage = std::function<void(LowState&)>;
  float speed = 0;  // of a joint in the last message, which a frozen robot repeats
  const auto frozen = [&](LowState& m) { m.motor_state[3].dq = speed, Sign(m); };
  const std::pair<DeploymentFault, Damage> cases[] = {
      {DeploymentFault::kLost, nullptr},  // nothing is sent: the link is cut, or the messages are late
      {DeploymentFault::kLost, [](LowState& m) { ++m.crc; }},
      {DeploymentFault::kLost,
       [&](LowState& m) { m.motor_state[3].q = std::numeric_limits<float>::quiet_NaN(), Sign(m); }},
      {DeploymentFault::kFrozen, frozen},
      {DeploymentFault::kMissed, [&](LowState& m) { m.tick += 1000, Sign(m); }},
      {DeploymentFault::kAngle, [&](LowState& m) { m.motor_state[3].q += 3, Sign(m); }},
      {DeploymentFault::kSpeed, [&](LowState& m) { m.motor_state[3].dq = 1000, Sign(m); }},
      {DeploymentFault::kStop, [&](LowState& m) {
         m.wireless_remote[2] = 0x20, m.wireless_remote[3] = 0x02;  // L2 and B
         Sign(m);
       }}};
  Watched robot;
  for (const auto& [fault, damage] : cases) {
    for (int repetition = 0; repetition < repetitions; ++repetition) {
      robot.Start();
      for (int left = 3 + static_cast<int>(robot.random.Uniform(0, 20)); left > 0; --left) {
        robot.Send([&](LowState& m) { speed = m.motor_state[3].dq; });
        EXPECT_FALSE(robot.Damps()) << "the robot lives";
      }
      int periods = 1;
      for (; periods < 20; ++periods) {
        if (damage) robot.Send(damage);
        if (robot.Damps()) break;
      }
      ASSERT_LE(2 * periods, 20) << EnumName(fault);
      ASSERT_EQ(robot.simulator->context().Eval(robot.deployment->status).fault, fault);
    }
  }
}
TEST(UnitreeWorldTest, FaultsOfTheStateDampTheJointsWithin20Milliseconds) {
  ExpectThatFaultsOfTheStateDamp(4);
}
TEST(UnitreeWorldTest, FaultsOfTheStateDampTheJointsAThousandTimes) {
  ExpectThatFaultsOfTheStateDamp(125);
}

// ---- The client is lost ----

/// A Go2 that a client commands, tick by tick.
struct Served {
  Served() {
    DiagramBuilder builder;
    world = &builder.Add<QuadrupedWorld>("world", MakeQuadrupedWorld(robot));
    server = &builder.Add<UnitreeServer>(
        "server",
        {.link = kOwnLink, .initial = HoldStance(MakeJointPd(robot)), .expired = DampedJoints(robot)});
    builder.Connect(world->joints, server->joints);
    builder.Connect(server->torque, world->torque);
    server->ConnectSensors(builder, *world);
    diagram = builder.Build();
  }
  void Start() {
    simulator.emplace(*diagram, RecommendedOptions(*world));
    ticks = 0;
  }
  /// One period of 1 ms; true if the command damps the joints. The drives keep their limits.
  bool Damps() {
    simulator->RunTo(0.001 * ++ticks);
    const Context& context = simulator->context();
    const Vec<12>& torque = context.Eval(world->plant.joint_torque);
    for (int j = 0; j < kNumJoints; ++j)
      EXPECT_LE(std::abs(torque[j]), robot.joint(j).torque_limit * (1 + 1e-9));
    const UnitreeCommand& now = context.Eval(server->command.y);
    return now.kp.isZero(0) && now.torque.isZero(0) && now.kd.minCoeff() > 0;
  }
  std::uint64_t commands() const { return simulator->context().Eval(server->command.taken).number; }
  /// Periods from the last command until the joints are damped.
  int PeriodsUntilDamped() {
    int periods = 0;
    for (std::uint64_t last = commands(); !Damps() && periods < 100;)
      if (std::exchange(last, commands()) == last) ++periods;
    return periods + 1;
  }
  const QuadrupedDescription robot = Go2();
  QuadrupedWorld* world;
  UnitreeServer* server;
  std::shared_ptr<const Diagram> diagram;
  std::optional<Simulator> simulator;
  int ticks = 0;
};

/// Commands stop, or are refused from then on, at random times.
void ExpectThatALostClientDamps(int repetitions) {
  Served robot;
  const DdsPeer peer("rt/lowcmd", unitree_go_msg_dds__LowCmd__desc);
  RandomStream random(7, "client");
  const UnitreeCommand stance = HoldStance(MakeJointPd(robot.robot));
  double time = 0;
  const auto send = [&](const std::function<void(LowCmd&)>& damage) {
    LowCmd message;
    std::memset(&message, 0, sizeof message);
    DdsMessageOf<UnitreeCommand>::Get().write(&stance, &message);
    damage(message);
    peer.Send(&message, time += 0.002);
  };
  const std::function<void(LowCmd&)> cases[] = {
      nullptr,                                              // the client is dead, or the link is cut
      [](LowCmd& m) { m.motor_cmd[2].q += 100, Sign(m); },  // it jumps before it dies
      [](LowCmd& m) { ++m.crc; },
      [](LowCmd& m) { m.motor_cmd[2].tau = std::numeric_limits<float>::quiet_NaN(), Sign(m); }};
  for (int i = 0; i < repetitions; ++i) {
    const auto& damage = cases[i % std::size(cases)];
    robot.Start();
    for (int left = 1 + static_cast<int>(random.Uniform(0, 20)); left > 0; --left) {
      if (left % 2 == 0) send([](LowCmd&) {});
      EXPECT_FALSE(robot.Damps());
    }
    send([](LowCmd&) {});
    EXPECT_FALSE(robot.Damps());
    if (damage) send(damage);
    ASSERT_LE(robot.PeriodsUntilDamped(), 20);
  }
}
TEST(UnitreeServerTest, TheCommandOfALostClientDoesNotStay) {
  ExpectThatALostClientDamps(8);
}
TEST(UnitreeServerTest, ALostClientDampsTheJointsAThousandTimes) {
  ExpectThatALostClientDamps(1000);
}

// The client answers states until a signal ends or stops it.
TEST(UnitreeServerTest, AKilledOrStoppedClientDampsTheJoints) {
  for (const int signal : {SIGKILL, SIGSTOP}) {
    test::SecondProcess client([&] {
      const UnitreeCommand stance = HoldStance(MakeJointPd(Go2()));
      TestRig<DdsInput<UnitreeState>> state({.topic = "rt/lowstate", .link = kOwnLink});
      TestRig<DdsPublisher<UnitreeCommand>> command({.topic = "rt/lowcmd", .link = kOwnLink});
      command.Fix(command->u, stance);
      for (std::uint64_t last = 0;; std::this_thread::sleep_for(std::chrono::microseconds(100)))
        if (const std::uint64_t now = state.Tick()[state->taken].number; std::exchange(last, now) != now)
          command.Tick();
    });
    Served robot;
    robot.Start();
    EXPECT_TRUE(test::Within10s([&] {
      robot.Damps();
      return robot.commands() > 20;
    }));
    client.Signal(signal);
    EXPECT_LE(robot.PeriodsUntilDamped(), 20);
  }
}

// ---- The motion switcher ----

TEST(MotionSwitcherTest, AClientEndsTheBuiltInMode) {
  TestRig<MotionSwitcher> rig({.link = kOwnLink});
  std::atomic<bool> ends = false;
  std::thread robot([&] {
    while (!ends) rig.Tick(), std::this_thread::sleep_for(std::chrono::milliseconds(1));
  });
  EXPECT_TRUE(LeaveBuiltInMode(kOwnLink, 10));
  EXPECT_TRUE(LeaveBuiltInMode(kOwnLink, 10)) << "again";
  ends = true;
  robot.join();
  EXPECT_FALSE(rig[rig->active]);
}

TEST(MotionSwitcherTest, ARobotThatDoesNotAnswerIsAnErrorWithARemedy) {
  EXPECT_FALSE(LeaveBuiltInMode(kOwnLink, 0.01)) << "a simulator without one";
  const DdsLink anywhere{.domain = kOwnLink.domain - 1};
  EXPECT_TRUE(Throws<ParameterError>([&] { LeaveBuiltInMode(anywhere, 0.01); }, "no robot answers",
                                     std::to_string(anywhere.domain), "192.168.123"));
}

}  // namespace tenon::unitree_test
