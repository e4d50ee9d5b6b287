#include <tenon/systems/analysis/sensitivity.h>
#include <tenon/systems/primitives/low_pass_filter.h>
#include <tenon/systems/primitives/noise.h>
#include <tenon/systems/primitives/unit_delay.h>
#include <tenon/tests/systems/framework/test_blocks.h>

namespace tenon::sensitivity_test {

using ::testing::ElementsAre;

struct FreeCart {
  DiagramBuilder builder;
  Cart& cart = builder.Add<Cart>("cart", {.mass = 2});
  std::shared_ptr<const Diagram> diagram = builder.BuildWithOpenInputs();
  std::unique_ptr<Context> context = diagram->CreateContext();
};

TEST(SensitivityTest, OfARunInClosedForm) {
  // J = (p + v T + F T²/2 m)²
  FreeCart free;
  free.context->Set(free.cart.x, Vec<2>(0.5, 0.2));
  free.context->Set(free.cart.force, 3.0);
  const auto before = free.context->Save();
  const Figure figure = [&](std::unique_ptr<Context> start) {
    Simulator simulator(std::move(start));
    const auto log = simulator.AddLog(Hz(1), {&free.cart.state});
    simulator.RunTo(2);
    return std::pow(log->column("cart.x.position").back(), 2);
  };
  const SensitivityResult result = Sensitivity(*free.context, {&free.cart.force, &free.cart.x}, figure);
  const double end = 0.5 + 0.2 * 2 + 3;
  EXPECT_NEAR(result.figure, end * end, 1e-9);
  ASSERT_EQ(result.gradient.size(), 3);
  EXPECT_NEAR(result.gradient[0], 2 * end, 1e-6);
  EXPECT_NEAR(result.gradient[1], 2 * end, 1e-6);
  EXPECT_NEAR(result.gradient[2], 2 * end * 2, 1e-6);
  EXPECT_THAT(result.names, ElementsAre("cart.force", "cart.x.position", "cart.x.velocity"));
  EXPECT_THAT(result.units, ElementsAre("N", "m", "m/s"));
  EXPECT_EQ(free.context->Save(), before);
}

TEST(SensitivityTest, StepsAreRelativeToTheValueOrToTheScaleOfItsUnit) {
  // For h above F, (|F + h| - |F - h|) / 2 h = F / h shows the step h.
  FreeCart free;
  free.context->Set(free.cart.force, 0.1);
  const Figure figure = [&](std::unique_ptr<Context> start) {
    return std::abs(start->Eval(free.cart.force));
  };
  const auto slope = [&](const SensitivityOptions& options) {
    return Sensitivity(*free.context, {&free.cart.force}, figure, options).gradient[0];
  };
  EXPECT_NEAR(slope({}), 1, 1e-9);
  EXPECT_NEAR(slope({.step = 2}), 0.1 / 0.2, 1e-9);
  EXPECT_NEAR(slope({.step = 0.5, .scales = {{"N", 8}}}), 0.1 / 4, 1e-9);
  free.context->Set(free.cart.force, 0.0);
  EXPECT_NEAR(slope({}), 0, 1e-12);
}

TEST(SensitivityTest, NoiseIsTheSameInAllRuns) {
  DiagramBuilder builder;
  auto& noise = builder.Add<AddNoise<>>("noise", {.standard_deviation = 5});
  auto& delay = builder.Add<UnitDelay<>>("delay");
  builder.Connect(delay.y, noise.u);
  const auto context = builder.BuildWithOpenInputs()->CreateContext(4);
  context->Set(delay.u, 0.0);
  const Figure figure = [&](std::unique_ptr<Context> start) {
    Simulator simulator(std::move(start));
    simulator.Initialize();
    return simulator.context().Eval(noise.y);
  };
  const SensitivityResult result = Sensitivity(*context, {&delay.x}, figure);
  EXPECT_NE(result.figure, 0);
  EXPECT_NEAR(result.gradient[0], 1, 1e-9);
}

TEST(SensitivityTest, OfALoggedFigureToAGain) {
  // y = 1 - exp(-t/τ) at the second log of 1 Hz: dy/dτ = -t/τ² exp(-t/τ).
  DiagramBuilder builder;
  auto& filter = builder.Add<LowPassFilter<>>("filter", {.time_constant = 0.8});
  const auto context = builder.BuildWithOpenInputs()->CreateContext();
  context->Set(filter.u, 1.0);
  const Figure figure = [&](std::unique_ptr<Context> start) {
    Simulator simulator(std::move(start), {.rtol = 1e-10, .atol = 1e-12});
    const auto log = simulator.AddLog(Hz(1), {&filter.y});
    simulator.RunTo(1.5);
    return log->column("filter.y").back();
  };
  const SensitivityResult result = Sensitivity(*context, {&filter.time_constant}, figure);
  EXPECT_NEAR(result.figure, 1 - std::exp(-1 / 0.8), 1e-9);
  EXPECT_NEAR(result.gradient[0], -1 / (0.8 * 0.8) * std::exp(-1 / 0.8), 1e-6);
  EXPECT_THAT(result.names, ElementsAre("filter.time_constant"));
}

TEST(SensitivityTest, WhatCannotBeMovedIsRefused) {
  PdLoop loop;
  auto& counter = loop.builder.Add<Counter>("counter", Sampled{Hz(1)});
  const auto context = loop.builder.Build()->CreateContext();
  const Figure nothing = [](std::unique_ptr<Context>) { return 0.0; };
  EXPECT_TRUE(Throws<RunError>([&] { Sensitivity(*context, {&counter.n}, nothing); }, "'counter.n'"));
  EXPECT_TRUE(Throws<RunError>([&] { Sensitivity(*context, {&loop.pd.x}, nothing); }, "'pd.x'", "'cart.x'"));
  EXPECT_TRUE(
      Throws<ParameterError>([&] { Sensitivity(*context, {&loop.cart.x}, nothing, {.step = 0}); }, "step"));
  EXPECT_TRUE(Throws<ParameterError>(
      [&] {
        Sensitivity(*context, {&loop.cart.x}, nothing, {.scales = {{"m", 0}}});
      },
      "'m'"));
}

TEST(SensitivityTest, RunsThatFailAreNamed) {
  FreeCart free;
  free.context->Set(free.cart.force, 1.0);
  const Figure root = [&](std::unique_ptr<Context> start) {
    return std::sqrt(1 - start->Eval(free.cart.force));
  };
  EXPECT_TRUE(
      Throws<RunError>([&] { Sensitivity(*free.context, {&free.cart.force}, root); }, "'cart.force'", "nan"));
  const Figure failing = [](std::unique_ptr<Context>) -> double { throw RunError("it fell"); };
  EXPECT_TRUE(Throws<RunError>([&] { Sensitivity(*free.context, {&free.cart.force}, failing); }, "it fell"));
}

}  // namespace tenon::sensitivity_test
