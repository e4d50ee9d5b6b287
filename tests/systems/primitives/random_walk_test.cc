#include <tenon/systems/primitives/random_walk.h>
#include <tenon/tests/testing/block_test.h>

#include <cmath>

namespace tenon::random_walk_test {

TEST(RandomWalkTest, VarianceGrowsWithTimeWhateverTheRate) {
  for (const double rate : {10.0, 100.0}) {
    DiagramBuilder builder;
    auto& walk = builder.Add<RandomWalk<Vec<20>>>(
        "walk", {.density = Vec<20>::Constant(3), .start_deviation = Vec<20>::Constant(2), .rate = Hz(rate)});
    const auto diagram = builder.Build();
    double at_start = 0, at_end = 0;
    for (std::uint64_t seed = 0; seed < 50; ++seed) {
      Simulator simulator(*diagram, {.seed = seed});
      simulator.RunTo(0);
      at_start += simulator.context().Eval(walk.y).squaredNorm();
      simulator.RunTo(0.5);
      at_end += simulator.context().Eval(walk.y).squaredNorm();
    }
    const double error = 4 * std::sqrt(2. / 1000);
    EXPECT_NEAR(at_start / 1000 / 4, 1, error);
    EXPECT_NEAR(at_end / 1000 / (4 + 9 * 0.5), 1, error);
  }
}

TEST(RandomWalkTest, WithoutDensityIsABiasThatStays) {
  TestRig<RandomWalk<>> rig({.density = 0, .start_deviation = 1, .unit = "m"});
  const double bias = rig.Tick()[rig->y];
  EXPECT_NE(bias, 0);
  for (int i = 0; i < 10; ++i) EXPECT_EQ(rig.Tick()[rig->y], bias);
  rig.Set(rig->density, 1).Tick();
  EXPECT_NE(rig.Tick()[rig->y], bias);
  EXPECT_EQ(rig->density.elements()[0].unit, "m/sqrt(s)");
}

TEST(RandomWalkTest, RefusesBadParameters) {
  for (const double bad : {-1.0, test::kNan}) {
    EXPECT_TRUE(Refuses<RandomWalk<>>({.density = bad}, "density"));
    EXPECT_TRUE(Refuses<RandomWalk<>>({.start_deviation = bad}, "start_deviation"));
  }
}

}  // namespace tenon::random_walk_test
