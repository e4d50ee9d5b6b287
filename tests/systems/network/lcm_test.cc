#include <tenon/systems/network/internal/lcm_bus.h>
#include <tenon/systems/network/lcm.h>
#include <tenon/tests/systems/framework/test_blocks.h>
#include <tenon/tests/systems/network/peer.h>
#include <tenon/tests/systems/network/signals.h>
#include <tenon/tests/testing/temporary_path.h>

#include <lcm/lcm.h>
#include <tenon_test/EverythingSample.hpp>
#include <tenon_test/Vec_2Sample.hpp>
#include <tenon_test_cloud/CloudSample.hpp>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <random>
#include <span>
#include <thread>

namespace tenon::lcm_test {

using internal::LcmBus;
using internal::LcmType;
using internal::TypeInfoOf;
using test::Cloud;
using test::Everything;

/// A connection within this program.
const std::string kUrl = "memq://";

template <class T>
std::vector<char> Encoded(const T& value, double timestamp) {
  std::vector<char> message;
  LcmType(TypeInfoOf<T>()).Encode(timestamp, &value, message);
  return message;
}

/// A message encoded by the code that lcm-gen generates.
template <class Message>
std::vector<char> EncodedByLcm(const Message& message) {
  std::vector<char> bytes(static_cast<std::size_t>(message.getEncodedSize()));
  EXPECT_EQ(message.encode(bytes.data(), 0, static_cast<int>(bytes.size())), bytes.size());
  return bytes;
}

std::string Described(const std::string& file) {
  return test::FileText(TENON_LCM_TYPES + ("/" + file));
}

// ---- The type ----

// lcm-gen generates code from these files.
TEST(LcmTypeTest, IsDescribedAsLcmGenReadsIt) {
  EXPECT_EQ(LcmTypeOf<Everything>("tenon_test"), Described("everything.lcm"));
  EXPECT_EQ(LcmTypeOf<Cloud>("tenon_test_cloud"), Described("cloud.lcm"));
  EXPECT_EQ(LcmTypeOf<Vec<2>>("tenon_test"), Described("vec_2.lcm"));
}

TEST(LcmTypeTest, HasTheFingerprintThatLcmGenComputes) {
  const auto fingerprint = []<class T>(const T&) {
    return static_cast<std::int64_t>(LcmType(TypeInfoOf<T>()).fingerprint());
  };
  EXPECT_EQ(fingerprint(Everything()), tenon_test::EverythingSample::getHash());
  EXPECT_EQ(fingerprint(Cloud()), tenon_test_cloud::CloudSample::getHash());
  EXPECT_EQ(fingerprint(Vec<2>()), tenon_test::Vec_2Sample::getHash());
}

TEST(LcmTypeTest, NamesAreIdentifiers) {
  EXPECT_THAT(LcmTypeOf<double>("p"), testing::StartsWith("package p;\n\nstruct doubleSample {"));
  EXPECT_THAT(LcmTypeOf<Recorded<Vec<3>>>("p"), testing::HasSubstr("struct Recorded_Vec_3 {"));
  struct Odd {
    double first = 0, second = 0;
    static FieldList Fields() { return {{"2nd value [m]", &Odd::second, "m"}, {"a b", &Odd::first}}; }
  };
  EXPECT_THAT(LcmTypeOf<Odd>("p"), testing::HasSubstr("{\n  double _2nd_value_m;  // m\n  double a_b;\n}"));
}

TEST(LcmTypeTest, RowsAndColumnsMayVaryAlone) {
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, 2>;
  using Columns = Eigen::Matrix<double, 2, Eigen::Dynamic>;
  EXPECT_THAT(LcmTypeOf<Rows>("p"),
              testing::HasSubstr("int32_t value_rows;\n  double value[value_rows][2];"));
  EXPECT_THAT(LcmTypeOf<Columns>("p"),
              testing::HasSubstr("int32_t value_cols;\n  double value[2][value_cols];"));
  Columns value(2, 3), back(2, 3);
  value << 1, 2, 3, 4, 5, 6;
  back.setZero();
  double timestamp = 0;
  EXPECT_EQ(LcmType(TypeInfoOf<Columns>()).Decode(Encoded(value, 0.5), &timestamp, &back), "");
  EXPECT_EQ(back, value);
  EXPECT_EQ(timestamp, 0.5);
}

/// A tree.
struct Node {
  double value = 0;
  std::vector<Node> children;
  static FieldList Fields() { return {{"value", &Node::value}, {"children", &Node::children}}; }
};
namespace other {
struct Leg {
  double length = 0;
  static FieldList Fields() { return {{"length", &Leg::length}}; }
};
}  // namespace other
struct TwoLegs {
  test::Leg one;
  other::Leg two;
  static FieldList Fields() { return {{"one", &TwoLegs::one}, {"two", &TwoLegs::two}}; }
};

TEST(LcmTypeTest, RefusesWhatLcmDoesNotHave) {
  EXPECT_TRUE(Throws<ParameterError>([] { LcmTypeOf<std::string>("p"); }, "Fields()"));
  EXPECT_TRUE(Throws<ParameterError>([] { LcmTypeOf<std::vector<std::vector<double>>>("p"); }, "'value'"));
  EXPECT_TRUE(Throws<ParameterError>([] { LcmTypeOf<std::array<Eigen::VectorXd, 2>>("p"); }, "'value'"));
  EXPECT_TRUE(Throws<ParameterError>([] { LcmTypeOf<Node>("p"); }, "Node"));
  EXPECT_TRUE(Throws<ParameterError>([] { LcmTypeOf<TwoLegs>("p"); }, "Leg"));
}

// ---- Messages ----

TEST(LcmTypeTest, MessagesAreThoseOfLcmGen) {
  const Everything e = test::Extreme();
  tenon_test::EverythingSample sample;
  sample.timestamp = 0.25;
  auto& value = sample.value;
  value.on = 1, value.heat = e.heat;
  value.i8 = e.i8, value.i16 = e.i16, value.i32 = e.i32, value.i64 = e.i64;
  value.u16 = e.u16, value.u32 = e.u32, value.u64 = -1;
  for (int r = 0; r < 2; ++r) {
    for (int c = 0; c < 3; ++c) value.A[r][c] = e.A(r, c);
    value.pair[r] = e.pair[static_cast<std::size_t>(r)];
    value.legs[r].phase = static_cast<std::uint8_t>(r);
    for (int i = 0; i < 3; ++i) value.legs[r].p_W[i] = e.legs[static_cast<std::size_t>(r)].p_W[i];
  }
  EXPECT_EQ(Encoded(e, 0.25), EncodedByLcm(sample));

  Everything back;
  double timestamp = 0;
  EXPECT_EQ(LcmType(TypeInfoOf<Everything>()).Decode(EncodedByLcm(sample), &timestamp, &back), "");
  EXPECT_EQ(timestamp, 0.25);
  EXPECT_EQ(back, e);
}

TEST(LcmTypeTest, SizesTravelToo) {
  const Cloud cloud = test::SomeCloud();
  const auto message = Encoded(cloud, 1);
  tenon_test_cloud::CloudSample sample;
  ASSERT_EQ(sample.decode(message.data(), 0, static_cast<int>(message.size())), message.size());
  EXPECT_EQ(sample.value.weights, (std::vector<double>{1, 2}));
  EXPECT_EQ(sample.value.basis, (std::vector<std::vector<double>>{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_EQ(sample.value.points, (std::vector<std::vector<double>>{{1, 2, 3}, {4, 5, 6}}));
  EXPECT_EQ(sample.value.legs_size, 1);
  EXPECT_EQ(sample.value.radius, std::vector<double>{0.5});
  EXPECT_EQ(EncodedByLcm(sample), message);
}

TEST(LcmTypeTest, SaysWhyItRefusesAMessage) {
  Everything value;
  double timestamp = 7;
  const auto reason = [&](const std::vector<char>& message) {
    const std::string reason = LcmType(TypeInfoOf<Everything>()).Decode(message, &timestamp, &value);
    EXPECT_TRUE(value == Everything() && timestamp == 7) << "nothing is stored";
    return reason;
  };
  std::vector<char> message = Encoded(test::Extreme(), 0);
  EXPECT_THAT(reason(Encoded(Vec<2>(1, 2), 0)), testing::ContainsRegex("EverythingSample.* 0x.* 0x"));
  EXPECT_THAT(reason({}), testing::HasSubstr("0 bytes"));
  EXPECT_THAT(reason({message.begin(), message.end() - 1}),
              testing::HasSubstr(std::to_string(message.size() - 1) + " bytes"));
  message.push_back(0);
  EXPECT_THAT(reason(message), testing::HasSubstr("longer"));
  message.pop_back();
  message[16] = 2;  // fingerprint and timestamp are in front
  EXPECT_THAT(reason(message), testing::HasSubstr("'on'"));
  test::Leg leg;
  EXPECT_THAT(LcmType(TypeInfoOf<test::Leg>())
                  .Decode(Encoded(test::Leg{.phase = static_cast<test::Phase>(9)}, 0), &timestamp, &leg),
              testing::ContainsRegex("'phase' = 9.*0 .stance., 1 .swing."));
  EXPECT_EQ(leg, test::Leg());
  Cloud cloud = test::SomeCloud();
  cloud.weights.resize(3);
  EXPECT_THAT(LcmType(TypeInfoOf<Cloud>()).Decode(Encoded(test::SomeCloud(), 0), &timestamp, &cloud),
              testing::ContainsRegex("'weights_size'.* 2.* 3"));
}

// ---- Blocks ----

TEST(LcmTest, ASignalGoesFromBlockToBlock) {
  TestRig<LcmInput<Everything>> input({.channel = "a.b(c)", .url = kUrl, .rate = Hz(10)});
  TestRig<LcmInput<Vec<2>>> other({.channel = "a_b(c)", .url = kUrl});
  TestRig<LcmPublisher<Everything>> rig({.channel = "a.b(c)", .url = kUrl, .rate = Hz(10)});
  EXPECT_EQ(input.Tick()[input->y], Everything());
  rig.Fix(rig->u, Everything()).Tick();
  rig.Fix(rig->u, test::Extreme()).Tick();
  EXPECT_EQ(input.Tick()[input->y], test::Extreme()) << "the one that came last";
  EXPECT_EQ(input.Tick()[input->y], test::Extreme());
  other.Tick();
  EXPECT_EQ(other[other->refused].count, 0u);
  EXPECT_EQ(rig[rig->unsent], 0u);
}

// More messages than a queue of LCM holds: without care, LCM would drop the newest ones.
TEST(LcmTest, TheNewestArrivesHoweverFastTheSender) {
  TestRig<LcmInput<double>> input({.channel = "X", .url = kUrl, .rate = Hz(1)});
  TestRig<LcmPublisher<double>> rig({.channel = "X", .url = kUrl, .rate = Hz(10000)});
  for (int i = 1; i <= 6000; ++i) rig.Fix(rig->u, i).Tick();
  EXPECT_EQ(rig[rig->unsent], 0u);
  EXPECT_EQ(input.Tick()[input->y], 6000);
}

// LCM delivers the messages of all channels in the order of their arrival.
TEST(LcmTest, OneChannelDoesNotHoldUpAnother) {
  TestRig<LcmInput<double>> one({.channel = "A", .url = kUrl}), other({.channel = "B", .url = kUrl});
  TestRig<LcmPublisher<double>> to_one({.channel = "A", .url = kUrl}),
      to_other({.channel = "B", .url = kUrl});
  for (int i = 1; i <= 10; ++i) {
    to_one.Fix(to_one->u, i).Tick();
    to_other.Fix(to_other->u, -i).Tick();
  }
  EXPECT_EQ(one.Tick()[one->y], 10);
  EXPECT_EQ(other.Tick()[other->y], -10);
}

TEST(LcmTest, WhatIsOfAnotherTypeIsRefused) {
  TestRig<LcmInput<double>> input({.channel = "X", .url = kUrl, .initial = 3});
  TestRig<LcmPublisher<Vec<2>>> rig({.channel = "X", .url = kUrl});
  rig.Fix(rig->u, {1, 2}).Tick();
  EXPECT_EQ(input.Tick()[input->y], 3);
  EXPECT_EQ(input[input->refused].count, 1u);
  EXPECT_THAT(input[input->refused].reason, testing::HasSubstr("another type than doubleSample"));
}

// Bytes are changed, removed and added at random places.
TEST(LcmTest, DamagedMessagesEndNoRun) {
  TestRig<LcmInput<Everything>> input({.channel = "X", .url = kUrl, .rate = Hz(10)});
  const auto bus = LcmBus::Open(kUrl);
  const std::vector<char> good = Encoded(test::Extreme(), 0);
  std::mt19937 random(1);
  const auto below = [&](std::size_t limit) { return random() % limit; };
  for (int i = 0; i < 3000; ++i) {
    std::vector<char> message = good;
    for (std::size_t changes = 1 + below(3); changes > 0; --changes) {
      const std::size_t at = below(message.size());
      message[at] = static_cast<char>(below(256));
      if (below(3) == 0) message.resize(at + below(40));
      if (message.empty()) break;
    }
    EXPECT_TRUE(bus->Publish("X", message));
    if (i % 100 == 0) input.Tick();
  }
  EXPECT_GT(input.Tick()[input->refused].count, 1000u);
  EXPECT_TRUE(bus->Publish("X", good));
  EXPECT_EQ(input.Tick()[input->y], test::Extreme());
}

/// The datagrams of a message to the channel X, as LCM divides it into two fragments.
std::array<std::string, 2> Fragments(std::span<const char> message, std::uint32_t number) {
  const std::size_t half = message.size() / 2;
  const auto fragment = [&](std::uint16_t which, std::string_view channel, std::span<const char> part) {
    std::string text = "LC03";
    const auto append = [&](std::uint64_t value, int bytes) {
      while (bytes-- > 0) text += static_cast<char>(value >> (8 * bytes));
    };
    append(number, 4);
    append(message.size(), 4);
    append(which == 0 ? 0 : half, 4);
    append(which, 2);
    append(2, 2);
    return text.append(channel).append(part.begin(), part.end());
  };
  return {fragment(0, {"X", 2}, message.first(half)), fragment(1, "", message.subspan(half))};
}

// LCM 1.3.1 trusts the sizes in fragments.
TEST(LcmTest, DamagedDatagramsEndNoRun) {
  const test::Peer attacker, friendly;
  const int port = [] { return test::Peer().port(); }();  // a free one
  const auto bus = LcmBus::Open(fmt::format("udpm://239.255.76.67:{}?ttl=0", port));
  std::optional<LcmBus::Subscription> subscription;
  try {
    subscription.emplace(bus, "X", true);
  } catch (const ParameterError&) {
  }
  if (!subscription) GTEST_SKIP() << "LCM cannot receive: there is no multicast route";

  const std::vector<char> good = Encoded(test::Extreme(), 0);
  std::mt19937 random(1);
  const auto below = [&](std::size_t limit) { return random() % limit; };
  // While the receiver is busy, the kernel may lose any datagram.
  const auto arrives = [&](const std::vector<char>& expected, const auto& send) {
    for (int tries = 0; tries < 600; ++tries) {
      send();
      std::vector<char> message;
      while (subscription->Take(0.1, message))
        if (message == expected) return true;
    }
    return false;
  };
  for (std::uint32_t round = 0; round < 200; ++round) {
    for (int i = 0; i < 100; ++i) {
      std::string datagram = Fragments(good, round / 8)[below(2)];
      if (below(4) == 0) datagram.replace(0, 20, "LC02####");
      for (std::size_t changes = 1 + below(3); changes > 0; --changes) {
        const std::size_t at = below(std::min<std::size_t>(datagram.size(), 32));
        datagram[at] = "\0\1\2\x7f\x80\xff"[below(6)];
        if (below(4) == 0) datagram.resize(1 + at + below(100), '#');
      }
      attacker.Send(port, datagram);
    }
    ASSERT_TRUE(arrives(good, [&] {
      for (const std::string& datagram : Fragments(good, round)) friendly.Send(port, datagram);
    }));
  }
  const std::vector<char> large(100'000, 'x');  // in fragments that LCM makes
  EXPECT_TRUE(arrives(large, [&] { bus->Publish("X", large); }));
}

TEST(LcmTest, SendsWithoutAllocating) {
  if (!AllocationGuard::Available()) GTEST_SKIP() << "allocations are not counted in this build";
  std::vector<char> message;
  const LcmType type(TypeInfoOf<Cloud>());
  const Cloud cloud = test::SomeCloud();
  type.Encode(0, &cloud, message);
  const AllocationGuard guard;  // LCM itself allocates
  type.Encode(1, &cloud, message);
  EXPECT_EQ(guard.count(), 0);
}

// Both diagrams share one connection, and each wakes the other.
TEST(LcmTest, PlantAndControllerGoInLockStep) {
  const Rate rate = Hz(1000);
  DiagramBuilder plant, controller;
  auto& cart = plant.Add<Cart>("cart");
  auto& to_controller =
      plant.Add<LcmPublisher<Vec<2>>>("to_controller", {.channel = "CART", .url = kUrl, .rate = rate});
  auto& from_controller = plant.Add<LcmInput<double>>(
      "from_controller",
      {.channel = "FORCE", .url = kUrl, .rate = rate, .unit = "N", .lock_step = true, .timeout_s = 60});
  plant.Connect(cart.state, to_controller.u);
  plant.Connect(from_controller.y, cart.force);
  auto& pd = controller.Add<Pd>("pd", {.kp = 30});
  auto& ref = controller.AddFunction("ref", Uses(controller.time), [](double t) { return t; });
  auto& from_plant = controller.Add<LcmInput<Vec<2>>>(
      "from_plant", {.channel = "CART", .url = kUrl, .rate = rate, .lock_step = true, .timeout_s = 60});
  auto& to_plant =
      controller.Add<LcmPublisher<double>>("to_plant", {.channel = "FORCE", .url = kUrl, .rate = rate});
  controller.Connect(from_plant.y, pd.x);
  controller.Connect(ref, pd.ref);
  controller.Connect(pd.u, to_plant.u);
  Simulator run(plant.Build()), control(controller.Build());
  std::thread thread([&] { control.RunTo(0.5); });
  run.RunTo(0.5);
  thread.join();

  PdLoop both({.kp = 30});
  auto& both_ref = both.builder.AddFunction("ref", Uses(both.builder.time), [](double t) { return t; });
  both.builder.Connect(both_ref, both.pd.ref);
  Simulator together(both.builder.Build());
  together.RunTo(0.5);
  EXPECT_EQ(run.context().Eval(cart.x), together.context().Eval(both.cart.x));
}

TEST(LcmTest, ALockStepThatIsLostEndsTheRun) {
  TestRig<LcmInput<double>> input({.channel = "X", .url = kUrl, .lock_step = true, .timeout_s = 1e-3});
  EXPECT_TRUE(Throws<RunError>([&] { input.Tick(); }, "'block.y'", "'X'", "t = 0 s"));
}

// The log has the format of lcm-logger.
TEST(LcmTest, PublishesIntoALog) {
  const auto path = test::TemporaryPath("lcm_test.log");
  {
    TestRig<LcmPublisher<Vec<2>>> rig({.channel = "X", .url = "file://" + path.string() + "?mode=w"});
    rig.Fix(rig->u, {1, 2}).Tick().Tick();
    EXPECT_EQ(rig[rig->unsent], 0u);
  }
  lcm_eventlog_t* log = lcm_eventlog_create(path.c_str(), "r");
  ASSERT_NE(log, nullptr);
  for (const double time : {0.0, 0.01}) {
    lcm_eventlog_event_t* event = lcm_eventlog_read_next_event(log);
    ASSERT_NE(event, nullptr);
    EXPECT_STREQ(event->channel, "X");
    tenon_test::Vec_2Sample sample;
    EXPECT_EQ(sample.decode(event->data, 0, event->datalen), event->datalen);
    EXPECT_EQ(sample.timestamp, time);
    EXPECT_EQ(sample.value[1], 2);
    lcm_eventlog_free_event(event);
  }
  EXPECT_EQ(lcm_eventlog_read_next_event(log), nullptr);
  lcm_eventlog_destroy(log);
  std::filesystem::remove(path);
}

TEST(LcmTest, RefusesWhatItCannotOpen) {
  EXPECT_TRUE(Refuses<LcmPublisher<double>>({}, "channel = ''"));
  EXPECT_TRUE(Refuses<LcmInput<double>>({.channel = std::string(64, 'x')}, "1 to 63 characters"));
  EXPECT_TRUE(Refuses<LcmPublisher<double>>({.channel = "X", .url = "no provider"}, "url = 'no provider'"));
  EXPECT_TRUE(Refuses<LcmInput<std::string>>({.channel = "X", .url = kUrl}, "std::string"));
  EXPECT_TRUE(Refuses<LcmInput<double>>({.channel = "X", .url = kUrl, .timeout_s = -1}, "timeout_s = -1"));
}

}  // namespace tenon::lcm_test
