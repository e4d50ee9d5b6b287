#include <tenon/plants/legged/quadruped_geometry.h>
#include <tenon/plants/legged/quadruped_plant.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/tests/plants/model/mesh_test_files.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/temporary_path.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <filesystem>
#include <fstream>

namespace tenon::quadruped_geometry_test {

using test::A1;
using test::DogBot;
using test::RandomState;

const Shape& Named(const Geometry& geometry, const std::string& name) {
  const auto found =
      std::find_if(geometry.begin(), geometry.end(), [&](const Shape& s) { return s.name == name; });
  EXPECT_NE(found, geometry.end()) << name;
  return *found;
}

QuadrupedPlantParams Params(const QuadrupedDescription& robot) {
  return {.robot = robot, .initial = test::Standing(robot)};
}

/// The end of a capsule's axis: +1 or -1.
Vec<3> End(const Shape& capsule, double side) {
  return capsule.p_W + RotationFromQuaternion(capsule.q_W) * Vec<3>(0, 0, side * capsule.size[1] / 2);
}

TEST(QuadrupedGeometryTest, LinksAndFeetAreWhereSimbodyHasThem) {
  for (const QuadrupedDescription& robot : {DogBot(), A1()}) {
    TestRig<QuadrupedPlant> rig(Params(robot));
    RandomStream random(3);
    for (int k = 0; k < 5; ++k) {
      rig.Set(rig->motion, RandomState(random));
      const Geometry& geometry = rig[rig->geometry];
      const QuadrupedBody& body = rig[rig->body];
      for (int leg = 0; leg < kNumLegs; ++leg) {
        const auto at = static_cast<std::size_t>(leg);
        EXPECT_THAT(Named(geometry, std::string("foot ") + kLegNames[at]).p_W,
                    IsNear(body.Foot(leg).p_W, 1e-12));
        for (int i = 0; i < kJointsPerLeg; ++i) {
          const int j = kJointsPerLeg * leg + i;
          const Shape& link = Named(geometry, "link of " + robot.joint(j).name);
          const Vec<3> end = i < 2 ? body.Position(j + 2, Vec<3>::Zero()) : body.Foot(leg).p_W;
          EXPECT_THAT(End(link, -1), IsNear(body.Position(j + 1, Vec<3>::Zero()), 1e-12));
          EXPECT_THAT(End(link, 1), IsNear(end, 1e-12));
        }
      }
    }
  }
}

// A robot with meshes on its trunk and, turned and scaled, on a link that hangs on the shank: each corner is
// where Simbody has that point of the body.
TEST(QuadrupedGeometryTest, MeshesMoveWithTheirBodies) {
  const std::filesystem::path home = test::TemporaryPath("robot_with_meshes");
  test::WriteTetrahedron(home / "t.stl");
  const auto read = [](const char* name) {
    std::ifstream in(std::string(TENON_ROBOTS_DIR "/") + name);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  std::string urdf = read("a1.urdf");
  const auto add = [&](const std::string& link, const std::string& visual) {
    const std::string start = "<link name=\"" + link + "\">";
    const std::size_t at = urdf.find(start);
    ASSERT_NE(at, std::string::npos) << link;
    urdf.insert(at + start.size(), "<visual>" + visual + "</visual>");
  };
  add("trunk", "<geometry><mesh filename=\"t.stl\"/></geometry>");
  add("FL_calf",
      "<origin xyz=\"0.1 0.2 0.3\" rpy=\"0 0 1.5707963267948966\"/>"
      "<geometry><mesh filename=\"t.stl\" scale=\"0.1 0.1 0.1\"/></geometry>"
      "<material name=\"paint\"><color rgba=\"1 0.5 0 1\"/></material>");
  std::ofstream(home / "a1.urdf") << urdf;
  std::ofstream(home / "a1.yaml") << read("a1.yaml");
  const QuadrupedDescription robot = LoadQuadruped((home / "a1.yaml").string());
  std::filesystem::remove_all(home);

  TestRig<QuadrupedPlant> rig(Params(robot));
  RandomStream random(3);
  rig.Set(rig->motion, RandomState(random));
  const Geometry& geometry = rig[rig->geometry];
  const QuadrupedBody& body = rig[rig->body];
  const auto corners = [](const Shape& shape) {
    std::vector<Vec<3>> points;
    for (const auto& [x, y, z] : shape.mesh->corners)
      points.push_back(shape.p_W + RotationFromQuaternion(shape.q_W) * Vec<3>(x, y, z));
    return points;
  };
  const auto holds = [](const std::vector<Vec<3>>& points, const Vec<3>& p) {
    return std::ranges::any_of(points, [&](const Vec<3>& q) { return (p - q).norm() < 1e-6; });
  };
  const Shape& trunk = Named(geometry, "trunk");
  const Shape& shank = Named(geometry, "link of FL_calf_joint");
  ASSERT_EQ(trunk.kind, ShapeKind::kMesh);
  ASSERT_EQ(shank.kind, ShapeKind::kMesh);
  EXPECT_EQ(Named(geometry, "link of FR_calf_joint").kind, ShapeKind::kCapsule);
  EXPECT_TRUE(trunk.mesh->colours.empty());
  EXPECT_THAT(shank.mesh->colours, ::testing::SizeIs(4));
  EXPECT_THAT(shank.mesh->colours, ::testing::Each(std::array<std::uint8_t, 4>{255, 128, 0, 255}));
  for (const Vec<3>& p : {Vec<3>(0, 0, 0), Vec<3>(1, 0, 0), Vec<3>(0, 2, 0), Vec<3>(0, 0, 3)}) {
    EXPECT_TRUE(holds(corners(trunk), body.Position(0, p)));
    const Vec<3> turned(-p[1], p[0], p[2]);
    EXPECT_TRUE(holds(corners(shank), body.Position(3, Vec<3>(0.1, 0.2, 0.3) + 0.1 * turned)));
  }
}

TEST(QuadrupedGeometryTest, TrunkIsTheBoxOfItsInertiaAndHoldsTheLegs) {
  QuadrupedDescription robot = DogBot();
  const Vec<3> edges(0.8, 0.4, 0.2), squares = edges.cwiseAbs2();
  robot.trunk.inertia =
      Vec<3>(robot.trunk.mass / 12 * (Vec<3>::Constant(squares.sum()) - squares)).asDiagonal();
  EXPECT_THAT(Named(MakeQuadrupedGeometry(robot, {}, {}), "trunk").size, IsNear(edges, 1e-12));
  for (LegDescription& leg : robot.legs) leg.joints[0].p_PJ *= 2;
  const Vec<3> hip = robot.legs[0].joints[0].p_PJ.cwiseAbs();
  EXPECT_NEAR(Named(MakeQuadrupedGeometry(robot, {}, {}), "trunk").size[0], 2 * hip[0], 1e-12);
}

TEST(QuadrupedGeometryTest, PayloadIsABoxOnTheTrunk) {
  QuadrupedPlantParams params = Params(DogBot());
  params.payload.mass = 3;
  params.payload.com = {0.1, 0, 0.2};
  params.payload.inertia.diagonal() = 3.0 / 12 * Vec<3>(0.05, 0.10, 0.13);  // edges of 0.3, 0.2, 0.1 m
  TestRig<QuadrupedPlant> rig(params);
  LeggedState x = test::Standing(DogBot());
  x.q_WB = QuaternionFromRotationVector({0.1, -0.2, 1});
  rig.Set(rig->motion, x);
  const Shape& box = Named(rig[rig->geometry], "payload");
  EXPECT_TRUE(box.visible);
  EXPECT_THAT(box.size, IsNear(Vec<3>(0.3, 0.2, 0.1), 1e-12));
  EXPECT_THAT(box.p_W, IsNear(x.p_WB + x.R_WB() * params.payload.com, 1e-12));
  EXPECT_THAT(box.q_W, IsNear(x.q_WB, 1e-12));
  EXPECT_FALSE(Named(MakeQuadrupedGeometry(DogBot(), {}, {}), "payload").visible);
}

TEST(QuadrupedGeometryTest, ForcesActAtTheirPoints) {
  TestRig<QuadrupedPlant> rig(Params(DogBot()));
  ExternalForces forces;
  forces[2] = {3, {0, 0, -0.1}, {0, 30, 0}};
  LeggedState pressed = test::Standing(DogBot());
  pressed.p_WB[2] -= 0.001;
  rig.Set(rig->motion, pressed).Fix(rig->external, forces);
  const Geometry& geometry = rig[rig->geometry];
  const Shape& arrow = Named(geometry, "external force 2");
  EXPECT_EQ(arrow.role, ShapeRole::kDisturbance);
  EXPECT_THAT(arrow.p_W, IsNear(rig[rig->body].Position(3, {0, 0, -0.1}), 1e-12));
  EXPECT_EQ(arrow.vector_W, Vec<3>(0, 30, 0));
  const Shape& ground = Named(geometry, "force on rear_left");
  EXPECT_GT(ground.vector_W[2], 1);
  EXPECT_EQ(ground.vector_W, rig[rig->foot_forces][kRearLeft]);
}

// The corners of every drawn box lie on the surface that the terrain reports.
TEST(QuadrupedGeometryTest, TerrainIsDrawnWhereFeetTouchIt) {
  TerrainParams params;
  params.grade = {0.3, -0.1};
  params.boxes = {{{1, 0.5}, {0.3, 0.4}, 0.04, 1}, {{-1, 2}, {0.5, 0.2}, 0.02, 1}};
  const Terrain terrain(params);
  const Geometry geometry = MakeQuadrupedGeometry(DogBot(), {}, params);
  for (const char* name : {"slope", "box 0", "box 1"}) {
    const Shape& shape = Named(geometry, name);
    EXPECT_EQ(shape.role, ShapeRole::kGround);
    for (const double x : {-0.49, 0.49}) {
      for (const double y : {-0.49, 0.49}) {
        const Vec<3> corner = shape.p_W + RotationFromQuaternion(shape.q_W) *
                                              Vec<3>(x * shape.size[0], y * shape.size[1], shape.size[2] / 2);
        EXPECT_NEAR(terrain.At(corner[0], corner[1]).height, corner[2], 1e-12) << name;
      }
    }
  }
  const Geometry level = MakeQuadrupedGeometry(DogBot(), {}, {});
  EXPECT_TRUE(std::none_of(level.begin(), level.end(),
                           [](const Shape& shape) { return shape.role == ShapeRole::kGround; }));
}

TEST(QuadrupedGeometryTest, MovingItDoesNotAllocate) {
  const QuadrupedDescription robot = DogBot();
  Geometry geometry = MakeQuadrupedGeometry(robot, {}, {});
  RandomStream random(1);
  const LeggedState x = RandomState(random);
  EXPECT_EQ(AllocationsOf([&] { MoveQuadrupedGeometry(robot, {}, x, {}, {}, &geometry); }), 0);
}

}  // namespace tenon::quadruped_geometry_test
