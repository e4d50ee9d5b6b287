#include <tenon/plants/legged/quadruped_clearance.h>
#include <tenon/plants/legged/quadruped_plant.h>
#include <tenon/tests/plants/model/mesh_test_files.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>
#include <tenon/tests/testing/temporary_path.h>

#include <Eigen/Geometry>

#include <random>

namespace tenon::quadruped_geometry_test {

using Eigen::Vector3d, test::A1, test::DogBot, test::RandomState;

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
  std::string urdf = ReadText(TENON_ROBOTS_DIR "/a1.urdf");
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
  std::ofstream(home / "a1.yaml") << ReadText(TENON_ROBOTS_DIR "/a1.yaml");
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
  const TerrainParams params{.grade = {0.3, -0.1},
                             .boxes = {{{1, 0.5}, {0.3, 0.4}, 0.04, 1}, {{-1, 2}, {0.5, 0.2}, 0.02, 1}}};
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

class QuadrupedClearanceTest : public ::testing::Test {
 protected:
  LeggedState Standing() const { return test::Standing(robot); }
  /// The least distance between points on the axes of two links' capsules, as the replay draws them, less
  /// their radii.
  double DrawnDistance(const LeggedState& x, int joint, int other) const {
    Geometry shapes = MakeQuadrupedGeometry(robot, {}, {});
    MoveQuadrupedGeometry(robot, {}, x, {}, {}, &shapes);
    const Shape *a = nullptr, *b = nullptr;
    for (const Shape& shape : shapes) {
      if (shape.name == "link of " + robot.joint(joint).name) a = &shape;
      if (shape.name == "link of " + robot.joint(other).name) b = &shape;
    }
    constexpr int kPoints = 100;
    const auto point = [&](const Shape& shape, int i) -> Vector3d {
      const Vector3d axis = RotationFromQuaternion(shape.q_W).col(2);
      return shape.p_W + (static_cast<double>(i) / kPoints - 0.5) * shape.size[1] * axis;
    };
    double least = 1e9;
    for (int i = 0; i <= kPoints; ++i)
      for (int j = 0; j <= kPoints; ++j) least = std::min(least, (point(*a, i) - point(*b, j)).norm());
    return least - a->size[0] - b->size[0];
  }

  /// The least distance of any two legs.
  double LeastDrawn(const LeggedState& x) const {
    double least = 1e9;
    for (int i = 0; i < kNumJoints; ++i)
      for (int j = 0; j < kJointsPerLeg * (i / kJointsPerLeg); ++j)
        least = std::min(least, DrawnDistance(x, i, j));
    return least;
  }

  const QuadrupedDescription robot = test::DogBot();
  const QuadrupedClearance clearance{robot, {}};
};

TEST_F(QuadrupedClearanceTest, AStandingRobotIsClear) {
  for (const QuadrupedDescription& other : {test::DogBot(), test::A1()}) {
    const QuadrupedClearances clear = QuadrupedClearance(other, {}).At(test::Standing(other));
    EXPECT_GT(clear.legs.distance, 0.02) << other.name;
    EXPECT_GT(clear.trunk.distance, 0.005) << other.name;
    EXPECT_GT(clear.ground.distance, 0.05) << other.name;
  }
}

// A box of the file and a capsule across the trunk take the place of the box by the inertia.
TEST_F(QuadrupedClearanceTest, JudgesTheTrunkByItsCollisionShapes) {
  QuadrupedDescription other = robot;
  other.trunk.inertia *= 100;
  const LeggedState x = Standing();
  EXPECT_LT(QuadrupedClearance(other, {}).At(x).ground.distance, 0);
  RoundedBox box, capsule;
  box.half = {0.2, 0.1, 0.05};
  box.R_BS = Eigen::AngleAxisd(0.5, Vector3d::UnitX()).toRotationMatrix();
  capsule.p_B = {0.3, 0, -0.15};
  capsule.half = {0, 0, 0.1};
  capsule.radius = 0.02;
  other.trunk_shapes = {box, capsule};
  const QuadrupedClearance shaped(other, {});
  const QuadrupedClearances::Gap ground = shaped.At(x).ground;
  EXPECT_EQ(ground.leg, -1);
  EXPECT_NEAR(ground.distance, x.p_WB[2] - 0.15 - 0.1 - 0.02, 1e-12);
  EXPECT_NEAR(shaped.To(x.q, {0.6, 0, -0.15}, {0.1, 0, 0}).distance, 0.3 - 0.02, 1e-9);
  EXPECT_EQ(shaped.To(x.q, {0, 0, 0}, {0.1, 0, 0}).distance, 0);
  EXPECT_GT(shaped.OnTrunk({0, 0, 0})[2], 0.05 * std::cos(0.5));
  Geometry shapes = MakeQuadrupedGeometry(other, {}, {});
  MoveQuadrupedGeometry(other, {}, x, {}, {}, &shapes);
  const Shape &drawn = shapes[shapes.size() - 2], &between_hips = shapes.back();
  EXPECT_EQ(drawn.role, ShapeRole::kCollision);
  EXPECT_EQ(drawn.kind, ShapeKind::kCapsule);
  EXPECT_TRUE(drawn.p_W.isApprox(x.p_WB + capsule.p_B, 1e-12));
  EXPECT_NEAR(between_hips.p_W[2] - between_hips.size[2] / 2, x.p_WB[2] - 0.15 - 0.1 - 0.02, 1e-12);
}

// The front left shank swings backwards and meets the rear leg; the distance is that of the drawn capsules.
TEST_F(QuadrupedClearanceTest, FindsLegsThatMeet) {
  LeggedState x = Standing();
  x.q.segment<3>(0) << 0, 1.5, 0;               // front left: straight, backwards
  x.q.segment<3>(3 * kRearLeft) << 0, -1.2, 0;  // rear left: straight, forwards
  const QuadrupedClearances clear = clearance.At(x);
  EXPECT_LT(clear.legs.distance, -0.02);
  EXPECT_EQ(clear.legs.leg, kFrontLeft);
  EXPECT_EQ(clear.legs.other, kRearLeft);
  EXPECT_NEAR(clear.legs.distance, LeastDrawn(x), 0.002);

  x.q.segment<3>(0) << 0, 0.7, -0.5;
  x.q.segment<3>(3 * kRearLeft) << 0, 0.5, -0.5;
  const QuadrupedClearances apart = clearance.At(x);
  EXPECT_GT(apart.legs.distance, 0.01);
  EXPECT_NEAR(apart.legs.distance, LeastDrawn(x), 0.002);
}

// At random poses no pair of links is nearer than the one that is found.
TEST_F(QuadrupedClearanceTest, TheNearestLegsAreThoseThatAreDrawnNearest) {
  std::mt19937 random(61);
  std::uniform_real_distribution<double> angle(-1, 1);
  for (int i = 0; i < 20; ++i) {
    LeggedState x = Standing();
    for (double& q : x.q) q += angle(random);
    EXPECT_NEAR(clearance.At(x).legs.distance, LeastDrawn(x), 0.003) << i;
  }
}

// An upper leg turned inwards under the trunk, and up into it.
TEST_F(QuadrupedClearanceTest, FindsALegInTheTrunk) {
  LeggedState x = Standing();
  x.q.segment<3>(3 * kRearRight) << 1.3, 0, 0;  // abduction of a right leg, inwards
  EXPECT_GT(clearance.At(x).trunk.distance, -0.03);
  x.q.segment<3>(3 * kRearRight) << 2.2, 0, 0;
  const QuadrupedClearances clear = clearance.At(x);
  EXPECT_LE(clear.trunk.distance, -0.5 * LinkRadius(robot));
  EXPECT_EQ(clear.trunk.leg, kRearRight);
  EXPECT_GT(clearance.At(Standing()).trunk.distance, 0.005);
}

// The hip pitch of Solo12 is 14 mm from the axis of the abduction, where the box between the hips ends. The
// round end of the thigh, of radius 12.8 mm, would be in this box with a leg that is turned outwards.
TEST_F(QuadrupedClearanceTest, LeavesOutTheEndOfAThighInTheHousingOfTheHip) {
  const QuadrupedDescription solo = LoadQuadruped(TENON_ROBOTS_DIR "/solo12.yaml");
  const QuadrupedClearance clear(solo, {});
  LeggedState x = test::Standing(solo);
  x.q.head<2>() << M_PI / 2, 0;
  const QuadrupedClearances::Gap outwards = clear.At(x).trunk;
  EXPECT_NEAR(outwards.distance, 0.0128 * (0.16 / std::hypot(0.16, 0.03745) - 1), 1e-12);
  x.q[0] = -0.6;
  EXPECT_LT(clear.At(x).trunk.distance, -0.007);
}

// A robot that is lowered, on level ground, on a box and on a slope.
TEST_F(QuadrupedClearanceTest, LiftsAPointInsideTheTrunkOntoIt) {
  const Vector3d inside = robot.trunk.com, on = clearance.OnTrunk(inside);
  EXPECT_EQ(on.head<2>(), inside.head<2>());
  const auto distance = [&](const Vector3d& p_B) {
    return clearance.To(robot.stance, p_B, Vector3d(0, 0, 1e-3)).distance;
  };
  EXPECT_EQ(distance(inside), 0);
  EXPECT_GT(distance(on), 0);
  EXPECT_LT(distance(on), 0.002);
  EXPECT_EQ(clearance.OnTrunk(on), on);
}

TEST_F(QuadrupedClearanceTest, FindsKneesInTheGround) {
  LeggedState x = Standing();
  const double standing = clearance.At(x).ground.distance;
  x.p_WB[2] -= 0.1;
  EXPECT_NEAR(clearance.At(x).ground.distance, standing - 0.1, 1e-12);
  x.p_WB[2] = 0.15;
  EXPECT_LT(clearance.At(x).ground.distance, -0.05);
  EXPECT_GE(clearance.At(x).ground.leg, 0);

  TerrainParams box;
  box.boxes.push_back({.centre = {0.05, 0.2}, .size = {0.3, 0.3}, .height = 0.06, .friction = 1});
  const QuadrupedClearances on_box = QuadrupedClearance(robot, box).At(Standing());
  EXPECT_NEAR(on_box.ground.distance, standing - 0.06, 1e-12);
  EXPECT_EQ(on_box.ground.leg, kFrontLeft);

  const TerrainParams slope{.grade = {0.2, 0}};
  const double radius = LinkRadius(robot), x_knee = 0.2875 - 0.315 * std::sin(0.886);
  EXPECT_NEAR(QuadrupedClearance(robot, slope).At(Standing()).ground.distance,
              (standing + radius - 0.2 * x_knee) / std::sqrt(1.04) - radius, 1e-9);
}

TEST_F(QuadrupedClearanceTest, AllocatesNothing) {
  const LeggedState x = Standing();
  EXPECT_EQ(AllocationsOf([&] { clearance.At(x); }), 0);
}

}  // namespace tenon::quadruped_geometry_test
