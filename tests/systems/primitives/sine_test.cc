#include <tenon/systems/primitives/sine.h>
#include <tenon/tests/testing/block_test.h>

#include <cmath>

namespace tenon::sine_test {

TEST(SineTest, HasItsDerivatives) {
  TestRig<Sine<>> rig({.amplitude = 2, .angular_frequency = 3, .phase = 0.5, .offset = 1, .unit = "m"});
  for (const double t : {0.0, 0.4, 2.0}) {
    rig.context().SetTime(t);
    EXPECT_NEAR(rig[rig->y], 1 + 2 * std::sin(3 * t + 0.5), 1e-15);
    EXPECT_NEAR(rig[rig->dy], 6 * std::cos(3 * t + 0.5), 1e-15);
    EXPECT_NEAR(rig[rig->ddy], -18 * std::sin(3 * t + 0.5), 1e-14);
  }
  EXPECT_EQ(rig->dy.elements()[0].unit, "m/s");
  EXPECT_EQ(rig->ddy.elements()[0].unit, "m/s^2");
}

TEST(SineTest, MakesACircle) {
  TestRig<Sine<Vec<2>>> rig({.phase = {M_PI / 2, 0}, .unit = "m", .elements = "x, y"});
  rig.context().SetTime(0.3);
  EXPECT_THAT(rig[rig->y], IsNear(Vec<2>(std::cos(0.3), std::sin(0.3)), 1e-15));
  EXPECT_EQ(rig->dy.elements()[1].name, "y");
}

TEST(SineTest, IsSetInARun) {
  TestRig<Sine<>> rig;
  rig.RunTo(1).Set(rig->amplitude, 5);
  EXPECT_EQ(rig[rig->y], 5 * std::sin(1));
}

TEST(SineTest, RefusesWhatIsNotFinite) {
  EXPECT_TRUE(Refuses<Sine<>>({.amplitude = test::kNan}, "amplitude"));
  EXPECT_TRUE(Refuses<Sine<>>({.angular_frequency = test::kNan}, "angular_frequency"));
  EXPECT_TRUE(Refuses<Sine<>>({.phase = test::kNan}, "phase"));
  EXPECT_TRUE(Refuses<Sine<>>({.offset = test::kNan}, "offset"));
}

}  // namespace tenon::sine_test
