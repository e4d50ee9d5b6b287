#include <tenon/plants/legged/quadruped_clearance.h>
#include <tenon/plants/legged/quadruped_geometry.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <random>

namespace tenon::quadruped_clearance_test {

using Eigen::Vector3d;

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

  TerrainParams slope;
  slope.grade = {0.2, 0};
  const double radius = LinkRadius(robot), x_knee = 0.2875 - 0.315 * std::sin(0.886);
  EXPECT_NEAR(QuadrupedClearance(robot, slope).At(Standing()).ground.distance,
              (standing + radius - 0.2 * x_knee) / std::sqrt(1.04) - radius, 1e-9);
}

TEST_F(QuadrupedClearanceTest, AllocatesNothing) {
  const LeggedState x = Standing();
  EXPECT_EQ(AllocationsOf([&] { clearance.At(x); }), 0);
}

}  // namespace tenon::quadruped_clearance_test
