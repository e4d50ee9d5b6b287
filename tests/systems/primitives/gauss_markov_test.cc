#include <tenon/systems/primitives/gauss_markov.h>
#include <tenon/tests/testing/block_test.h>

#include <cmath>
#include <vector>

namespace tenon::gauss_markov_test {

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

TEST(GaussMarkovTest, RefusesBadParameters) {
  for (const double bad : {-1.0, test::kNan})
    EXPECT_TRUE(Refuses<GaussMarkov<>>({.standard_deviation = bad}, "standard_deviation"));
  for (const double bad : {0.0, -1.0, test::kNan})
    EXPECT_TRUE(Refuses<GaussMarkov<>>({.time_constant = bad}, "time_constant"));
}

}  // namespace tenon::gauss_markov_test
