#include <tenon/plants/cdpr/cdpr_geometry.h>
#include <tenon/tests/plants/cdpr/cdpr_plant_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <algorithm>

namespace tenon::cdpr_geometry_test {

using test::FourCableRobot;
using test::Hanging;
using test::RandomPlatform;

const Shape& Named(const Geometry& geometry, const std::string& name) {
  const auto found =
      std::find_if(geometry.begin(), geometry.end(), [&](const Shape& s) { return s.name == name; });
  EXPECT_NE(found, geometry.end()) << name;
  return *found;
}

TEST(CdprGeometryTest, CablesRunFromAttachmentsToAnchorsAndShowTheirTension) {
  TestRig<CdprPlant> rig(Hanging());
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

}  // namespace tenon::cdpr_geometry_test
