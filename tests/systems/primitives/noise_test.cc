#include <tenon/systems/primitives/noise.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::noise_test {

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

TEST(NoiseTest, RefusesBadDeviations) {
  for (const double bad : {-1.0, test::kNan, test::kInfinity})
    EXPECT_TRUE(Refuses<WhiteNoise<>>({.standard_deviation = bad}, "standard_deviation"));
  EXPECT_TRUE(Refuses<AddNoise<Vec<2>>>({.standard_deviation = {1, -1}}, "standard_deviation"));
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
  EXPECT_TRUE(Throws<ParameterError>([] { AddNoise<Scan> block; }, "standard_deviation"));
}

}  // namespace tenon::noise_test
