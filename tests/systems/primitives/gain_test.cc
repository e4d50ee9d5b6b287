#include <tenon/systems/primitives/gain.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::gain_test {

TEST(GainTest, Multiplies) {
  TestRig<Gain<>> rig({.gain = -2.5});
  EXPECT_EQ(rig.Fix(rig->u, 4)[rig->y], -10);
}

TEST(GainTest, CarriesItsUnits) {
  TestRig<Gain<Vec<2>>> rig({.u_unit = "A", .y_unit = "N, m"});
  EXPECT_EQ(rig->u.elements()[1].unit, "A");
  EXPECT_EQ(rig->y.elements()[1].unit, "m");
}

TEST(GainTest, RefusesAGainThatIsNotFinite) {
  EXPECT_TRUE(Refuses<Gain<>>({.gain = test::kNan}, "gain"));
}

TEST(GainTest, IsSetInARun) {
  TestRig<Gain<Vec<2>>> rig({.gain = 2, .elements = "x, z"});
  rig.Set(rig->gain, 5);
  EXPECT_THAT(rig.Fix(rig->u, {1, 2})[rig->y], IsNear(Vec<2>(5, 10), 0));
  EXPECT_EQ(rig->y.elements()[1].name, "z");
}

}  // namespace tenon::gain_test
