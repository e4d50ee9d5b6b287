#include <tenon/systems/network/udp.h>
#include <tenon/systems/primitives/constant.h>
#include <tenon/tests/systems/framework/test_blocks.h>
#include <tenon/tests/systems/network/peer.h>
#include <tenon/tests/systems/network/signals.h>

#include <fcntl.h>
#include <fmt/core.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>

#include <fstream>
#include <thread>

namespace tenon::udp_test {

using test::Cloud, test::Everything, test::Peer;

using test::kInfinity, test::kNan;

template <class T>
std::string Sent(const T& value) {
  const Peer peer;
  TestRig<UdpPublisher<T>> rig({.name = "x", .port = peer.port()});
  rig.Fix(rig->u, value).Tick();
  return peer.Receive();
}

/// A value after it was sent and received; `initial` has its shape.
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

TEST(UdpPublisherTest, WritesNumbersAndNamesThatJsonDoesNotHave) {
  EXPECT_EQ(Sent(Vec<3>(kNan, kInfinity, -kInfinity)),
            R"({"timestamp":0,"x":{"x":"NaN","y":"Infinity","z":"-Infinity"}})");
  EXPECT_EQ(Sent(-0.0), R"({"timestamp":0,"x":-0.0})");
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
  const Peer peer;
  TestRig<UdpPublisher<Cloud>> rig({.name = "a signal with a long name", .port = peer.port()});
  rig.Fix(rig->u, test::SomeCloud()).Tick().Tick();
  EXPECT_EQ(AllocationsOf([&] { rig.RunTo(1); }), 0);
}

TEST(UdpPublisherTest, RefusesWhatItCannotSend) {
  using Publisher = UdpPublisher<double>;
  EXPECT_TRUE(Refuses<Publisher>({}, "name"));
  EXPECT_TRUE(Refuses<Publisher>({.name = "timestamp"}, "'timestamp'"));
  EXPECT_TRUE(Refuses<Publisher>({.name = "x", .port = 0}, "port = 0"));
  EXPECT_TRUE(Refuses<Publisher>({.name = "x", .address = "no address", .port = 9}, "'no address'"));
  EXPECT_TRUE(Refuses<UdpPublisher<std::string>>({.name = "x"}, "Fields()"));
}

TEST(UdpPublisherTest, ADatagramHoldsOnlySoMuch) {
  const Peer peer;
  TestRig<UdpPublisher<Eigen::VectorXd>> rig({.name = "x", .port = peer.port()});
  rig.Fix(rig->u, Eigen::VectorXd::Constant(4000, -1.0 / 3));
  EXPECT_TRUE(Throws<RunError>([&] { rig.Tick(); }, "'block.send'", "t = 0 s", "'x'"));
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
  EXPECT_TRUE(Throws<RunError>([&] { std::rethrow_exception(thrown); }, "127.0.0.1:9"));
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

// JSON has no numbers that are not finite: a publisher writes them as text.
TEST(UdpTest, NumbersThatAreNotFiniteAreRefused) {
  TestRig<UdpInput<double>> input({.name = "x", .port = 0});
  TestRig<UdpPublisher<double>> rig({.name = "x", .port = input->port()});
  rig.Fix(rig->u, 1).Tick();
  for (const double x : {kNan, kInfinity, -kInfinity}) rig.Fix(rig->u, x).Tick();
  EXPECT_EQ(input.Tick()[input->y], 1);
  EXPECT_EQ(input[input->refused].count, 3u);
  EXPECT_THAT(input[input->refused].reason, testing::HasSubstr("'x'"));
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

/// Waits until the system's buffer of the port is empty; false after ten seconds.
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

// A thousand messages between two ticks: the buffer of a socket would overflow and drop the newest ones.
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
  const auto expect = [&](const std::string& message, const char* part) {
    EXPECT_THAT(reason(message), testing::HasSubstr(part)) << message;
  };
  expect("", "byte 1");
  expect("hello", "byte 1");
  expect(R"({"timestamp":0,"x":{"d":9,"f":9,"u":9,"b":false)", "byte 48");
  expect(R"({"timestamp":0,"x":{"d":9,"f":9,"u":9,"b":false}} and more)", "byte 51");
  expect("5", "object");
  expect("[1, 2]", "a list");
  expect(std::string(20000, '['), "a list");
  expect(R"({"x":{"d":9,"f":9,"u":9,"b":0}})", "'timestamp' is missing");
  expect(R"({"timestamp":0})", "'x.d' is missing");
  expect(R"({"timestamp":0,"y":1})", "'y'");
  // Members of x that are wrong, and the element in the message.
  const std::pair<const char*, const char*> wrong[] = {{R"("d":9,"f":9,"u":9,"b":0,"e":1)", "'x.e'"},
                                                       {R"("d":9,"d":8)", "'x.d' is given twice"},
                                                       {R"("d":null)", "'x.d'"},
                                                       {R"("d":"9")", "'x.d'"},
                                                       {R"("d":[9])", "'x.d'"},
                                                       {R"("d":1,"f":1e39,"u":9,"b":0)", "'x.f' = 1e+39"},
                                                       {R"("d":1,"f":1,"u":256,"b":0)", "'x.u' = 256"},
                                                       {R"("d":1,"f":1,"u":-1,"b":0)", "'x.u' = -1"},
                                                       {R"("d":1,"f":1,"u":1.5,"b":0)", "'x.u' = 1.5"},
                                                       {R"("d":1,"f":1,"u":1,"b":2)", "'x.b' = 2"},
                                                       {R"("d":1e999,"f":1,"u":1,"b":0)", "byte 29"}};
  for (const auto& [members, part] : wrong)
    expect(fmt::format(R"({{"timestamp":0,"x":{{{}}}}})", members), part);
  for (const char* text : {"NaN", "Infinity", "-Infinity", "nan", "inf", "-inf"}) {
    expect(fmt::format(R"({{"timestamp":0,"x":{{"d":"{}","f":1,"u":1,"b":0}}}})", text), "'x.d' is a text");
    expect(fmt::format(R"({{"timestamp":"{}","x":{{"d":1,"f":1,"u":1,"b":0}}}})", text),
           "'timestamp' is a text");
    expect(fmt::format(R"({{"timestamp":0,"x":{{"d":{},"f":1,"u":1,"b":0}}}})", text), "byte 2");
  }
  // Numbers are converted where the element can hold them.
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
  EXPECT_THAT(rig[rig->refused].reason, testing::ContainsRegex("'leg.phase' = 9.*0 .stance., 1 .swing."));
  EXPECT_EQ(rig[rig->y].phase, test::Phase::kSwing);
}

TEST(UdpInputTest, RefusesWhatItCannotOpen) {
  const Peer peer;
  using Input = UdpInput<double>;
  EXPECT_TRUE(Refuses<Input>({.name = "x", .port = peer.port()}, "127.0.0.1:" + std::to_string(peer.port())));
  EXPECT_TRUE(Refuses<Input>({.name = "x", .address = "192.0.2.1", .port = 0}, "192.0.2.1:0"));
  EXPECT_TRUE(Refuses<Input>({.name = "x", .address = "no address", .port = 9}, "'no address'"));
  EXPECT_TRUE(Refuses<Input>({.name = "x", .port = 65536}, "port = 65536"));
  EXPECT_TRUE(Refuses<Input>({.port = 0}, "name"));
  EXPECT_TRUE(Refuses<Input>({.name = "x", .port = 0, .timeout_s = 0}, "timeout_s = 0"));
  EXPECT_TRUE(Refuses<UdpInput<std::string>>({.name = "x", .port = 0}, "std::string"));
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

/// Messages of another tick, without end.
class Flood final : public internal::Inbox {
 public:
  Flood() : Inbox({.lock_step = true, .timeout_s = 0.01}) {}

 private:
  std::optional<std::span<const char>> Receive(double) override { return std::span<const char>("-1", 2); }
  std::string Read(std::span<const char>, double* timestamp, void*) override {
    if (++count_ == 10'000'000) throw std::logic_error("the timeout has passed");
    *timestamp = -1;
    return "";
  }
  std::string Description() const override { return "a flood"; }
  long count_ = 0;
};

TEST(InboxTest, AFloodOutlivesNoTimeout) {
  Flood flood;
  double value = 0;
  RefusedMessages refused;
  EXPECT_TRUE(Throws<RunError>([&] { flood.Take(0, &value, refused); }, "a flood", "within 0.01 s"));
}

TEST(UdpInputTest, ALockStepThatIsLostEndsTheRun) {
  const Peer peer;
  const UdpInputParams<double> params{
      .name = "x", .rate = Hz(10), .port = 0, .lock_step = true, .timeout_s = 1e-3};
  TestRig<UdpInput<double>> none(params);
  const std::string address = "signal 'x' at UDP 127.0.0.1:" + std::to_string(none->port());
  EXPECT_TRUE(Throws<RunError>([&] { none.Tick(); }, "'block.y' failed at t = 0 s: " + address, "t = 0 s"));

  TestRig<UdpInput<double>> past(params);
  peer.Send(past->port(), R"({"timestamp":0,"x":1})");
  past.Tick();
  peer.Send(past->port(), R"({"timestamp":0.05,"x":1})");
  peer.Send(past->port(), "{}");
  EXPECT_TRUE(Throws<RunError>([&] { past.Tick(); }, "t = 0.1 s", "'x'", "t = 0.05 s"));

  TestRig<UdpInput<double>> future(params);
  peer.Send(future->port(), R"({"timestamp":0.1,"x":1})");
  EXPECT_TRUE(Throws<RunError>([&] { future.Tick(); }, "t = 0 s", "t = 0.1 s"));
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

  // A replay does not open the port, which is still in use.
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

}  // namespace tenon::udp_test
