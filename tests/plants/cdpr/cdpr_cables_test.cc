// CdprPlant with cables that sag, pulleys, drums with layers and differentials.

#include <tenon/tests/plants/cdpr/cdpr_plant_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::cdpr_cables_test {

using test::FourCableRobot, test::Hanging;
using Rig = TestRig<CdprPlant>;
using test::RandomPlatform;

struct Kind {
  const char* name;
  double mass_per_length, pulley_radius;
  bool on_platform = false;
  CdprDescription Robot() const {
    CdprDescription robot = FourCableRobot(mass_per_length, pulley_radius);
    robot.winch.pulleys_on_platform = on_platform;
    return robot;
  }
};
class CdprCablesOfKinds : public ::testing::TestWithParam<Kind> {};
INSTANTIATE_TEST_SUITE_P(Cables, CdprCablesOfKinds,
                         ::testing::Values(Kind{"light", 0, 0}, Kind{"pulley", 0, 0.05},
                                           Kind{"heavy", 0.05, 0}, Kind{"heavy_pulley", 0.05, 0.05},
                                           Kind{"on_platform", 0, 0.05, true}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST_P(CdprCablesOfKinds, AnUndampedDropKeepsItsEnergy) {
  CdprDescription robot = GetParam().Robot();
  robot.cable.axial_damping = 0;
  CdprPlantParams params = Hanging(robot);
  params.lock_winches = true;
  Rig rig(params);
  rig.Fix(rig->command, CableVector::Zero(4));
  PlatformState x = rig[rig->platform_state];
  x.p_WB += Vec<3>(0.01, 0.005, 0.1);  // all slack without weight
  x.w_W = {0.2, -0.3, 0.1};
  rig.Set(rig->platform_state, x);
  const double before = rig[rig->energy].total();
  const double tension_before = rig[rig->cables].tension.maxCoeff();
  EXPECT_LT(tension_before, 20);
  double hardest = 0;
  for (int i = 1; i <= 20; ++i) {
    rig.RunTo(0.05 * i);
    EXPECT_NEAR(rig[rig->energy].total(), before, 2e-6);
    hardest = std::max(hardest, rig[rig->cables].tension.maxCoeff());
  }
  EXPECT_GT(hardest, 200);  // it fell into the cables
}

TEST_P(CdprCablesOfKinds, DampingTakesEnergy) {
  CdprPlantParams params = Hanging(GetParam().Robot());
  params.lock_winches = true;
  params.v_W = {0, 0, 0.3};
  Rig rig(params);
  rig.Fix(rig->command, CableVector::Zero(4));
  const double start = rig[rig->energy].total();
  double before = start;
  for (int i = 1; i <= 20; ++i) {
    rig.RunTo(0.05 * i);
    EXPECT_LE(rig[rig->energy].total(), before + 1e-9);
    before = rig[rig->energy].total();
  }
  EXPECT_LT(before, start - 0.1);
}

TEST_P(CdprCablesOfKinds, StartsWithItsTensionsAndOutputsIdealLengths) {
  CdprPlantParams params = Hanging(GetParam().Robot());
  params.p_WB = {0.3, -0.4, 1.2};
  params.euler = {0.1, -0.2, 0.7};
  params.initial_tension = Eigen::Vector4d(40, 50, 60, 70);
  Rig rig(params), ideal([&] {
    CdprPlantParams other = params;
    other.robot = FourCableRobot(0, 0);
    return other;
  }());
  EXPECT_THAT(rig[rig->cables].tension, IsNear(params.initial_tension, 1e-7));
  EXPECT_THAT(rig[rig->cables].length, IsNear(ideal[ideal->cables].length, 1e-10));
}

constexpr double kPi = std::numbers::pi;
constexpr double kGrooves = 0.005 * 0.8660254037844386;

/// Winches with two layers at the start, the second of which has `second` of cable on it.
CdprPlantParams Layered(double second, WinchMode mode = WinchMode::kTension) {
  CdprPlantParams params = Hanging();
  params.robot.winch.mode = mode;
  const double rest = Rig(params)->start.rest_length[0];
  params.robot.winch.drum = DrumProperties{.radius = 0.036,
                                           .cable_diameter = 0.005,
                                           .turns_per_layer = 10,
                                           .cable_length = rest + 20 * kPi * 0.036 + second};
  return params;
}

TEST(CdprCablesTest, OutputsTheTurnsOfADrumAsLengthOfTheFirstRadius) {
  Rig rig(Layered(0.1));
  const double length = rig[rig->cables].length[0], rest = rig[rig->rest_length][0];
  for (const double more : {-0.2, 0.05, 0.1, 0.3, 1.0}) {
    rig.Set(rig->rest_length, Eigen::VectorXd::Constant(4, rest + more));
    const double told = more <= 0.1 ? more : 0.1 + (more - 0.1) * (0.036 + kGrooves) / 0.036;
    EXPECT_NEAR(rig[rig->cables].length[0] - length, told - more, 1e-12);  // the true length is what it was
  }
}

TEST(CdprCablesTest, ADrumPaysOutByTheRadiusOfItsLayer) {
  const double ratio = 0.036 / (0.036 + kGrooves);
  for (const WinchMode mode : {WinchMode::kTension, WinchMode::kTorque}) {
    Rig plain(Hanging([&] {
      CdprDescription robot = FourCableRobot();
      robot.winch.mode = mode;
      return robot;
    }()));
    Rig layered(Layered(0.002, mode));  // soon on the first layer
    const double rest = plain[plain->rest_length][0] + 0.003;
    for (Rig* rig : {&plain, &layered}) {
      rig->Set((*rig)->rest_length, Eigen::VectorXd::Constant(4, rest));
      rig->Set((*rig)->reel_speed, Eigen::VectorXd::Constant(4, 0.1));
      rig->Fix((*rig)->command, CableVector::Zero(4));
    }
    const double T_m = plain[plain->motor_tension][0];
    const double plain_tension = plain[plain->cables].tension[0],
                 tension = layered[layered->cables].tension[0];
    const double rate = layered.Derivative(layered->rest_length)[0];
    if (mode == WinchMode::kTorque) {
      EXPECT_NEAR(rate, 0.1 * ratio, 1e-15);
      EXPECT_NEAR(tension, plain_tension + 135 / rest * 0.1 * (1 - ratio), 1e-9);
      EXPECT_NEAR(layered.Derivative(layered->reel_speed)[0], (tension * ratio - T_m - 90 * 0.1) / 8, 1e-9);
      // No power is lost at the drum: m v dv/dt = T dl0/dt - T_m v - b v^2.
      EXPECT_NEAR(8 * 0.1 * layered.Derivative(layered->reel_speed)[0],
                  tension * rate - T_m * 0.1 - 90 * 0.1 * 0.1, 1e-9);
    } else {
      EXPECT_NEAR(rate, ratio * (tension - T_m) / 90, 1e-12);
      // The tension includes the damping at the present rate.
      const double strained =
          27e3 / rest *
          (layered->start.rest_length[0] * (1 + layered->params.initial_tension[0] / 27e3) - rest);
      EXPECT_NEAR(tension, strained - 135 / rest * rate, 1e-9);
    }
  }
}

TEST(CdprCablesTest, TheLengthRateOfADrumIsTheDerivativeOfItsLength) {
  Rig rig(Layered(0.0005));
  rig.Fix(rig->command, CableVector::Constant(4, 30));  // it sinks
  rig.RunTo(0.2);
  ASSERT_GT(rig[rig->rest_length][0], rig->start.rest_length[0] + 0.0005);
  const double before = rig[rig->cables].length[0], rate = rig[rig->cables].length_rate[0];
  rig.RunTo(0.2001);
  EXPECT_NEAR((rig[rig->cables].length[0] - before) / 1e-4, (rate + rig[rig->cables].length_rate[0]) / 2,
              1e-5 * std::abs(rate));
}

TEST(CdprCablesTest, ADifferentialSharesItsMotors) {
  CdprPlantParams params = Hanging();
  params.robot.winch.differential = DifferentialProperties{.pairs = {{0, 2}}, .motor_tension_max = 100};
  Rig rig(params);
  const auto asked = [&](const Eigen::Vector4d& command) -> Eigen::Vector4d {
    rig.Fix(rig->command, command);
    return rig.Derivative(rig->motor_tension) * 0.02 + rig[rig->motor_tension];
  };
  const auto gets = [&](const Eigen::Vector4d& command, const Eigen::Vector4d& expected) {
    EXPECT_THAT(asked(command), IsNear(expected, 1e-12)) << command.transpose();
  };
  gets({60, 500, 90, 700}, {60, 500, 90, 700});  // 150 N of the 200 N; the others have a motor each
  gets({200, 0, 0, 0}, {200, 0, 0, 0});          // one cable alone has both motors
  gets({250, 0, 0, 0}, {200, 0, 0, 0});
  gets({150, 0, 100, 0}, {125, 0, 75, 0});  // the sum is what is lacking, the difference stays
  gets({-50, 0, 300, -10}, {0, 0, 200, 0});
}

TEST(CdprCablesTest, DoesNotAllocate) {
  CdprPlantParams params = Layered(0.1);
  params.robot.cable.mass_per_length = 0.05;
  params.robot.winch.pulley_radius = 0.04;
  params.robot.winch.differential =
      DifferentialProperties{.pairs = {{0, 1}, {2, 3}}, .motor_tension_max = 400};
  Rig rig(params);
  rig.Fix(rig->command, CableVector::Constant(4, 60));
  rig.RunTo(0.1);
  EXPECT_EQ(AllocationsOf([&] { rig.RunTo(0.2); }), 0);
}

TEST(CdprCablesTest, RefusesImpossibleStarts) {
  EXPECT_TRUE(Refuses<CdprPlant>(Hanging(FourCableRobot(0, 4)), "cable 0"));
  CdprPlantParams params = Hanging(FourCableRobot(1, 0));
  params.initial_tension.setConstant(5);
  EXPECT_TRUE(Refuses<CdprPlant>(params, "cable 0", "5 N"));
  params.gravity = -9.81;
  EXPECT_TRUE(Refuses<CdprPlant>(params, "gravity"));
  EXPECT_TRUE(Refuses<CdprPlant>(Hanging(Kind{"", 0.05, 0.05, true}.Robot()), "pulleys_on_platform"));
  params = Layered(0.1);
  params.robot.winch.drum->cable_length = 2;
  EXPECT_TRUE(Refuses<CdprPlant>(params, "cable 0", "cable_length_m"));
}

TEST(CdprCablesTest, ACableThatRunsOutEndsTheRun) {
  Rig rig(Layered(0.1));
  rig.Set(rig->rest_length, Eigen::VectorXd::Constant(4, 30));
  EXPECT_TRUE(Throws<RunError>([&] { rig[rig->cables]; }, "cable 0", "30 m"));
}

const Shape& Named(const Geometry& geometry, const std::string& name) {
  const auto found =
      std::find_if(geometry.begin(), geometry.end(), [&](const Shape& s) { return s.name == name; });
  EXPECT_NE(found, geometry.end()) << name;
  return *found;
}

TEST(CdprGeometryTest, CablesRunFromAttachmentsToAnchorsAndShowTheirTension) {
  TestRig<CdprPlant> rig(Hanging(test::WithSprings(test::FourCableRobot())));
  RandomStream random(1);
  for (int k = 0; k < 20; ++k) {
    const PlatformState x = RandomPlatform(random);
    rig.Set(rig->platform_state, x);
    const Geometry& geometry = rig[rig->geometry];
    EXPECT_THAT(Named(geometry, "platform").p_W, IsNear(x.p_WB, 1e-14));
    EXPECT_THAT(RotationFromQuaternion(Named(geometry, "platform").q_W), IsNear(x.R_WB(), 1e-14));
    for (int i = 0; i < 4; ++i) {
      const CableDescription& cable = rig->params.robot.cables[i];
      const Shape& shape = Named(geometry, "cable " + std::to_string(i));
      EXPECT_THAT(shape.p_W, IsNear(x.p_WB + x.R_WB() * cable.attachment_B, 1e-14));
      EXPECT_THAT(Vec<3>(shape.p_W + shape.vector_W), IsNear(cable.anchor_W, 1e-14));
      EXPECT_EQ(shape.value, rig[rig->cables].tension[i]);
      EXPECT_EQ(shape.unit, "N");
      EXPECT_EQ(Named(geometry, "anchor " + std::to_string(i)).p_W, cable.anchor_W);
    }
    const SpringDescription& spring = rig->params.robot.springs[1];
    const Shape& shape = Named(geometry, "spring 1");
    EXPECT_EQ(shape.p_W, spring.anchor_W);
    EXPECT_THAT(Vec<3>(shape.p_W + shape.vector_W),
                IsNear(Vec<3>(x.p_WB + x.R_WB() * spring.attachment_B), 1e-14));
  }
}

TEST(CdprGeometryTest, SaggingCablesRunInPiecesToTheirPulleys) {
  const CdprDescription robot = FourCableRobot(1, 0.1);
  CdprPlantParams params = Hanging(robot);
  params.initial_tension.setConstant(60);
  TestRig<CdprPlant> rig(params);
  const Geometry& geometry = rig[rig->geometry];
  for (int i = 0; i < 4; ++i) {
    const CableDescription& cable = robot.cables[i];
    const Shape& pulley = Named(geometry, "pulley " + std::to_string(i));
    EXPECT_NEAR((pulley.p_W - cable.anchor_W).norm(), 0.1, 1e-15);
    Vec<3> end = params.p_WB + cable.attachment_B;
    const Vec<3> chord = cable.anchor_W - end;
    double length = 0, sag = 0;
    for (const Shape& piece : geometry) {
      if (piece.name != "cable " + std::to_string(i)) continue;
      EXPECT_THAT(piece.p_W, IsNear(end, 1e-10));
      end = piece.p_W + piece.vector_W;
      length += piece.vector_W.norm();
      const double part = (end - params.p_WB - cable.attachment_B).head<2>().norm() / chord.head<2>().norm();
      sag = std::max(sag, params.p_WB[2] + cable.attachment_B[2] + part * chord[2] - end[2]);
    }
    const double wrapped = (end - cable.anchor_W).norm();
    EXPECT_NEAR((end - pulley.p_W).norm(), 0.1, 1e-10);
    EXPECT_LT(length + wrapped, rig[rig->rest_length][i] * (1 + 60 / 27e3));
    EXPECT_GT(sag, 0.3);  // w l^2 / (8 T) = 9.81 * 6.1^2 / (8 * 60) and more
    const Vec<3> axle = RotationFromQuaternion(pulley.q_W).col(2);
    EXPECT_NEAR(axle.dot(chord), 0, 1e-12);
    EXPECT_NEAR(axle[2], 0, 1e-15);
  }
}

TEST(CdprGeometryTest, PlatformReachesItsAttachmentsAndIsNeverFlat) {
  EXPECT_THAT(Named(MakeCdprGeometry(FourCableRobot()), "platform").size,
              IsNear(Vec<3>(0.15, 0.15, 0.186), 1e-15));
  CdprDescription flat = FourCableRobot();
  for (CableDescription& cable : flat.cables) cable.attachment_B[2] = 0;
  EXPECT_EQ(Named(MakeCdprGeometry(flat), "platform").size[2], 0.04);
}

TEST(CdprGeometryTest, PayloadAndForceShowWhenTheyAreThere) {
  TestRig<CdprPlant> rig(Hanging());
  EXPECT_FALSE(Named(rig[rig->geometry], "payload").visible);
  rig.Fix(rig->payload, {2, {0.1, 0, 0}}).Fix(rig->wrench, {{0, 30, 0}, {0, 0, 0}});
  const Geometry& geometry = rig[rig->geometry];
  EXPECT_TRUE(Named(geometry, "payload").visible);
  EXPECT_THAT(Named(geometry, "payload").p_W, IsNear(Vec<3>(0.1, 0, 1.5), 1e-14));
  EXPECT_THAT(Named(geometry, "external force").vector_W, IsNear(Vec<3>(0, 30, 0), 0));
}

TEST(CdprGeometryTest, MovingItDoesNotAllocate) {
  const CdprDescription robot = FourCableRobot(0.05, 0.04);
  Geometry geometry = MakeCdprGeometry(robot);
  RandomStream random(1);
  const PlatformState x = RandomPlatform(random);
  const CableVector tension = CableVector::Constant(4, 100);
  std::vector<CableStatics> cables;
  for (int i = 0; i < 4; ++i) {
    const CableDescription& cable = robot.cables[i];
    const Vec<3> span = cable.anchor_W - x.p_WB - x.R_WB() * cable.attachment_B;
    cables.push_back(CalcCableStatics(robot, i, span, span.norm(), 9.81));
  }
  EXPECT_EQ(AllocationsOf([&] { MoveCdprGeometry(robot, x, tension, cables, {}, {}, &geometry); }), 0);
}

}  // namespace tenon::cdpr_cables_test
