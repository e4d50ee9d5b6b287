#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/primitives/noise.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/test_rig.h>

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace tenon::noise_test {
namespace {

TEST(WhiteNoiseTest, HasItsMoments) {
  TestRig<WhiteNoise<Vec<2>>> rig(NoiseParams<Vec<2>>{.standard_deviation = {2, 0.1}});
  constexpr int kSamples = 20000;
  Vec<2> sum = Vec<2>::Zero(), squares = Vec<2>::Zero();
  double product = 0, lagged = 0, last = 0;
  for (int i = 0; i < kSamples; ++i) {
    const Vec<2> y = rig.Tick()[rig.system().y];
    sum += y;
    squares += y.cwiseAbs2();
    product += y[0] * y[1];
    lagged += y[0] * last;
    last = y[0];
  }
  // Five standard errors each.
  const double error = 5 / std::sqrt(kSamples);
  EXPECT_NEAR(sum[0] / kSamples / 2, 0, error);
  EXPECT_NEAR(sum[1] / kSamples / 0.1, 0, error);
  EXPECT_NEAR(squares[0] / kSamples / 4, 1, error * std::sqrt(2));
  EXPECT_NEAR(squares[1] / kSamples / 0.01, 1, error * std::sqrt(2));
  EXPECT_NEAR(product / kSamples / 0.2, 0, error) << "the elements are correlated";
  EXPECT_NEAR(lagged / kSamples / 4, 0, error) << "successive samples are correlated";
}

TEST(WhiteNoiseTest, IsHeldBetweenTicks) {
  TestRig<WhiteNoise<>> rig(NoiseParams<>{.rate = Hz(10)});
  const double first = rig.Tick()[rig.system().y];
  EXPECT_EQ(rig.RunTo(0.09)[rig.system().y], first);
  EXPECT_NE(rig.RunTo(0.1)[rig.system().y], first);
}

TEST(WhiteNoiseTest, FollowsFromSeedAndPath) {
  DiagramBuilder builder;
  auto& a = builder.Add<WhiteNoise<>>("a");
  auto& b = builder.Add<WhiteNoise<>>("b");
  const auto diagram = builder.Build();
  const auto run = [&](std::uint64_t seed) -> Vec<2> {
    Simulator simulator(*diagram, {.seed = seed});
    simulator.RunTo(0.01);
    return {simulator.context().Eval(a.y), simulator.context().Eval(b.y)};
  };
  EXPECT_EQ(run(1), run(1));
  EXPECT_NE(run(1)[0], run(2)[0]);
  EXPECT_NE(run(1)[0], run(1)[1]);
}

TEST(AddNoiseTest, AddsToItsInput) {
  TestRig<AddNoise<>> rig(NoiseParams<>{.standard_deviation = 0.5});
  TestRig<WhiteNoise<>> noise(NoiseParams<>{.standard_deviation = 0.5});  // a block of the same path
  for (int i = 0; i < 10; ++i) {
    rig.Fix(rig.system().u, i).Tick();
    EXPECT_EQ(rig[rig.system().y], i + noise.Tick()[noise.system().y]);
  }
}

TEST(AddNoiseTest, PassesElementsWithoutNoise) {
  TestRig<AddNoise<Vec<2>>> rig(NoiseParams<Vec<2>>{.standard_deviation = {0, 1}});
  rig.Fix(rig.system().u, {3, 4}).Tick();
  EXPECT_EQ(rig[rig.system().y][0], 3);
  EXPECT_NE(rig[rig.system().y][1], 4);
}

TEST(NoiseTest, RefusesBadDeviations) {
  for (const double bad : {-1.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
    EXPECT_TRUE(Throws<ParameterError>([&] { WhiteNoise<> block(NoiseParams<>{.standard_deviation = bad}); },
                                       "standard_deviation"));
  }
  EXPECT_TRUE(Throws<ParameterError>(
      [] {
        AddNoise<Vec<2>> block(NoiseParams<Vec<2>>{.standard_deviation = {1, -1}});
      },
      "every element"));
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
  EXPECT_TRUE(Throws<ParameterError>(
      [] {
        WhiteNoise<Measurement> block({.standard_deviation = {.velocity = {0, -1, 0}}});
      },
      "every element"));
}

TEST(NoiseTest, DeviationsAreSetInARun) {
  TestRig<WhiteNoise<>> rig;
  rig.Tick().Set(rig->standard_deviation, 0);
  EXPECT_EQ(rig.Tick()[rig->y], 0);
  EXPECT_TRUE(
      Throws<ParameterError>([&] { rig.Set(rig->standard_deviation, -1); }, "'block.standard_deviation'"));
}

struct Scan {
  std::vector<double> ranges;
  static FieldList Fields() { return {{"ranges", &Scan::ranges}}; }
};

TEST(NoiseTest, RefusesTypesWithoutAFixedSize) {
  EXPECT_TRUE(Throws<ParameterError>([] { AddNoise<Scan> block; }, "standard_deviation", "fixed size"));
}

}  // namespace
}  // namespace tenon::noise_test
