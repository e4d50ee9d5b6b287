#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/primitives/gain.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/test_rig.h>

#include <gtest/gtest.h>

#include <limits>

namespace tenon::gain_test {
namespace {

TEST(GainTest, Multiplies) {
  TestRig<Gain<>> rig(GainParams{.gain = -2.5});
  EXPECT_EQ(rig.Fix(rig.system().u, 4)[rig.system().y], -10);
}

TEST(GainTest, MultipliesVectors) {
  TestRig<Gain<Vec<3>>> rig(GainParams{.gain = 2});
  EXPECT_THAT(rig.Fix(rig.system().u, {1, 2, 3})[rig.system().y], IsNear(Vec<3>(2, 4, 6), 0));
}

TEST(GainTest, CarriesItsUnits) {
  TestRig<Gain<Vec<2>>> rig(GainParams{.u_unit = "A", .y_unit = "N, m"});
  EXPECT_EQ(rig.system().u.elements()[1].unit, "A");
  EXPECT_EQ(rig.system().y.elements()[1].unit, "m");
}

TEST(GainTest, RefusesAGainThatIsNotFinite) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(Throws<ParameterError>([&] { Gain<> gain(GainParams{.gain = nan}); }, "gain must be finite"));
}

TEST(GainTest, IsSetInARun) {
  TestRig<Gain<Vec<2>>> rig({.gain = 2, .elements = "x, z"});
  rig.Set(rig->gain, 5);
  EXPECT_THAT(rig.Fix(rig->u, {1, 2})[rig->y], IsNear(Vec<2>(5, 10), 0));
  EXPECT_EQ(rig->y.elements()[1].name, "z");
}

}  // namespace
}  // namespace tenon::gain_test
