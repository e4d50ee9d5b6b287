// Random signals.

#include <tenon/systems/primitives/noise.h>
#include <tenon/systems/primitives/random_walk.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::noises_test {

// random_stream_test checks the distribution of the numbers of a stream.
TEST(WhiteNoiseTest, IsItsDeviationTimesTheNextNormalNumber) {
  TestRig<WhiteNoise<Vec<2>>> rig({.standard_deviation = {2, 0.1}});
  RandomStream same(rig.context().seed(), rig->random.path());
  for (int i = 0; i < 20; ++i) {
    const double first = same.Normal(), second = same.Normal();
    EXPECT_EQ(rig.Tick()[rig->y], Vec<2>(2 * first, 0.1 * second)) << i;
  }
}

TEST(WhiteNoiseTest, IsHeldBetweenTicks) {
  TestRig<WhiteNoise<>> rig({.rate = Hz(10)});
  const double first = rig.Tick()[rig->y];
  EXPECT_EQ(rig.RunTo(0.09)[rig->y], first);
  EXPECT_NE(rig.RunTo(0.1)[rig->y], first);
}

TEST(AddNoiseTest, AddsToItsInput) {
  TestRig<AddNoise<>> rig({.standard_deviation = 0.5});
  TestRig<WhiteNoise<>> noise({.standard_deviation = 0.5});  // a block of the same path
  for (int i = 0; i < 10; ++i) {
    rig.Fix(rig->u, i).Tick();
    EXPECT_EQ(rig[rig->y], i + noise.Tick()[noise->y]);
  }
}

TEST(AddNoiseTest, PassesElementsWithoutNoise) {
  TestRig<AddNoise<Vec<2>>> rig({.standard_deviation = {0, 1}});
  rig.Fix(rig->u, {3, 4}).Tick();
  EXPECT_EQ(rig[rig->y][0], 3);
  EXPECT_NE(rig[rig->y][1], 4);
}

TEST(NoiseTest, RefusesBadDeviationsAndLimits) {
  for (const double bad : {-1.0, test::kNan, test::kInfinity})
    EXPECT_TRUE(Refuses<WhiteNoise<>>({.standard_deviation = bad}, "standard_deviation"));
  EXPECT_TRUE(Refuses<AddNoise<Vec<2>>>({.standard_deviation = {1, -1}}, "standard_deviation"));
  EXPECT_TRUE(Refuses<UniformNoise<>>({.lower = 2}, "lower"));
}

struct Measurement {
  double angle = 0;
  Vec<3> velocity = Vec<3>::Zero();
  int contacts = 0;
  static FieldList Fields() {
    return {{"angle", &Measurement::angle, "rad"},
            {"velocity", &Measurement::velocity, "m/s"},
            {"contacts", &Measurement::contacts}};
  }
};

TEST(NoiseTest, IsPutOnTheDoublesOfAStruct) {
  TestRig<AddNoise<Measurement>> rig({.standard_deviation = {.angle = 0.1, .velocity = {0, 2, 0}}});
  TestRig<WhiteNoise<Vec<4>>> noise({.standard_deviation = {0.1, 0, 2, 0}});  // a block of the same path
  rig.Fix(rig->u, {.angle = 1, .velocity = {1, 2, 3}, .contacts = 4});
  for (int i = 0; i < 5; ++i) {
    const Measurement& y = rig.Tick()[rig->y];
    const Vec<4>& e = noise.Tick()[noise->y];
    EXPECT_EQ(y.angle, 1 + e[0]);
    EXPECT_THAT(y.velocity, IsNear(Vec<3>(1, 2 + e[2], 3), 0));
    EXPECT_EQ(y.contacts, 4);
  }
  TestRig<WhiteNoise<Measurement>> none;
  EXPECT_EQ(none.Tick()[none->y].angle, 0);
  EXPECT_TRUE(Refuses<WhiteNoise<Measurement>>({.standard_deviation = {.velocity = {0, -1, 0}}},
                                               "standard_deviation"));
}

struct Scan {
  std::vector<double> ranges;
  static FieldList Fields() { return {{"ranges", &Scan::ranges}}; }
};

TEST(NoiseTest, RefusesTypesWithoutAFixedSize) {
  EXPECT_TRUE(Throws<ParameterError>([] { AddNoise<Scan> block; }, "standard_deviation"));
}

TEST(UniformNoiseTest, HasItsMomentsAndLimits) {
  TestRig<UniformNoise<Vec<2>>> rig({.lower = {-1, 4}, .upper = {3, 5}, .unit = "m, N"});
  constexpr int kSamples = 10000;
  Vec<2> sum = Vec<2>::Zero(), squares = Vec<2>::Zero(), least(3, 5), most(-1, 4);
  for (int i = 0; i < kSamples; ++i) {
    const Vec<2> y = rig.Tick()[rig->y];
    sum += y - Vec<2>(1, 4.5);
    squares += (y - Vec<2>(1, 4.5)).cwiseAbs2();
    least = least.cwiseMin(y), most = most.cwiseMax(y);
  }
  const double error = 5 / std::sqrt(kSamples);  // standard errors of the mean
  EXPECT_NEAR(sum[0] / kSamples, 0, error * std::sqrt(16. / 12));
  EXPECT_NEAR(sum[1] / kSamples, 0, error * std::sqrt(1. / 12));
  EXPECT_NEAR(squares[0] / kSamples * 12 / 16, 1, error);
  EXPECT_NEAR(squares[1] / kSamples * 12, 1, error);
  EXPECT_GE(least[0], -1);
  EXPECT_LT(least[0], -0.99);
  EXPECT_LT(most[1], 5);
  EXPECT_GT(most[1], 4.99);
}

TEST(GaussMarkovTest, IsCorrelatedAsItSays) {
  constexpr double kTime = 0.02;  // 1000 Hz: a correlation of exp(-lag / 20)
  TestRig<GaussMarkov<Vec<2>>> rig({.standard_deviation = {2, 0.1}, .time_constant = kTime});
  constexpr int kSamples = 100000, kLag = 20;
  std::vector<double> y;
  Vec<2> squares = Vec<2>::Zero();
  double product = 0;
  for (int i = 0; i < kSamples; ++i) {
    const Vec<2>& sample = rig.Tick()[rig->y];
    squares += sample.cwiseAbs2();
    y.push_back(sample[0]);
    if (i >= kLag) product += y[static_cast<std::size_t>(i - kLag)] * sample[0];
  }
  // Four standard errors; about kSamples / 20 of the samples are independent.
  const double error = 4 * std::sqrt(2.0 * 20 / kSamples);
  EXPECT_NEAR(squares[0] / kSamples / 4, 1, error);
  EXPECT_NEAR(squares[1] / kSamples / 0.01, 1, error);
  EXPECT_NEAR(product / kSamples / 4, std::exp(-1), error);
}

TEST(GaussMarkovTest, IsStationaryFromTheStart) {
  DiagramBuilder builder;
  auto& noise = builder.Add<GaussMarkov<Vec<20>>>(
      "noise", {.standard_deviation = Vec<20>::Constant(3), .time_constant = 1e9});
  const auto diagram = builder.Build();
  double squares = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    Simulator simulator(*diagram, {.seed = seed});
    simulator.RunTo(0);
    squares += simulator.context().Eval(noise.y).squaredNorm();
  }
  EXPECT_NEAR(squares / 1000 / 9, 1, 4 * std::sqrt(2. / 1000));
}

TEST(GaussMarkovTest, DecaysWhenItsDeviationIsSetToZero) {
  TestRig<GaussMarkov<>> rig({.time_constant = 0.1, .rate = Hz(10)});
  const double y = rig.Tick()[rig->y];
  rig.Tick().Set(rig->standard_deviation, 0);
  const double last = rig[rig->x];
  EXPECT_NE(last, y);
  EXPECT_EQ(rig.Tick()[rig->y], last);
  EXPECT_NEAR(rig.Tick()[rig->y], last * std::exp(-1), 1e-15);
}

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
}

}  // namespace tenon::noises_test
