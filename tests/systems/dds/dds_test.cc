#include <tenon/tests/systems/dds/dds_peer.h>
#include <tenon/tests/systems/framework/test_blocks.h>

#include <cart.h>

namespace tenon {

struct CartSignal {
  double position = 0, speed = 0;
  static FieldList Fields() {
    return {{"position", &CartSignal::position, "m"}, {"speed", &CartSignal::speed, "m/s"}};
  }
  bool operator==(const CartSignal&) const = default;
};

namespace dds_test {

void Write(const CartSignal& signal, tenon_test_Cart_& message) {
  message = {signal.position, signal.speed};
}
std::string Read(const tenon_test_Cart_& message, CartSignal& signal) {
  signal = {message.position, message.speed};
  return message.speed > 100 ? "too fast" : "";
}

}  // namespace dds_test

template <>
struct DdsMessageOf<CartSignal> {
  static const DdsMessage& Get() {
    static const auto kMessage =
        MakeDdsMessage<tenon_test_Cart_, CartSignal, dds_test::Write, dds_test::Read>(&tenon_test_Cart__desc);
    return kMessage;
  }
};

namespace dds_test {

using Input = DdsInput<CartSignal>;
using Publisher = DdsPublisher<CartSignal>;
using test::DdsPeer, test::kOwnLink;

/// Not that of a test in the same domain, which the number of a process may repeat.
const std::string kTopic = "rt/cart_" + std::to_string(getpid());
const DdsInputParams<CartSignal> kInput{.topic = kTopic, .link = kOwnLink, .rate = Hz(10)};
const DdsPublisherParams kPublisher{.topic = kTopic, .link = kOwnLink, .rate = Hz(10)};

TEST(DdsTest, NumbersArriveAsTheyAreAndTheLastCounts) {
  TestRig<Input> input(kInput);
  TestRig<Publisher> publisher(kPublisher);
  publisher.Fix(publisher->u, {1, 2}).Tick();
  publisher.Fix(publisher->u, {0.1, -1e-300}).Tick();
  EXPECT_EQ(input.Tick()[input->y], (CartSignal{0.1, -1e-300}));
  EXPECT_EQ(input.Tick()[input->y], (CartSignal{0.1, -1e-300})) << "held";
  EXPECT_EQ(input[input->taken].number, 1u);
  EXPECT_EQ(input[input->refused].count, 0u);
  EXPECT_EQ(publisher[publisher->unsent], 0u);
}

TEST(DdsInputTest, AValueExpiresWithoutMessages) {
  DdsInputParams<CartSignal> params = kInput;  // at 10 Hz
  params.initial = {1, 1};
  params.expired = {-1, -1};
  params.valid_s = 0.3;
  TestRig<Input> input(params);
  TestRig<Publisher> publisher(kPublisher);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(input.Tick()[input->y], params.initial) << "before the first";
  for (int repetition = 0; repetition < 2; ++repetition) {
    publisher.Fix(publisher->u, {2, 3}).Tick();
    for (int i = 0; i < 3; ++i) EXPECT_EQ(input.Tick()[input->y], (CartSignal{2, 3})) << i;
    for (int i = 0; i < 3; ++i) EXPECT_EQ(input.Tick()[input->y], params.expired) << i;
  }
}

TEST(DdsInputTest, CountsAndNamesWhatItDoesNotTrust) {
  TestRig<Input> rig(kInput);
  const DdsPeer peer(kTopic, tenon_test_Cart__desc);
  std::uint64_t count = 0;
  const auto expect_refused = [&](const tenon_test_Cart_& message, double time, const char* reason) {
    peer.Send(&message, time);
    rig.Tick();
    EXPECT_EQ(rig[rig->refused].count, ++count);
    EXPECT_THAT(rig[rig->refused].reason, HasSubstrs(kTopic, reason));
    EXPECT_EQ(rig[rig->y], (CartSignal{1, 2})) << reason;
  };
  const tenon_test_Cart_ good{1, 2};
  peer.Send(&good, 5);
  EXPECT_EQ(rig.Tick()[rig->y], (CartSignal{1, 2}));
  expect_refused({test::kNan, 3}, 6, "'position' = nan is not finite");
  expect_refused({3, -test::kInfinity}, 6, "'speed' = -inf is not finite");
  expect_refused({3, 101}, 6, "too fast");
  expect_refused({3, 3}, 4.5, "older than the last one");
  // A refused message does not advance the sender's clock, and another sender has its own.
  const DdsPeer restarted(kTopic, tenon_test_Cart__desc);
  const tenon_test_Cart_ first{7, 8};
  restarted.Send(&first, 0);
  EXPECT_EQ(rig.Tick()[rig->y], (CartSignal{7, 8}));
  peer.Send(&good, 5.5);
  EXPECT_EQ(rig.Tick()[rig->y], (CartSignal{1, 2}));
  EXPECT_EQ(rig[rig->refused].count, count);
}

/// Sends messages of another type under the name of Cart_ until the process is ended.
void SendOtherType(bool with_type_information) {
  const TestRig<Publisher> join({.topic = kTopic + "_other", .link = kOwnLink});
  const dds_topic_descriptor_t& other = tenon_test_OtherCart__desc;
  const std::uint32_t without = with_type_information ? 0 : DDS_TOPIC_XTYPES_METADATA;
  const dds_topic_descriptor_t named{.m_size = other.m_size,
                                     .m_align = other.m_align,
                                     .m_flagset = other.m_flagset & ~without,
                                     .m_nkeys = 0,
                                     .m_typename = tenon_test_Cart__desc.m_typename,
                                     .m_keys = nullptr,
                                     .m_nops = other.m_nops,
                                     .m_ops = other.m_ops,
                                     .m_meta = other.m_meta,
                                     .type_information = other.type_information,
                                     .type_mapping = other.type_mapping,
                                     .restrict_data_representation = other.restrict_data_representation};
  const DdsPeer peer(kTopic, named);
  for (;;) {
    const tenon_test_OtherCart_ message{1};
    peer.Send(&message, 1);
    dds_sleepfor(DDS_MSECS(1));
  }
}

void ExpectRefused(bool with_type_information, const char* reason) {
  const test::SecondProcess sender([&] { SendOtherType(with_type_information); });
  TestRig<Input> rig(kInput);
  EXPECT_TRUE(test::Within10s([&] { return rig.Tick()[rig->refused].count > 0; }));
  EXPECT_THAT(rig[rig->refused].reason, testing::HasSubstr(reason));
  EXPECT_EQ(rig[rig->taken].number, 0u);
}

TEST(DdsInputTest, NamesASenderWhoseMessagesHaveAnotherLayout) {
  ExpectRefused(false, "another size or layout");
}

TEST(DdsInputTest, NamesASenderOfAnotherType) {
  ExpectRefused(true, "another type");
}

TEST(DdsInputTest, AFloodBetweenTwoTicksEndsInItsNewestMessage) {
  TestRig<Input> rig(kInput);
  const DdsPeer peer(kTopic, tenon_test_Cart__desc);
  for (int i = 1; i <= 5000; ++i) {
    const tenon_test_Cart_ message{1.0 * i, 0};
    peer.Send(&message, i);
  }
  EXPECT_EQ(rig.Tick()[rig->y].position, 5000);
}

TEST(DdsTest, RefusesWhatItCannotJoin) {
  const auto with = [](auto params, const auto& change) {
    change(params);
    return params;
  };
  EXPECT_TRUE(Refuses<Input>(with(kInput, [](auto& p) { p.topic = ""; }), "topic"));
  EXPECT_TRUE(Refuses<Input>(with(kInput, [](auto& p) { p.link.domain = 231; }), "domain = 231"));
  EXPECT_TRUE(Refuses<Publisher>(with(kPublisher, [](auto& p) { p.link.interface = "nix0"; }), "'nix0'"));
  EXPECT_TRUE(Refuses<Input>(with(kInput, [](auto& p) { p.timeout_s = 0; }), "timeout_s = 0"));
  const TestRig<Input> first(kInput);
  EXPECT_TRUE(Refuses<Publisher>(with(kPublisher, [](auto& p) { p.link.interface = ""; }), "'lo'"));
}

TEST(DdsInputTest, ALockStepThatIsLateEndsTheRun) {
  TestRig<Input> rig(
      {.topic = kTopic, .link = kOwnLink, .rate = Hz(10), .lock_step = true, .timeout_s = 1e-3});
  EXPECT_TRUE(Throws<RunError>([&] { rig.Tick(); }, "'block.y'", kTopic, "t = 0 s"));
}

}  // namespace dds_test
}  // namespace tenon
