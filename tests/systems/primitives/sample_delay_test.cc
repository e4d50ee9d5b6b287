#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/primitives/gain.h>
#include <tenon/systems/primitives/sample_delay.h>
#include <tenon/tests/testing/allocation_guard.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/test_rig.h>

#include <gtest/gtest.h>

namespace tenon::sample_delay_test {
namespace {

TEST(SampleDelayTest, DelaysByItsSamples) {
  for (const int samples : {1, 2, 5}) {
    TestRig<SampleDelay<>> rig(SampleDelayParams<>{.samples = samples, .initial = -1});
    auto& block = rig.system();
    for (int n = 0; n < 20; ++n) {
      rig.Fix(block.u, 10 * n).Tick();
      EXPECT_EQ(rig[block.y], n < samples ? -1 : 10 * (n - samples)) << samples << " samples, tick " << n;
    }
  }
}

TEST(SampleDelayTest, CarriesVectors) {
  TestRig<SampleDelay<Vec<2>>> rig(SampleDelayParams<Vec<2>>{.samples = 2});
  auto& block = rig.system();
  rig.Fix(block.u, {1, 2}).Tick().Fix(block.u, {3, 4}).Tick();
  EXPECT_THAT(rig[block.y], IsNear(Vec<2>(0, 0), 0));
  EXPECT_THAT(rig.Tick()[block.y], IsNear(Vec<2>(1, 2), 0));
  EXPECT_THAT(rig.Tick()[block.y], IsNear(Vec<2>(3, 4), 0));
}

TEST(SampleDelayTest, GoesOnFromASnapshot) {
  TestRig<SampleDelay<>> rig(SampleDelayParams<>{.samples = 3});
  auto& block = rig.system();
  for (int n = 0; n < 5; ++n) rig.Fix(block.u, n).Tick();
  const auto clone = rig.context().Clone();
  const auto bytes = rig.context().Save();
  EXPECT_EQ(rig.Tick()[block.y], 2);
  EXPECT_EQ(rig.Tick()[block.y], 3);
  for (Context* source : {clone.get(), static_cast<Context*>(nullptr)}) {
    auto context = rig.diagram().CreateContext();
    if (source != nullptr) {
      context = source->Clone();
    } else {
      context->Restore(bytes);
    }
    Simulator simulator(std::move(context));
    simulator.RunTo(0.006);
    EXPECT_EQ(simulator.context().Eval(block.y), 3);
  }
}

TEST(SampleDelayTest, DoesNotAllocate) {
  if (!AllocationGuard::Available()) GTEST_SKIP() << "allocations are not counted in this build";
  TestRig<SampleDelay<>> rig(SampleDelayParams<>{.samples = 50});
  rig.Fix(rig.system().u, 1).Tick();
  const AllocationGuard guard;
  for (int i = 0; i < 100; ++i) rig.Tick();
  EXPECT_EQ(guard.count(), 0);
}

TEST(SampleDelayTest, BreaksLoops) {
  DiagramBuilder builder;
  auto& delay = builder.Add<SampleDelay<>>("delay", SampleDelayParams<>{.samples = 4});
  auto& gain = builder.Add<Gain<>>("gain");
  builder.Connect(delay.y, gain.u);
  builder.Connect(gain.y, delay.u);
  EXPECT_NO_THROW(builder.Build());
}

TEST(SampleDelayTest, RefusesLessThanOneSample) {
  for (const int bad : {0, -3}) {
    EXPECT_TRUE(Throws<ParameterError>([&] { SampleDelay<> block(SampleDelayParams<>{.samples = bad}); },
                                       "samples", "1"));
  }
}

}  // namespace
}  // namespace tenon::sample_delay_test
