#include <tenon/systems/io/external_input.h>
#include <tenon/tests/systems/framework/test_blocks.h>

#include <thread>

namespace tenon::external_input_test {

using Input = ExternalInput<double>;

TEST(ExternalInputTest, TakesOverAtItsTicksWhatWasPutLast) {
  TestRig<Input> rig({.initial = 7, .rate = Hz(10)});
  rig.Tick();
  EXPECT_EQ(rig[rig->y], 7);
  rig->Put(1);
  rig->Put(2);
  rig.RunTo(0.05);
  EXPECT_EQ(rig[rig->y], 7) << "held between the ticks";
  rig.Tick();
  EXPECT_EQ(rig[rig->y], 2);
  rig.Tick();
  EXPECT_EQ(rig[rig->y], 2);
}

/// A cart that is pushed from outside.
struct Pushed {
  DiagramBuilder builder;
  Cart* cart = &builder.Add<Cart>("cart");
  Input* input;
  explicit Pushed(ExternalInputParams<double> params)
      : input(&builder.Add<Input>("input", std::move(params))) {
    builder.Connect(input->y, cart->force);
  }
};

TEST(ExternalInputTest, ARecordedRunReplaysBitForBit) {
  Pushed pushed({.unit = "N", .record = true});
  Simulator simulator(pushed.builder.Build());
  std::thread hand([&] {
    for (int i = 0; i < 1000; ++i) {
      pushed.input->Put(0.1 * i);
      std::this_thread::yield();
    }
  });
  simulator.RunTo(1);
  hand.join();
  pushed.input->Put(-3);
  simulator.RunTo(1.5);
  const Recording<double> recording = simulator.context().Eval(pushed.input->taken).recording;
  ASSERT_FALSE(recording.empty());
  EXPECT_EQ(recording.back().value, -3);

  Pushed again({.unit = "N", .replay = recording});
  Simulator replay(again.builder.Build());
  replay.RunTo(1);
  again.input->Put(100);
  replay.RunTo(1.5);
  EXPECT_EQ(replay.context().Eval(again.cart->x), simulator.context().Eval(pushed.cart->x));
}

/// Notes the order in which it publishes without the external input (s), takes it over (h), and publishes
/// what depends on it (a).
class Talker final : public LeafSystem<std::vector<char>*> {
 public:
  explicit Talker(std::vector<char>* book) : LeafSystem(book) {}
  Scratch<int> nothing{this, "nothing"};
  ExternalPort<int> heard{this, "heard", 0, Sampled{Hz(10)}, Uses(nothing), [this](int&) {
                            params->push_back('h');
                            return 1;
                          }};
  OutputPort<int> thought{this, "thought", Sampled{Hz(10)}, Uses(heard), [](int heard) { return heard + 1; }};
  Publish answer{this, "answer", Sampled{Hz(10)}, Uses(thought), [this](int) { params->push_back('a'); }};
  Publish say{this, "say", Sampled{Hz(10)}, Uses(time), [this](double) { params->push_back('s'); }};
};

TEST(ExternalInputTest, IsTakenOverAfterWhatIsPublishedWithoutIt) {
  std::vector<char> book;
  TestRig<Talker> rig(&book);
  rig.Tick().Tick();
  EXPECT_EQ(std::string(book.begin(), book.end()), "shasha");
}

TEST(ExternalInputTest, TakesOverWithoutAllocating) {
  if (!AllocationGuard::Available()) GTEST_SKIP() << "allocations are not counted in this build";
  TestRig<Input> rig;
  rig.Tick();
  const AllocationGuard guard;
  for (int i = 0; i < 100; ++i) {
    rig->Put(i);
    rig.Tick();
  }
  EXPECT_EQ(guard.count(), 0);
  EXPECT_EQ(rig[rig->y], 99);
}

}  // namespace tenon::external_input_test
