#include <tenon/systems/framework/block/publish.h>
#include <tenon/tests/systems/framework/test_blocks.h>

namespace tenon::publish_test {

/// Notes the times at which it publishes.
struct Reporter final : LeafSystem<std::vector<double>*> {
  explicit Reporter(std::vector<double>* book) : LeafSystem(book) {}
  InputPort<Vec<2>> x{this, "x"};
  Witness zero{this, "zero", Crossing::kBoth, Uses(x), [](const Vec<2>& x) { return x[0]; }};
  Publish at_rate{this, "at_rate", Sampled{Hz(10)}, Uses(time, x), &Reporter::Write};

 private:
  void Write(double time, const Vec<2>&) const { params->push_back(time); }
};

template <class When>
struct Once final : LeafSystem<std::vector<Vec<2>>*> {
  explicit Once(std::vector<Vec<2>>* book) : LeafSystem(book) {}
  InputPort<Vec<2>> x{this, "x"};
  Publish write{this, "write", When{}, Uses(x), [this](const Vec<2>& x) { params->push_back(x); }};
};

struct AtZero final : LeafSystem<std::vector<Vec<2>>*> {
  explicit AtZero(std::vector<Vec<2>>* book) : LeafSystem(book) {}
  InputPort<Vec<2>> x{this, "x"};
  Witness zero{this, "zero", Crossing::kBoth, Uses(x), [](const Vec<2>& x) { return x[0]; }};
  Publish write{this, "write", zero, Uses(x), [this](const Vec<2>& x) { params->push_back(x); }};
};

/// An oscillator and a block that reads its state.
template <class Block, class Book>
Simulator Watched(Book& book, const SimulatorOptions& options = {}) {
  DiagramBuilder builder;
  auto& oscillator = builder.Add<Oscillator>("oscillator");
  builder.Connect(oscillator.state, builder.Add<Block>("block", &book).x);
  return Simulator(builder.Build(), options);
}

/// Does at its ticks what a function does.
struct Caller final : LeafSystem<std::function<void()>*> {
  explicit Caller(std::function<void()>* call) : LeafSystem(call) {}
  Publish tick{this, "tick", Sampled{Hz(10)}, Uses(time), [this](double) { (*params)(); }};
};

TEST(PublishTest, MayNotChangeTheContext) {
  std::function<void()> call = [] {};
  DiagramBuilder builder;
  auto& oscillator = builder.Add<Oscillator>("oscillator");
  builder.Add<Caller>("caller", &call);
  Simulator simulator(builder.Build());
  simulator.RunTo(0.25);
  call = [&] { simulator.context().Set(oscillator.x, {0, 0}); };
  EXPECT_TRUE(Throws<RunError>([&] { simulator.RunTo(1); }, "a Publish or a log changed the context"));
}

TEST(PublishTest, RunsAtItsRateAndChangesNoBit) {
  std::vector<double> book;
  const auto end = [&](bool publish) {
    DiagramBuilder builder;
    auto& oscillator = builder.Add<Oscillator>("oscillator");
    if (publish) builder.Connect(oscillator.state, builder.Add<Reporter>("reporter", &book).x);
    Simulator simulator(builder.Build());
    simulator.RunTo(0.5);
    EXPECT_EQ(simulator.statistics().evaluations > 0, true);
    return std::pair(simulator.context().Eval(oscillator.state), simulator.statistics().evaluations);
  };
  EXPECT_EQ(end(false), end(true));
  EXPECT_EQ(book, (std::vector<double>{0, 0.1, 0.2, 0.3, 0.4, 0.5}));
}

TEST(PublishTest, RunsOnceAtTheStart) {
  std::vector<Vec<2>> book;
  Simulator simulator = Watched<Once<AtStart>>(book);
  simulator.RunTo(1);
  EXPECT_EQ(book, (std::vector<Vec<2>>{{1, 0}}));
}

TEST(PublishTest, RunsAfterEachStep) {
  std::vector<Vec<2>> book;
  Simulator simulator = Watched<Once<EachStep>>(book);
  simulator.RunTo(1);
  EXPECT_GE(static_cast<long>(book.size()) + 1, simulator.statistics().steps);
  EXPECT_LE(static_cast<long>(book.size()), simulator.statistics().steps);
}

TEST(PublishTest, RunsWhenAWitnessFires) {
  std::vector<Vec<2>> book;
  Simulator simulator = Watched<AtZero>(book, {.rtol = 1e-9});
  simulator.RunTo(6);  // zeros at pi / 2 and 3 pi / 2
  ASSERT_EQ(book.size(), 2u);
  EXPECT_NEAR(book[0][1], -1, 1e-6);
  EXPECT_NEAR(book[1][1], 1, 1e-6);
}

TEST(PublishTest, IsSilentOnRequest) {
  std::vector<double> book;
  Simulator simulator = Watched<Reporter>(book, {.publish = false});
  simulator.RunTo(1);
  EXPECT_TRUE(book.empty());
}

TEST(PublishTest, WhatItThrowsEndsTheRunWithItsPath) {
  struct Broken final : LeafSystem<void> {
    Publish send{this, "send", Sampled{Hz(10)}, Uses(time), [](double t) {
                   if (t > 0.15) throw RunError("the wire is cut");
                 }};
  };
  DiagramBuilder builder;
  builder.Add<Broken>("radio");
  EXPECT_TRUE(RunFails(builder, "'radio.send'", "0.2"));
}

TEST(PublishTest, EvaluationsDoNotPublish) {
  std::vector<double> book;
  DiagramBuilder builder;
  auto& oscillator = builder.Add<Oscillator>("oscillator");
  builder.Connect(oscillator.state, builder.Add<Reporter>("reporter", &book).x);
  const auto diagram = builder.Build();
  auto context = diagram->CreateContext();
  context->Eval(oscillator.dx);
  context->EvalTimeDerivatives();
  EXPECT_TRUE(Throws<RunError>([&] { context->EvalDoubles(diagram->Find("reporter.at_rate")); },
                               "'reporter.at_rate'"));
  EXPECT_TRUE(book.empty());
}

}  // namespace tenon::publish_test
