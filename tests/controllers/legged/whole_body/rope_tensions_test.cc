#include <tenon/controllers/legged/whole_body/rope_tensions.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::rope_tensions_test {
namespace {

constexpr double kSlope = 0.6,
                 kSide = 0.3;  // inclination of the ground, angle of the ropes to the CoM's path [rad]

/// A robot on a slope with two ropes through points beside its CoM, which include the angle 2 kSide.
struct OnSlope {
  RopeTensionsParams params;
  LeggedState state;
  GroundPlane ground{.slope = {std::tan(kSlope), 0}};
  double weight;

  explicit OnSlope(double tension_max = 1000) : params{.robot = test::DogBot()} {
    state.q = params.robot.stance;
    state.q_WB = QuaternionFromRotationVector({0, -kSlope, 0});
    const QuadrupedModel model(params.robot);
    const Vec<3> com = test::DynamicsOf(model, state).com_W, com_B = state.R_WB().transpose() * com;
    weight = model.mass() * model.gravity();
    for (const double side : {1.0, -1.0}) {
      const Vec<3> attachment = com_B + Vec<3>(0, 0.1 * side, 0);
      const Vec<3> along = state.R_WB() * Vec<3>(std::cos(kSide), std::sin(kSide) * side, 0);
      params.ropes.push_back(
          {side > 0 ? "left" : "right", state.R_WB() * attachment + 5 * along, attachment, 0, tension_max});
    }
  }
};

// Statics: 2 T cos(kSide) = m g sin(slope), and the feet carry m g cos(slope) along the normal.
TEST(RopeTensionsTest, CarryTheWeightAlongTheSlope) {
  const OnSlope on;
  TestRig<RopeTensions> rig(on.params);
  rig.Fix(rig->state, on.state).Fix(rig->ground, on.ground);
  rig.Fix(rig->tension, CableVector(Vec<2>::Zero())).Tick();
  const double tension = on.weight * std::sin(kSlope) / (2 * std::cos(kSide));
  const CableVector command = rig[rig->command];
  EXPECT_THAT(command, IsNear(Vec<2>(tension, tension), 1e-3));
  EXPECT_TRUE(rig[rig->wrench].force_W.isZero(0));

  rig.Fix(rig->tension, command).Tick();
  const Vec<3> feet = Vec<3>(0, 0, on.weight) - rig[rig->wrench].force_W;
  EXPECT_THAT(feet, IsNear(Vec<3>(on.weight * std::cos(kSlope) * on.ground.Normal()), 1e-2));
  EXPECT_TRUE(rig[rig->wrench].torque_W.isZero(1e-3));

  rig.Set(rig->share, 0.5);
  EXPECT_THAT(rig.Tick()[rig->command], IsNear(Vec<2>(tension, tension) / 2, 1e-3));
  rig.Fix(rig->ground, GroundPlane());
  EXPECT_THAT(rig.Tick()[rig->command], IsNear(Vec<2>(0, 0), 1e-3));
}

TEST(RopeTensionsTest, StayWithinTheirLimits) {
  OnSlope on(50);
  on.params.ropes[0].tension_min = 5;
  TestRig<RopeTensions> rig(on.params);
  rig.Fix(rig->tension, CableVector(Vec<2>::Zero()));
  rig.Fix(rig->state, on.state).Fix(rig->ground, on.ground).Tick();
  EXPECT_THAT(rig[rig->command], IsNear(Vec<2>(50, 50), 1e-9));
  rig.Fix(rig->ground, GroundPlane{.slope = {-1, 0}});  // the ropes would have to push
  EXPECT_THAT(rig.Tick()[rig->command], IsNear(Vec<2>(5, 0), 1e-9));
}

TEST(RopeTensionsTest, DoNotAllocate) {
  const OnSlope on;
  TestRig<RopeTensions> rig(on.params);
  rig.Fix(rig->tension, CableVector(Vec<2>::Zero()));
  rig.Fix(rig->state, on.state).Fix(rig->ground, on.ground).Tick();
  EXPECT_EQ(AllocationsOf([&] { rig.Tick(); }), 0);
}

}  // namespace
}  // namespace tenon::rope_tensions_test
