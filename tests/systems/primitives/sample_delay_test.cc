#include <tenon/systems/primitives/sample_delay.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::sample_delay_test {

TEST(SampleDelayTest, DelaysByItsSamples) {
  for (const int samples : {1, 2, 5}) {
    TestRig<SampleDelay<Vec<2>>> rig({.samples = samples, .initial = {-1, -1}});
    for (int n = 0; n < 20; ++n) {
      rig.Fix(rig->u, {10 * n, n}).Tick();
      const Vec<2> expected = n < samples ? Vec<2>(-1, -1) : Vec<2>(10 * (n - samples), n - samples);
      EXPECT_EQ(rig[rig->y], expected) << samples << " samples, tick " << n;
    }
  }
}

TEST(SampleDelayTest, GoesOnFromASnapshot) {
  TestRig<SampleDelay<>> rig({.samples = 3});
  for (int n = 0; n < 5; ++n) rig.Fix(rig->u, n).Tick();
  auto clone = rig.context().Clone(), restored = rig.diagram().CreateContext();
  restored->Restore(rig.context().Save());
  EXPECT_EQ(rig.Tick()[rig->y], 2);
  EXPECT_EQ(rig.Tick()[rig->y], 3);
  for (auto* context : {&clone, &restored}) {
    Simulator simulator(std::move(*context));
    simulator.RunTo(0.006);
    EXPECT_EQ(simulator.context().Eval(rig->y), 3);
  }
}

TEST(SampleDelayTest, RefusesLessThanOneSample) {
  for (const int bad : {0, -3}) EXPECT_TRUE(Refuses<SampleDelay<>>({.samples = bad}, "samples"));
}

}  // namespace tenon::sample_delay_test
