#include <tenon/systems/simulation/run_profile.h>
#include <tenon/tests/systems/framework/test_blocks.h>

#include <chrono>

namespace tenon::run_profile_test {

/// Takes a quarter of a millisecond at each tick.
double Busy(double u) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::microseconds(250);
  while (std::chrono::steady_clock::now() < end) {
  }
  return u;
}

TEST(RunProfileTest, AccountsForTheTimeOfTheRun) {
  DiagramBuilder builder;
  auto& oscillator = builder.Add<Oscillator>("oscillator");
  const auto& position =
      builder.AddFunction({"position"}, Uses(oscillator.state), [](const Vec<2>& x) { return x[0]; });
  auto& busy = builder.Add<SampledMap>("busy", {Busy, Sampled{Hz(100)}});
  builder.Connect(position, busy.u);
  builder.Connect(busy.y, oscillator.u);
  Simulator simulator(builder.Build(), {.profile = true});
  simulator.AddLog(Hz(100), {&oscillator.state});
  const auto begin = std::chrono::steady_clock::now();
  simulator.RunTo(1);
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  const RunProfile profile = simulator.Profile();
  EXPECT_GT(profile.total, 0.95 * wall.count());
  EXPECT_LE(profile.total, wall.count());
  ASSERT_FALSE(profile.calculations.empty());
  EXPECT_EQ(profile.calculations[0].path, "busy.y");
  EXPECT_EQ(profile.calculations[0].calls, 101);
  EXPECT_GE(profile.calculations[0].seconds, 101 * 250e-6);
  EXPECT_EQ(profile.Blocks()[0].path, "busy");
  EXPECT_GT(profile.integrator, 0);
  EXPECT_GT(profile.logs, 0);
  EXPECT_EQ(profile.waiting, 0);
  EXPECT_NE(profile.Text().find("101 calls"), std::string::npos) << profile.Text();
}

TEST(RunProfileTest, ProfilingChangesNoBit) {
  const auto end = [](bool profile) {
    PdLoop loop;
    Simulator simulator(loop.builder.Build(), {.profile = profile});
    simulator.context().Set(loop.cart.x, {1, 0});
    simulator.RunTo(0.5);
    return simulator.context().Save();
  };
  EXPECT_EQ(end(false), end(true));
}

TEST(RunProfileTest, MustBeAskedFor) {
  DiagramBuilder builder;
  builder.Add<Oscillator>("oscillator");
  const Simulator simulator(builder.Build());
  EXPECT_TRUE(Throws<RunError>([&] { static_cast<void>(simulator.Profile()); }, "SimulatorOptions::profile"));
}

}  // namespace tenon::run_profile_test
