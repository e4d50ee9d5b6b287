// A cable robot with additions in Simbody: agreement with the closed form, conservation laws, balance,
// errors.

#include <tenon/plants/attached_bodies.h>
#include <tenon/plants/cdpr/cdpr_multibody.h>
#include <tenon/tests/plants/cdpr/cdpr_plant_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

namespace tenon::cdpr_multibody_test {

using test::Hanging, test::RandomPlatform, test::RandomVector;
using Rig = TestRig<CdprPlant>;

AttachedBody Ball(const std::string& name, AttachedJoint joint, double radius = 0.05) {
  return {.name = name, .joint = joint, .mass = 2, .radius = radius};
}

/// An arm of two links under springs.
std::vector<AttachedBody> Arm() {
  AttachedBody upper = Ball("upper", AttachedJoint::kPin), fore = Ball("fore", AttachedJoint::kPin);
  upper.position = {0.1, 0, -0.1};
  upper.centre = fore.position = {0, 0, -0.4};
  upper.stiffness = fore.stiffness = 30;
  fore.on = "upper";
  fore.axis = {1, 0.2, 0};
  fore.centre = {0, 0.1, -0.3};
  fore.mass = 1;
  return {upper, fore};
}

CdprPlantParams With(const ExtendCdpr& extend, int num_cables = 4) {
  CdprPlantParams params = Hanging(test::RobotWithCables(num_cables));
  params.extend = extend;
  return params;
}
CdprPlantParams With(const std::vector<AttachedBody>& bodies) {
  return With(AttachToPlatform(bodies));
}

/// Breaks all cables, so that the platform moves freely.
void CutCables(Rig& rig) {
  const CableVector all = CableVector::Ones(rig->params.robot.num_cables());
  rig.Fix(rig->faults, {0 * all, all}).Fix(rig->command, 0 * all);
}

/// Compares a plant without additions with one to which nothing is added, and with one whose payload is a
/// body.
TEST(CdprMultibodyTest, AgreesWithTheClosedForm) {
  const Payload payload{3, {0.1, -0.2, 0.15}};
  AttachedBody point = Ball("point", AttachedJoint::kWeld, 1e-9);
  point.mass = payload.mass;
  point.position = payload.p_B;
  RandomStream random(81);
  int taut = 0;
  for (const int num_cables : {4, 12}) {
    Rig plain(With(ExtendCdpr(), num_cables)), nothing(With([](CdprMultibody&) {}, num_cables));
    Rig welded(With(AttachToPlatform({point}), num_cables));
    plain.Fix(plain->payload, payload);
    nothing.Fix(nothing->payload, payload);
    for (int i = 0; i < 500; ++i) {
      const PlatformState x = RandomPlatform(random);
      const PlatformWrench wrench{RandomVector(random, 50), RandomVector(random, 10)};
      const Eigen::VectorXd rest = random.Uniform(0.8, 1.1) * plain->start.rest_length;
      for (Rig* rig : {&plain, &nothing, &welded})
        rig->Set((*rig)->platform_state, x).Set((*rig)->rest_length, rest).Fix((*rig)->wrench, wrench);
      if (plain[plain->cables].tension.maxCoeff() > 0) ++taut;
      const PlatformAcceleration expected = plain[plain->acceleration];
      const CdprEnergy energy = plain[plain->energy];
      const double size = expected.a_W.norm() + expected.alpha_W.norm();
      for (Rig* rig : {&nothing, &welded}) {
        EXPECT_THAT((*rig)[(*rig)->acceleration].a_W, IsNear(expected.a_W, 1e-10 * size));
        EXPECT_THAT((*rig)[(*rig)->acceleration].alpha_W, IsNear(expected.alpha_W, 1e-10 * size));
        EXPECT_NEAR((*rig)[(*rig)->energy].kinetic, energy.kinetic, 1e-11 * energy.kinetic);
        EXPECT_NEAR((*rig)[(*rig)->energy].total(), energy.total(), 1e-11 * energy.total());
      }
      EXPECT_THAT(nothing[nothing->added_wrench].force_W, IsNear(Vec<3>::Zero(), 1e-10 * 20 * size));
      EXPECT_THAT(nothing[nothing->added_wrench].torque_W, IsNear(Vec<3>::Zero(), 1e-10 * 20 * size));
    }
  }
  EXPECT_GT(taut, 500);
}

/// Momentum and centre of mass by a System of the test.
struct Momentum {
  explicit Momentum(Rig& rig) : of(rig->params.robot, rig->params.gravity) {
    rig->params.extend(of);
    of.system.realizeTopology();
    SimTK::State state = of.system.getDefaultState();
    of.system.realizeModel(state);
    const PlatformState& x = rig[rig->platform];
    for (int i = 0; i < 4; ++i) state.updQ()[i] = x.q_WB[i];
    for (int i = 0; i < 3; ++i)
      state.updQ()[4 + i] = x.p_WB[i], state.updU()[i] = x.w_W[i], state.updU()[3 + i] = x.v_W[i];
    for (int i = 0; i < 2; ++i) {
      state.updQ()[7 + i] = rig[rig->added_positions][i];
      state.updU()[6 + i] = rig[rig->added_speeds][i];
    }
    of.system.realize(state, SimTK::Stage::Velocity);
    const SimTK::SpatialVec momentum = of.matter.calcSystemCentralMomentum(state);
    for (int i = 0; i < 3; ++i) angular[i] = momentum[0][i], linear[i] = momentum[1][i];
  }
  CdprMultibody of;
  Vec<3> angular, linear;
};

TEST(CdprMultibodyTest, InFreeMotionMomentumAndEnergyStay) {
  CdprPlantParams params = With(Arm());
  params.w_W = {1, -2, 0.5};
  params.v_W = {0.3, 0.2, 3};
  Rig rig(params);
  CutCables(rig);
  rig.Set(rig->added_u, Eigen::Vector2d(2, -3));
  const Momentum before(rig);
  const double energy = rig[rig->energy].total();
  rig.RunTo(0.6);
  const Momentum after(rig);
  EXPECT_THAT(after.angular, IsNear(before.angular, 1e-6));
  EXPECT_THAT(after.linear, IsNear(before.linear + 0.6 * 18 * Vec<3>(0, 0, -params.gravity), 1e-6));
  EXPECT_GT(rig[rig->added_positions].norm(), 0.1);
  EXPECT_NEAR(rig[rig->energy].total(), energy, 1e-7 * energy);
}

/// By Newton and Euler for a load that is welded to the platform: f = m (g - a), t = r x f - I alpha - w x I
/// w.
TEST(CdprMultibodyTest, TheAddedWrenchIsTheReactionOfTheLoad) {
  AttachedBody load = Ball("load", AttachedJoint::kWeld);
  load.position = {0.1, 0.05, -0.3};
  CdprPlantParams params = With({load});
  params.w_W = {0.3, -0.5, 0.4};
  Rig rig(params);
  rig.Fix(rig->payload, {1.5, {0.1, 0, 0.1}}).Fix(rig->wrench, {{20, -10, 5}, {1, 2, 3}});
  const PlatformAcceleration a = rig[rig->acceleration];
  const Vec<3> r = load.position, w = params.w_W;
  const Vec<3> force = 2 * (Vec<3>(0, 0, -params.gravity) - a.a_W - a.alpha_W.cross(r) - w.cross(w.cross(r)));
  EXPECT_THAT(rig[rig->added_wrench].force_W, IsNear(force, 1e-9));
  EXPECT_THAT(rig[rig->added_wrench].torque_W,
              IsNear((r.cross(force) - 0.4 * 2 * 0.05 * 0.05 * a.alpha_W).eval(), 1e-9));
}

TEST(CdprMultibodyTest, AddedJointsHaveNamedPortsAndShapes) {
  Rig rig(With(Arm()));
  CutCables(rig);
  EXPECT_EQ(rig->additions.u.spec.elements, "upper,fore");
  EXPECT_EQ(rig->additions.position_references.spec.elements, "upper,fore");
  EXPECT_EQ(rig->additions.position_references.spec.units, "rad,rad");
  const Vec<3> fore = rig->params.p_WB + Vec<3>(0.1, 0.1, -0.8);
  EXPECT_THAT(rig[rig->geometry].back().p_W, IsNear(fore, 1e-12));
  const Eigen::VectorXd before = rig.Derivative(rig->added_u);
  rig.Fix(rig->added_forces, Eigen::Vector2d(0, 5));
  EXPECT_GT(rig.Derivative(rig->added_u)[1], before[1] + 1);
}

TEST(CdprMultibodyTest, RefusesAdditionsThatMakeNoSense) {
  AttachedBody body = Ball("load", AttachedJoint::kPin);
  body.on = "platfrom";
  EXPECT_TRUE(Throws<ParameterError>([&] { Rig rig(With({body})); }, "platfrom", "'platform'"));
  Rig rig(With(Arm()));
  EXPECT_TRUE(Throws<RunError>([&] { rig.Fix(rig->added_forces, Eigen::VectorXd::Zero(3)); }, "added_forces",
                               "2 x 1"));
  EXPECT_TRUE(Throws<RunError>([&] { rig.Fix(rig->added_speed_references, Eigen::VectorXd(1)); },
                               "added_speed_references"));
}

}  // namespace tenon::cdpr_multibody_test
