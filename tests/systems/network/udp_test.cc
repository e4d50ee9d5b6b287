#include <tenon/systems/network/udp.h>
#include <tenon/systems/primitives/constant.h>
#include <tenon/tests/systems/framework/test_blocks.h>
#include <tenon/tests/systems/network/peer.h>
#include <tenon/tests/systems/network/signals.h>
#include <tenon/tests/testing/allocation_guard.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/test_rig.h>

#include <fcntl.h>
#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <thread>

namespace tenon::udp_test {
namespace {

using test::Cloud;
using test::Everything;
using test::Peer;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

template <class T>
std::string Sent(const T& value) {
  const Peer peer;
  TestRig<UdpPublisher<T>> rig({.name = "x", .port = peer.port()});
  rig.Fix(rig->u, value).Tick();
  return peer.Receive();
}

/// What arrives of a value, through text; the shape is that of `initial`.
template <class T>
T Returned(const T& value, const T& initial = T{}) {
  UdpInputParams<T> params{.name = "x", .initial = initial, .port = 0};
  TestRig<UdpInput<T>> input(std::move(params));
  TestRig<UdpPublisher<T>> rig({.name = "x", .port = input->port()});
  rig.Fix(rig->u, value).Tick();
  EXPECT_EQ(input.Tick()[input->refused].reason, "");
  EXPECT_EQ(input[input->taken].number, 1u);
  return input[input->taken].value;
}

// ---- Sending ----

TEST(UdpPublisherTest, SendsWhatPlotJugglerTakes) {
  const Peer peer;
  DiagramBuilder builder;
  auto& oscillator = builder.Add<Oscillator>("oscillator");
  auto& to_plots = builder.Add<UdpPublisher<Vec<2>>>(
      "to_plots", {.name = "robot.leg", .port = peer.port(), .rate = Hz(10)});
  builder.Connect(oscillator.state, to_plots.u);
  Simulator simulator(builder.Build());
  simulator.Initialize();
  EXPECT_EQ(peer.Receive(), R"({"timestamp":0,"robot":{"leg":{"q":1,"v":0}}})");
  simulator.RunTo(0.15);
  const auto message = nlohmann::json::parse(peer.Receive());
  EXPECT_EQ(message["timestamp"], 0.1);
  EXPECT_NEAR(message["robot"]["leg"]["v"], -std::sin(0.1), 1e-6);
  EXPECT_TRUE(peer.HasNothing());
}

TEST(UdpPublisherTest, NamesTheElementsAsLogsDo) {
  EXPECT_EQ(Sent(0.5), R"({"timestamp":0,"x":0.5})");
  EXPECT_EQ(Sent(true), R"({"timestamp":0,"x":true})");
  EXPECT_EQ(Sent(Vec<3>(1, 2, 3)), R"({"timestamp":0,"x":{"x":1,"y":2,"z":3}})");
  EXPECT_EQ(Sent(Eigen::Matrix2d(Eigen::Matrix2d::Identity())),
            R"({"timestamp":0,"x":{"0_0":1,"1_0":0,"0_1":0,"1_1":1}})");
  EXPECT_EQ(Sent(std::array<test::Leg, 2>{}),
            R"({"timestamp":0,"x":{"0":{"phase":0,"p_W":{"x":0,"y":0,"z":0}},)"
            R"("1":{"phase":0,"p_W":{"x":0,"y":0,"z":0}}}})");
  EXPECT_EQ(Sent(std::vector<double>{}), R"({"timestamp":0})");
}

TEST(UdpPublisherTest, WritesWhatJsonHasNoNumberFor) {
  EXPECT_EQ(Sent(Vec<3>(kNan, kInfinity, -kInfinity)),
            R"({"timestamp":0,"x":{"x":"NaN","y":"Infinity","z":"-Infinity"}})");
  EXPECT_EQ(Sent(-0.0), R"({"timestamp":0,"x":-0.0})");
}

TEST(UdpPublisherTest, NamesMayHoldAnything) {
  const Peer peer;
  TestRig<UdpPublisher<double>> rig({.name = "a \"b\"\\", .port = peer.port()});
  rig.Fix(rig->u, 1).Tick();
  EXPECT_EQ(peer.Receive(), R"({"timestamp":0,"a \"b\"\\":1})");
}

TEST(UdpPublisherTest, FollowsAValueThatChangesItsSize) {
  const Peer peer;
  TestRig<UdpPublisher<Cloud>> rig({.name = "c", .port = peer.port()});
  Cloud cloud;
  cloud.weights = Vec<2>(1, 2);
  rig.Fix(rig->u, cloud).Tick();
  EXPECT_EQ(peer.Receive(), R"({"timestamp":0,"c":{"weights":{"0":1,"1":2}}})");
  cloud.weights.resize(0);
  cloud.points = {{1, 2, 3}};
  rig.Fix(rig->u, cloud).Tick();
  EXPECT_EQ(peer.Receive(), R"({"timestamp":0.01,"c":{"points":{"0":{"x":1,"y":2,"z":3}}}})");
  cloud.radius = 4;
  cloud.points.clear();
  rig.Fix(rig->u, cloud).Tick();
  EXPECT_EQ(peer.Receive(), R"({"timestamp":0.02,"c":{"radius":{"0":4}}})");
}

TEST(UdpPublisherTest, NobodyNeedListen) {
  int port = 0;
  {
    const Peer peer;
    port = peer.port();
  }
  TestRig<UdpPublisher<double>> rig({.name = "x", .port = port});
  rig.Fix(rig->u, 1).RunTo(1);
  EXPECT_EQ(rig[rig->unsent], 0u);
}

TEST(UdpPublisherTest, SendsWithoutAllocating) {
  if (!AllocationGuard::Available()) GTEST_SKIP() << "allocations are not counted in this build";
  const Peer peer;
  TestRig<UdpPublisher<Cloud>> rig({.name = "a signal with a long name", .port = peer.port()});
  rig.Fix(rig->u, test::SomeCloud()).Tick().Tick();
  const AllocationGuard guard;
  for (int i = 0; i < 100; ++i) rig.Tick();
  EXPECT_EQ(guard.count(), 0);
}

TEST(UdpPublisherTest, RefusesWhatItCannotSend) {
  EXPECT_TRUE(
      Throws<ParameterError>([] { TestRig<UdpPublisher<double>> rig; }, "block 'block'", "name is empty"));
  EXPECT_TRUE(Throws<ParameterError>([] { TestRig<UdpPublisher<double>> rig({.name = "timestamp"}); },
                                     "name = 'timestamp' is reserved"));
  EXPECT_TRUE(Throws<ParameterError>([] { TestRig<UdpPublisher<double>> rig({.name = "x", .port = 0}); },
                                     "port = 0 must be 1 to 65535"));
  EXPECT_TRUE(Throws<ParameterError>(
      [] { TestRig<UdpPublisher<double>> rig({.name = "x", .address = "no address", .port = 9}); },
      "block 'block': address = 'no address', port 9: ", "give an address such as 127.0.0.1"));
  EXPECT_TRUE(Throws<ParameterError>([] { TestRig<UdpPublisher<std::string>> rig({.name = "x"}); },
                                     "std::string holds no numbers", "Fields()"));
}

TEST(UdpPublisherTest, ADatagramHoldsOnlySoMuch) {
  const Peer peer;
  TestRig<UdpPublisher<Eigen::VectorXd>> rig({.name = "x", .port = peer.port()});
  rig.Fix(rig->u, Eigen::VectorXd::Constant(4000, -1.0 / 3));
  EXPECT_TRUE(Throws<RunError>([&] { rig.Tick(); }, "'block.send' failed at t = 0 s",
                               "a message of signal 'x' has ", "bytes, but a datagram holds at most 65507",
                               "in parts"));
}

TEST(UdpPublisherTest, CountsWhatTheSystemDoesNotTake) {
  const int nothing = open("/dev/null", O_RDONLY);
  const int next = dup(nothing);
  close(next);
  TestRig<UdpPublisher<double>> rig({.name = "x", .port = 9});
  ASSERT_EQ(dup2(nothing, next), next) << "in the place of the block's socket";
  rig.Fix(rig->u, 1).Tick().Tick();
  EXPECT_EQ(rig[rig->unsent], 2u);
  close(nothing);
}

TEST(UdpPublisherTest, NeedsAFile) {
  if (!AllocationGuard::Available()) GTEST_SKIP() << "sanitizers take files themselves";
  rlimit limit;
  getrlimit(RLIMIT_NOFILE, &limit);
  const rlimit none{0, limit.rlim_max};
  std::exception_ptr thrown;
  setrlimit(RLIMIT_NOFILE, &none);
  try {
    TestRig<UdpPublisher<double>> rig({.name = "x", .port = 9});
  } catch (...) {
    thrown = std::current_exception();
  }
  setrlimit(RLIMIT_NOFILE, &limit);
  ASSERT_TRUE(thrown);
  EXPECT_TRUE(Throws<RunError>([&] { std::rethrow_exception(thrown); }, "no socket for 127.0.0.1:9: "));
}

// ---- There and back ----

TEST(UdpTest, NumbersArriveAsTheyAre) {
  const Everything extreme = test::Extreme();
  EXPECT_EQ(Returned(extreme), extreme);
  for (const double x : {0.1, 1.0, 1e22, 123456789012345678.0, 9223372036854775808.0, 1.2345678901234568e20,
                         5e-324, -1.7976931348623157e308, -0.0, 0.0}) {
    const double y = Returned(x);
    EXPECT_EQ(std::memcmp(&x, &y, sizeof x), 0) << x << " arrives as " << y;
  }
}

// A publisher writes what JSON has no number for as a text.
TEST(UdpTest, NumbersThatAreNotFiniteAreRefused) {
  TestRig<UdpInput<double>> input({.name = "x", .port = 0});
  TestRig<UdpPublisher<double>> rig({.name = "x", .port = input->port()});
  rig.Fix(rig->u, 1).Tick();
  for (const double x : {kNan, kInfinity, -kInfinity}) rig.Fix(rig->u, x).Tick();
  EXPECT_EQ(input.Tick()[input->y], 1);
  EXPECT_EQ(input[input->refused].count, 3u);
  EXPECT_EQ(input[input->refused].reason, "'x' is a text, not a number");
}

TEST(UdpTest, WhatHasItsSizeAtRunTimeHasThatOfInitial) {
  Cloud initial = test::SomeCloud();
  initial.weights.setZero(), initial.basis.setZero(), initial.points[1].setZero(), initial.radius = 0;
  initial.text = "kept";
  const Cloud cloud = Returned(test::SomeCloud(), initial);
  EXPECT_EQ(cloud.weights, test::SomeCloud().weights);
  EXPECT_EQ(cloud.basis, test::SomeCloud().basis);
  EXPECT_EQ(cloud.points, test::SomeCloud().points);
  EXPECT_EQ(cloud.radius, test::SomeCloud().radius);
  EXPECT_EQ(cloud.text, "kept");
}

// ---- Receiving ----

TEST(UdpInputTest, TakesOverAtItsTicksWhatCameLast) {
  const Peer peer;
  TestRig<UdpInput<double>> rig({.name = "x", .initial = 7, .rate = Hz(10), .port = 0});
  rig.Tick();
  EXPECT_EQ(rig[rig->y], 7);
  peer.Send(rig->port(), R"({"timestamp":3,"x":1})");
  peer.Send(rig->port(), R"({"x":2,"timestamp":0.5})");
  rig.RunTo(0.05);
  EXPECT_EQ(rig[rig->y], 7) << "held between the ticks";
  rig.Tick();
  EXPECT_EQ(rig[rig->y], 2);
  rig.Tick();
  EXPECT_EQ(rig[rig->y], 2);
  EXPECT_EQ(rig[rig->refused].count, 0u);
}

/// Whether the system's buffer of the port runs empty without a tick; ten seconds are for ever.
bool RunsEmpty(int port) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  const std::string address = fmt::format("0100007F:{:04X} ", port);
  while (std::chrono::steady_clock::now() < end) {
    std::ifstream sockets("/proc/net/udp");
    for (std::string line; std::getline(sockets, line);) {
      const std::size_t queues = line.find(':', line.find(address) + address.size() + 14);
      if (line.find(address) != std::string::npos && line.substr(queues, 9) == ":00000000") return true;
    }
    std::this_thread::yield();
  }
  return false;
}

// A thousand messages for each tick are more than a socket's buffer holds, which drops what comes then.
TEST(UdpInputTest, TheNewestArrivesHoweverFastTheSender) {
  const Peer peer;
  TestRig<UdpInput<double>> rig({.name = "x", .rate = Hz(1), .port = 0});
  int sent = 0;
  for (const int messages : {1000, 5000}) {
    for (int i = 1; i <= messages; ++i) {
      peer.Send(rig->port(), fmt::format(R"({{"timestamp":0,"x":{}}})", ++sent));
      if (i % 50 == 0) {
        ASSERT_TRUE(RunsEmpty(rig->port()));
      }
    }
    rig.Tick();
    EXPECT_EQ(rig[rig->y], sent);
  }
  EXPECT_EQ(rig[rig->refused].count, 0u);
}

TEST(UdpInputTest, TakesFlatNamesAsWell) {
  const Peer peer;
  TestRig<UdpInput<Vec<2>>> rig(
      {.name = "robot.cart", .unit = "m, m/s", .elements = "position, velocity", .port = 0});
  peer.Send(rig->port(), R"({"robot.cart.velocity":2,"timestamp":0,"robot.cart.position":1})");
  rig.Tick();
  EXPECT_EQ(rig[rig->y], Vec<2>(1, 2));
  peer.Send(rig->port(), R"({"timestamp":0,"robot":{"cart":{"velocity":4,"position":3}}})");
  rig.Tick();
  EXPECT_EQ(rig[rig->y], Vec<2>(3, 4));
}

TEST(UdpInputTest, RefusesWhatIsNoMessageOfTheSignalAndSaysWhy) {
  const Peer peer;
  struct Mixed {
    double d = 0;
    float f = 0;
    std::uint8_t u = 0;
    bool b = false;
    static FieldList Fields() {
      return {{"d", &Mixed::d}, {"f", &Mixed::f}, {"u", &Mixed::u}, {"b", &Mixed::b}};
    }
  };
  TestRig<UdpInput<Mixed>> rig({.name = "x", .port = 0});
  std::uint64_t count = 0;
  const auto reason = [&](const std::string& message) {
    peer.Send(rig->port(), R"({"timestamp":0,"x":{"d":1.5,"f":2,"u":3,"b":true}})");
    peer.Send(rig->port(), message);
    rig.Tick();
    const auto& refused = rig[rig->refused];
    EXPECT_EQ(refused.count, ++count) << message;
    const Mixed& y = rig[rig->y];
    EXPECT_TRUE(y.d == 1.5 && y.f == 2 && y.u == 3 && y.b) << message;
    return refused.reason;
  };
  EXPECT_EQ(reason(""), "invalid JSON before byte 1");
  EXPECT_EQ(reason("hello"), "invalid JSON before byte 1");
  EXPECT_EQ(reason(R"({"timestamp":0,"x":{"d":9,"f":9,"u":9,"b":false)"), "invalid JSON before byte 48");
  EXPECT_EQ(reason(R"({"timestamp":0,"x":{"d":9,"f":9,"u":9,"b":false}} and more)"),
            "invalid JSON before byte 51");
  EXPECT_EQ(reason("5"), "the message is not a JSON object");
  EXPECT_EQ(reason("[1, 2]"), "'' is a list, not a number");
  EXPECT_EQ(reason(std::string(20000, '[')), "'' is a list, not a number");
  EXPECT_EQ(reason(R"({"timestamp":0})"), "'x.d' is missing");
  EXPECT_EQ(reason(R"({"x":{"d":9,"f":9,"u":9,"b":0}})"), "'timestamp' is missing");
  EXPECT_EQ(reason(R"({"timestamp":0,"x":{"d":9,"f":9,"u":9,"b":0,"e":1}})"),
            "the signal has no element 'x.e'");
  EXPECT_EQ(reason(R"({"timestamp":0,"y":1})"), "the signal has no element 'y'");
  EXPECT_EQ(reason(R"({"timestamp":0,"x":{"d":9,"d":8}})"), "'x.d' is given twice");
  EXPECT_EQ(reason(R"({"timestamp":0,"x":{"d":null}})"), "'x.d' is null");
  EXPECT_EQ(reason(R"({"timestamp":0,"x":{"d":"9"}})"), "'x.d' is a text, not a number");
  EXPECT_EQ(reason(R"({"timestamp":0,"x":{"d":[9]}})"), "'x.d' is a list, not a number");
  EXPECT_EQ(reason(R"({"timestamp":0,"x":{"d":1,"f":1e39,"u":9,"b":0}})"),
            "'x.f' = 1e+39 does not fit the type of its element");
  EXPECT_EQ(reason(R"({"timestamp":0,"x":{"d":1,"f":1,"u":256,"b":0}})"),
            "'x.u' = 256 does not fit the type of its element");
  EXPECT_EQ(reason(R"({"timestamp":0,"x":{"d":1,"f":1,"u":-1,"b":0}})"),
            "'x.u' = -1 does not fit the type of its element");
  EXPECT_EQ(reason(R"({"timestamp":0,"x":{"d":1,"f":1,"u":1.5,"b":0}})"),
            "'x.u' = 1.5 does not fit the type of its element");
  for (const char* text : {"NaN", "Infinity", "-Infinity", "nan", "inf", "-inf"}) {
    EXPECT_EQ(reason(fmt::format(R"({{"timestamp":0,"x":{{"d":"{}","f":1,"u":1,"b":0}}}})", text)),
              "'x.d' is a text, not a number");
    EXPECT_EQ(reason(fmt::format(R"({{"timestamp":"{}","x":{{"d":1,"f":1,"u":1,"b":0}}}})", text)),
              "'timestamp' is a text, not a number");
    EXPECT_THAT(reason(fmt::format(R"({{"timestamp":0,"x":{{"d":{},"f":1,"u":1,"b":0}}}})", text)),
                testing::StartsWith("invalid JSON"));
  }
  EXPECT_THAT(reason(R"({"timestamp":0,"x":{"d":1e999,"f":1,"u":1,"b":0}})"),
              testing::StartsWith("invalid JSON"));
  EXPECT_EQ(reason(R"({"timestamp":0,"x":{"d":1,"f":1,"u":1,"b":2}})"),
            "'x.b' = 2 does not fit the type of its element");
  // As kinds of numbers go into one another.
  peer.Send(rig->port(), R"({"timestamp":0,"x":{"d":true,"f":2.5,"u":4.0,"b":1}})");
  rig.Tick();
  EXPECT_TRUE(rig[rig->y].d == 1 && rig[rig->y].f == 2.5 && rig[rig->y].u == 4 && rig[rig->y].b);
}

TEST(UdpInputTest, RefusesAnEnumerationsValueWithoutName) {
  const Peer peer;
  TestRig<UdpInput<test::Leg>> rig({.name = "leg", .port = 0});
  peer.Send(rig->port(), R"({"timestamp":0,"leg":{"phase":1,"p_W":{"x":0,"y":0,"z":0}}})");
  peer.Send(rig->port(), R"({"timestamp":0,"leg":{"phase":9,"p_W":{"x":0,"y":0,"z":0}}})");
  rig.Tick();
  EXPECT_EQ(rig[rig->refused].reason, "'leg.phase' = 9 must be one of 0 (stance), 1 (swing)");
  EXPECT_EQ(rig[rig->y].phase, test::Phase::kSwing);
}

TEST(UdpInputTest, RefusesWhatItCannotOpen) {
  const Peer peer;
  const std::string port = std::to_string(peer.port());
  EXPECT_TRUE(
      Throws<ParameterError>([&] { TestRig<UdpInput<double>> rig({.name = "x", .port = peer.port()}); },
                             "block 'block': cannot receive at 127.0.0.1:" + port,
                             "choose another port, 0 for any, or end the program that uses it"));
  EXPECT_TRUE(Throws<ParameterError>(
      [] { TestRig<UdpInput<double>> rig({.name = "x", .address = "192.0.2.1", .port = 0}); },
      "cannot receive at 192.0.2.1:0", "give an address of this machine"));
  EXPECT_TRUE(Throws<ParameterError>(
      [] { TestRig<UdpInput<double>> rig({.name = "x", .address = "no address", .port = 9}); },
      "address = 'no address', port 9", "give an address such as 127.0.0.1"));
  EXPECT_TRUE(Throws<ParameterError>([] { TestRig<UdpInput<double>> rig({.name = "x", .port = 65536}); },
                                     "port = 65536 must be 0 to 65535"));
  EXPECT_TRUE(Throws<ParameterError>([] { TestRig<UdpInput<double>> rig({.port = 0}); }, "name is empty"));
  EXPECT_TRUE(
      Throws<ParameterError>([] { TestRig<UdpInput<double>> rig({.name = "x", .port = 0, .timeout_s = 0}); },
                             "timeout_s = 0 must be positive and finite"));
  EXPECT_TRUE(Throws<ParameterError>([] { TestRig<UdpInput<std::string>> rig({.name = "x", .port = 0}); },
                                     "std::string holds no numbers"));
}

TEST(UdpInputTest, KnowsIpv6) {
  try {
    TestRig<UdpInput<double>> input({.name = "x", .address = "::1", .port = 0});
    TestRig<UdpPublisher<double>> rig({.name = "x", .address = "::1", .port = input->port()});
    rig.Fix(rig->u, 5).Tick();
    EXPECT_EQ(input.Tick()[input->y], 5);
  } catch (const Error& error) {
    GTEST_SKIP() << "this machine has no IPv6: " << error.what();
  }
}

// ---- Lock-step ----

TEST(UdpInputTest, InLockStepTakesTheMessageOfItsTick) {
  const Peer peer;
  TestRig<UdpInput<double>> rig({.name = "x", .rate = Hz(10), .port = 0, .lock_step = true});
  // A sender may be ahead.
  for (const char* message : {R"({"timestamp":0,"x":1})", "nonsense", R"({"timestamp":0.1,"x":2})",
                              R"({"timestamp":0.1,"x":3})", R"({"timestamp":0.2,"x":4})"}) {
    peer.Send(rig->port(), message);
  }
  EXPECT_EQ(rig.Tick()[rig->y], 1);
  EXPECT_EQ(rig.Tick()[rig->y], 2);
  EXPECT_EQ(rig.Tick()[rig->y], 4) << "that of 0.1 s is past";
  EXPECT_EQ(rig[rig->refused].count, 1u);
}

TEST(UdpInputTest, ALockStepThatIsLostEndsTheRun) {
  const Peer peer;
  const UdpInputParams<double> params{
      .name = "x", .rate = Hz(10), .port = 0, .lock_step = true, .timeout_s = 1e-3};
  TestRig<UdpInput<double>> none(params);
  const std::string address = "signal 'x' at UDP 127.0.0.1:" + std::to_string(none->port());
  EXPECT_TRUE(Throws<RunError>([&] { none.Tick(); }, "'block.y' failed at t = 0 s: " + address,
                               "no message of t = 0 s within 0.001 s (none came)",
                               "start the sender after this one", "increase timeout_s"));

  TestRig<UdpInput<double>> past(params);
  peer.Send(past->port(), R"({"timestamp":0,"x":1})");
  past.Tick();
  peer.Send(past->port(), R"({"timestamp":0.05,"x":1})");
  peer.Send(past->port(), "{}");
  EXPECT_TRUE(Throws<RunError>([&] { past.Tick(); }, "no message of t = 0.1 s",
                               "(the last one has t = 0.05 s; 1 were refused: 'x' is missing)"));

  TestRig<UdpInput<double>> future(params);
  peer.Send(future->port(), R"({"timestamp":0.1,"x":1})");
  EXPECT_TRUE(Throws<RunError>([&] { future.Tick(); },
                               "the message of t = 0 s was lost, the next one has t = 0.1 s",
                               "the same rate"));
}

// ---- Recording ----

struct Pushed {
  DiagramBuilder builder;
  Cart* cart = &builder.Add<Cart>("cart");
  UdpInput<double>* input;
  explicit Pushed(UdpInputParams<double> params)
      : input(&builder.Add<UdpInput<double>>("input", std::move(params))) {
    builder.Connect(input->y, cart->force);
  }
};

TEST(UdpInputTest, ARecordedRunReplaysBitForBit) {
  const Peer peer;
  Pushed pushed({.name = "force", .unit = "N", .port = 0, .record = true});
  Simulator simulator(pushed.builder.Build());
  for (int i = 0; i < 10; ++i) {
    peer.Send(pushed.input->port(), fmt::format(R"({{"timestamp":0,"force":{}}})", 0.1 * i));
    simulator.RunTo(0.0371 * (i + 1));
  }
  const auto recording = simulator.context().Eval(pushed.input->taken).recording;
  ASSERT_EQ(recording.size(), 10u);

  // The port stays shut: the one of the run is still open.
  Pushed again({.name = "force", .unit = "N", .port = pushed.input->port(), .replay = recording});
  Simulator replay(again.builder.Build());
  replay.RunTo(0.371);
  EXPECT_EQ(replay.context().Eval(again.cart->x), simulator.context().Eval(pushed.cart->x));
  EXPECT_EQ(again.input->port(), pushed.input->port());
}

TEST(UdpInputTest, ASnapshotHasWhatWasTakenAndRefused) {
  const Peer peer;
  TestRig<UdpInput<double>> rig({.name = "x", .rate = Hz(10), .port = 0, .record = true});
  peer.Send(rig->port(), R"({"timestamp":0,"x":1})");
  peer.Send(rig->port(), "{}");
  rig.Tick();
  const auto saved = rig.context().Save();
  peer.Send(rig->port(), R"({"timestamp":0,"x":2})");
  rig.Tick();
  EXPECT_EQ(rig[rig->taken].recording.size(), 2u);
  rig.context().Restore(saved);
  EXPECT_EQ(rig[rig->taken].recording.size(), 1u);
  EXPECT_EQ(rig[rig->refused].reason, "'x' is missing");
  EXPECT_EQ(rig[rig->y], 1);
}

}  // namespace
}  // namespace tenon::udp_test
