// Runs that begin at large times, such as seconds since 1970, where a double resolves time only coarsely.

#include <tenon/tests/systems/framework/test_blocks.h>

namespace tenon::large_times_test {

constexpr double kNow = 1.76e9;  // a double resolves 2.4e-7 s here

/// q = cos 500 t, with a sampled force of zero, whose ticks restart the integrator.
struct Vibration {
  explicit Vibration(Rate rate) : body(builder.Add<Oscillator>("body", 500.0)) {
    AddRestarts(builder, "force", rate, body.u);
    diagram = builder.Build();
  }
  std::unique_ptr<Context> ContextAt(double time) const {
    auto context = diagram->CreateContext();
    context->SetTime(time);
    return context;
  }
  DiagramBuilder builder;
  Oscillator& body;
  std::shared_ptr<const Diagram> diagram;
};

TEST(LargeTimesTest, ARunIsThatFromZero) {
  const Vibration vibration(Hz(500));
  for (const Method method : kAllMethods) {
    const SimulatorOptions options{.method = method, .rtol = 1e-6, .atol = 1e-6};
    Simulator first(vibration.ContextAt(0), options);
    const auto wanted = first.AddLog(Hz(130), {&vibration.body.state});
    first.RunTo(1);
    EXPECT_NEAR(first.context().Eval(vibration.body.x)[0], std::cos(500), 1e-2);  // 80 periods
    for (const double start : {1e4, 1e7, 1e8, kNow}) {
      Simulator simulator(vibration.ContextAt(start), options);
      const auto log = simulator.AddLog(Hz(130), {&vibration.body.state});  // inside the steps
      simulator.RunTo(start + 1);
      ASSERT_EQ(log->rows(), 131U);
      for (std::size_t i = 0; i < log->rows(); ++i)
        ASSERT_NEAR(log->row(i)[1], wanted->row(i)[1], 20e-6) << NameOf(method) << ' ' << start << ' ' << i;
    }
  }
}

TEST(LargeTimesTest, DividedAndSavedRunsContinueBitForBit) {
  const Vibration vibration(Hz(500));
  Simulator whole(vibration.ContextAt(kNow));
  whole.RunTo(kNow + 0.1);
  const Eigen::VectorXd wanted = whole.context().continuous_state();
  Simulator divided(vibration.ContextAt(kNow));
  for (int i = 1; i <= 30; ++i) {
    divided.RunTo(kNow + 0.1 * i / 30);
    Simulator saved(vibration.ContextAt(0));
    saved.context().Restore(divided.context().Save());
    saved.RunTo(kNow + 0.1);
    EXPECT_EQ(saved.context().continuous_state(), wanted) << i;
  }
  EXPECT_EQ(divided.context().continuous_state(), wanted);
}

TEST(LargeTimesTest, NoTickAfterTheEndRuns) {
  DiagramBuilder builder;
  auto& counter = builder.Add<Counter>("counter", Sampled{Hz(10e6)});
  const auto diagram = builder.Build();
  for (const double start : {0.0, 1.0, 1000.0, 1e5}) {
    auto context = diagram->CreateContext();
    context->SetTime(start);
    Simulator simulator(std::move(context));
    const auto count = [&] { return simulator.context().Eval(counter.n); };
    simulator.RunTo(start);
    EXPECT_EQ(count(), 1) << start;
    simulator.RunTo(start + 2.5e-7);  // between two ticks
    EXPECT_EQ(count(), 3) << start;
    static_cast<void>(simulator.AdvanceToBefore(start + 10e-7));
    EXPECT_EQ(count(), 10) << start;
    simulator.RunTo(start + 10e-7);
    EXPECT_EQ(count(), 11) << start;
  }
}

TEST(LargeTimesTest, TicksThatADoubleCannotDistinguishAreRefused) {
  DiagramBuilder builder;
  builder.Add<Counter>("counter", Sampled{Hz(10e6)});
  auto context = builder.Build()->CreateContext();
  context->SetTime(kNow);
  EXPECT_TRUE(Throws<RunError>([&] { Simulator simulator(std::move(context)); }, "'counter.next n'",
                               "begin the run at an earlier time"));
}

}  // namespace tenon::large_times_test
