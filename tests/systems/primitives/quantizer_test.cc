#include <tenon/systems/primitives/quantizer.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::quantizer_test {

TEST(QuantizerTest, RoundsToTheNearestStep) {
  TestRig<Quantizer<Vec<3>>> rig({.step = {0.25, 2, 1}});
  EXPECT_THAT(rig.Fix(rig->u, {0.6, 2.9, -1.5})[rig->y], IsNear(Vec<3>(0.5, 2, -2), 0));
  rig.Set(rig->step, {1, 1, 1});
  EXPECT_THAT(rig[rig->y], IsNear(Vec<3>(1, 3, -2), 0));
}

TEST(QuantizerTest, RefusesABadStep) {
  for (const double bad : {0.0, -1.0, test::kNan, test::kInfinity})
    EXPECT_TRUE(Refuses<Quantizer<>>({.step = bad}, "step"));
}

}  // namespace tenon::quantizer_test
