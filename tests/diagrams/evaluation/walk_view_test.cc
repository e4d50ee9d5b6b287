#include <tenon/diagrams/evaluation/walk_view.h>
#include <tenon/plants/model/quadruped_model.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/matchers.h>
#include <tenon/tests/testing/test_rig.h>

#include <gtest/gtest.h>

namespace tenon::walk_view_test {
namespace {

TEST(WalkViewTest, ArrowsStartAtCentreAndFeet) {
  TestRig<WalkView> rig(WalkViewParams{test::DogBot()});
  const WalkView& view = rig.system();
  RandomStream random(2);
  const LeggedState x = test::RandomState(random);
  QuadrupedDynamics dynamics;
  QuadrupedModel(test::DogBot()).Calc(x, &dynamics);
  BodyReference body;
  body.com_W << 1, 2, 3;
  LegForceEstimate legs;
  legs.foot_force[kRearLeft] << 4, 5, 6;
  rig.Fix(view.state, x)
      .Fix(view.body, body)
      .Fix(view.wrench, WrenchEstimate{{7, 8, 9}, {}})
      .Fix(view.leg_forces, legs);
  const Geometry& shapes = rig[view.geometry];
  ASSERT_EQ(shapes.size(), 6);
  EXPECT_EQ(shapes[0].p_W, body.com_W);
  EXPECT_EQ(shapes[1].vector_W, Vec<3>(7, 8, 9));
  for (std::size_t leg = 0; leg < kNumLegs; ++leg)
    EXPECT_THAT(shapes[2 + leg].p_W, IsNear(dynamics.feet[leg].p_W, 1e-12));
  EXPECT_EQ(shapes[2 + kRearLeft].vector_W, Vec<3>(4, 5, 6));
  EXPECT_EQ(shapes[2 + kFrontLeft].vector_W, Vec<3>(0, 0, 0));
}

}  // namespace
}  // namespace tenon::walk_view_test
