#include <tenon/plants/surroundings/obstacle_detector.h>
#include <tenon/plants/surroundings/terrain.h>
#include <tenon/systems/yaml/yaml.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

namespace tenon::terrain_test {

constexpr double kRadius = 0.03;

TEST(TerrainTest, IsAPlane) {
  for (const Vec<2>& grade : {Vec<2>(0, 0), Vec<2>(0.3, -0.1)}) {
    const Terrain terrain({.grade = grade, .friction = 0.7});
    const Vec<3> normal = Vec<3>(-grade[0], -grade[1], 1).normalized(), on(2, 5, 2 * grade[0] + 5 * grade[1]);
    const Terrain::Surface surface = terrain.At(2, 5);
    EXPECT_NEAR(surface.height, on[2], 1e-14);
    EXPECT_THAT(surface.normal_W, IsNear(normal, 1e-15));
    EXPECT_EQ(surface.friction, 0.7);
    const Terrain::Contacts contacts = terrain.Touch(on + 0.02 * normal, kRadius);
    ASSERT_EQ(contacts.count, 1);
    EXPECT_NEAR(contacts.at[0].depth, 0.01, 1e-14);
    EXPECT_THAT(contacts.at[0].normal_W, IsNear(normal, 1e-15));
    EXPECT_EQ(terrain.Touch(on + 0.031 * normal, kRadius).count, 0);
  }
}

Terrain OneBox() {
  return Terrain({.boxes = {{{1, 2}, {0.4, 0.6}, 0.1, 0.25}}});
}

TEST(TerrainTest, ABoxHasATopSidesAndEdges) {
  const Terrain terrain = OneBox();
  EXPECT_EQ(terrain.At(1.19, 2.29).height, 0.1);
  EXPECT_EQ(terrain.At(1.19, 2.29).friction, 0.25);
  EXPECT_EQ(terrain.At(1.21, 2.29).height, 0);
  EXPECT_EQ(terrain.At(1.19, 2.31).height, 0);
  const auto touch = [&](const Vec<3>& p, const Vec<3>& normal, double depth) {
    const Terrain::Contacts contacts = terrain.Touch(p, kRadius);
    ASSERT_EQ(contacts.count, 1);
    EXPECT_THAT(contacts.at[0].normal_W, IsNear(normal, 1e-12));
    EXPECT_NEAR(contacts.at[0].depth, depth, 1e-14);
    EXPECT_EQ(contacts.at[0].friction, 0.25);
  };
  touch({1, 2, 0.12}, {0, 0, 1}, 0.01);
  touch({0.78, 2, 0.06}, {-1, 0, 0}, 0.01);
  touch({1, 2.32, 0.06}, {0, 1, 0}, 0.01);
  touch({1.212, 2, 0.116}, {0.6, 0, 0.8}, 0.01);  // an edge, from outside
  touch({1.21, 2.31, 0.11}, Vec<3>(1, 1, 1).normalized(), kRadius - 0.01 * std::sqrt(3));  // a corner
  touch({1, 2, 0.099}, {0, 0, 1}, kRadius + 0.001);  // centre inside: out at the top
  touch({1.199, 2, 0.05}, {1, 0, 0}, kRadius + 0.001);
  EXPECT_EQ(terrain.Touch({1.225, 2, 0.125}, kRadius).count, 0);  // beside the edge
  EXPECT_EQ(terrain.Touch({0.79, 2, 0.02}, kRadius).count, 2);    // side and ground
}

TEST(TerrainTest, DepthIsContinuousOverAnEdge) {
  const Terrain terrain = OneBox();
  double before = -1;
  for (double x = 1.15; x < 1.25; x += 1e-4) {
    double depth = 0;
    const Terrain::Contacts contacts = terrain.Touch({x, 2, 0.115}, kRadius);
    for (int i = 0; i < contacts.count; ++i) depth = std::max(depth, contacts.at[i].depth);
    if (before >= 0) {
      EXPECT_NEAR(depth, before, 1.1e-4);
    }
    before = depth;
  }
  EXPECT_EQ(before, 0);
}

TEST(TerrainTest, BoxesOnASlopeStandOnIt) {
  const Terrain terrain({.grade = {0.5, 0}, .boxes = {{{1, 0}, {0.4, 0.4}, 0.1, 0.4}}});
  const Vec<3> along = Vec<3>(1, 0, 0.5).normalized(), normal = Vec<3>(-0.5, 0, 1).normalized();
  const Vec<3> top = 1.1 * along + 0.1 * normal;
  EXPECT_NEAR(terrain.At(top[0], 0).height, top[2], 1e-14);
  EXPECT_THAT(terrain.At(top[0], 0).normal_W, IsNear(normal, 1e-15));
  const Terrain::Contacts contacts = terrain.Touch(top + 0.02 * normal, kRadius);
  ASSERT_EQ(contacts.count, 1);
  EXPECT_NEAR(contacts.at[0].depth, 0.01, 1e-14);
}

// A high box on a steep slope overhangs the ground beside its lower edge.
TEST(TerrainTest, HighBoxesOnASlopeAreFoundFromAnywhere) {
  const Terrain terrain(
      {.grade = {0.5, -0.3}, .boxes = {{{1, 0.5}, {0.2, 0.3}, 0.4, 0.4}, {{3, -2}, {0.2, 0.2}, 0.05, 0.4}}});
  const Eigen::Matrix3d R_WS =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), Vec<3>(-0.5, 0.3, 1)).toRotationMatrix();
  for (const double along : {-0.09, 0.0, 0.09}) {
    for (const double across : {-0.14, 0.0, 0.14}) {
      const Vec<3> top = R_WS * Vec<3>(1 + along, 0.5 + across, 0.4);
      EXPECT_NEAR(terrain.At(top[0], top[1]).height, top[2], 1e-12) << along << ", " << across;
    }
  }
}

TerrainParams Field(std::uint64_t seed) {
  return {.field = BoxField{.lower = {1, -2},
                            .upper = {6, 2},
                            .kinds = {{0.015, 0.4}, {0.04, 0.6}, {0.02, 0.8}},
                            .seed = seed}};
}

TEST(TerrainTest, FieldsOfBoxesComeFromTheirSeed) {
  const Terrain a(Field(1)), b(Field(1)), c(Field(2));
  ASSERT_EQ(a.boxes().size(), b.boxes().size());
  for (std::size_t i = 0; i < a.boxes().size(); ++i) EXPECT_EQ(a.boxes()[i].centre, b.boxes()[i].centre);
  EXPECT_NE(a.boxes()[0].centre, c.boxes()[0].centre);

  // About half of (12 or 13) x (9 or 10) places, each kind alike, all inside, none overlapping.
  EXPECT_GT(a.boxes().size(), 35u);
  EXPECT_LT(a.boxes().size(), 90u);
  for (const double height : {0.015, 0.04, 0.02}) {
    const auto count = std::count_if(a.boxes().begin(), a.boxes().end(),
                                     [&](const TerrainBox& box) { return box.height == height; });
    EXPECT_GT(count, static_cast<long>(a.boxes().size()) / 6);
  }
  for (const TerrainBox& box : a.boxes()) {
    EXPECT_GE((box.centre - box.size / 2 - Vec<2>(1, -2)).minCoeff(), 0);
    EXPECT_LE((box.centre + box.size / 2 - Vec<2>(6, 2)).maxCoeff(), 0);
    for (const TerrainBox& other : a.boxes()) {
      if (&box == &other) continue;
      EXPECT_GT((box.centre - other.centre).cwiseAbs().maxCoeff(), 0.4 - 1e-12);
    }
  }
}

// The shift along y is drawn first, with every compiler.
TEST(TerrainTest, ASeedGivesTheSameFieldInEveryBuild) {
  RandomStream random(1);
  const double y = random.Uniform(0, 1), x = random.Uniform(0, 1);
  const Vec<2> first = Vec<2>(1.15, -1.85) - 0.4 * Vec<2>(x, y);
  const Terrain terrain(Field(1));
  for (const TerrainBox& box : terrain.boxes()) {
    EXPECT_NEAR(std::remainder(box.centre[0] - first[0], 0.4), 0, 1e-12);
    EXPECT_NEAR(std::remainder(box.centre[1] - first[1], 0.4), 0, 1e-12);
  }
}

// With a pitch of 0.4 m no further row or column of boxes would fit into the area.
TEST(TerrainTest, FieldsReachTheEdgesOfTheirArea) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    TerrainParams params = Field(seed);
    params.field->coverage = 1;
    Vec<2> first = params.field->upper, last = params.field->lower;
    const Terrain terrain(params);
    for (const TerrainBox& box : terrain.boxes()) {
      first = first.cwiseMin(box.centre - box.size / 2);
      last = last.cwiseMax(box.centre + box.size / 2);
    }
    EXPECT_LT((first - params.field->lower).maxCoeff(), 0.4 + 1e-12) << seed;
    EXPECT_LT((params.field->upper - last).maxCoeff(), 0.4 + 1e-12) << seed;
  }
}

TEST(TerrainTest, TheGridAgreesWithASearchOfAllBoxes) {
  const Terrain terrain(Field(3));
  RandomStream random(4);
  int on = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vec<3> p(random.Uniform(0, 7), random.Uniform(-3, 3), random.Uniform(0, 0.08));
    double height = 0;
    int touching = p[2] < kRadius ? 1 : 0;
    for (const TerrainBox& box : terrain.boxes()) {
      const Vec<2> d = (p.head<2>() - box.centre).cwiseAbs() - box.size / 2;
      if (d.maxCoeff() <= 0) height = std::max(height, box.height);
      const Vec<3> out(std::max(0.0, d[0]), std::max(0.0, d[1]), std::max(0.0, p[2] - box.height));
      if (out.norm() < kRadius) ++touching;
    }
    EXPECT_EQ(terrain.At(p[0], p[1]).height, height);
    EXPECT_EQ(terrain.Touch(p, kRadius).count, std::min(touching, Terrain::kMaxContacts));
    on += height > 0;
  }
  EXPECT_GT(on, 200);
}

TEST(TerrainTest, StairsGoUpAndDown) {
  const Terrain terrain({.stairs = Stairs{.begin = {1, 0}, .rise = 0.12, .run = 0.3, .steps = 3}});
  const std::vector<double> heights{0, 0.12, 0.24, 0.36, 0.36, 0.36, 0.24, 0.12, 0};
  const std::vector<double> x{0.99, 1.01, 1.31, 1.61, 2.1, 2.59, 2.61, 2.91, 3.21};
  for (std::size_t i = 0; i < x.size(); ++i)
    EXPECT_NEAR(terrain.At(x[i], 1.9).height, heights[i], 1e-12) << x[i];
  EXPECT_EQ(terrain.At(2, 2.1).height, 0) << "beside";
}

TEST(TerrainTest, ReadsAndWritesYaml) {
  const auto again = YamlDocument::Parse(WriteYaml(Field(7)), "again").Read<TerrainParams>();
  EXPECT_EQ(Terrain(again).boxes().size(), Terrain(Field(7)).boxes().size());
}

TEST(TerrainTest, RefusesNonsense) {
  const auto refuses = [](const auto& change, const auto&... parts) {
    TerrainParams params = Field(1);
    params.boxes = {{{1, 0}, {0.4, 0.4}, 0.1, 0.4}};
    change(params);
    return Throws<ParameterError>([&] { Terrain terrain(params); }, parts...);
  };
  EXPECT_TRUE(refuses([](auto& p) { p.grade[0] = NAN; }, "grade"));
  EXPECT_TRUE(refuses([](auto& p) { p.grade[0] = 1e155; }, "grade"));
  EXPECT_TRUE(refuses([](auto& p) { p.friction = -0.1; }, "friction"));
  EXPECT_TRUE(refuses([](auto& p) { p.boxes[0].height = 0; }, "height_m"));
  EXPECT_TRUE(refuses([](auto& p) { p.boxes[0].height = 1e12; }, "height_m"));
  EXPECT_TRUE(refuses([](auto& p) { p.boxes[0].size[1] = 0; }, "size_m"));
  EXPECT_TRUE(refuses([](auto& p) { p.boxes[0].friction = NAN; }, "friction"));
  EXPECT_TRUE(refuses([](auto& p) { p.boxes[0].friction = 10.1; }, "friction"));
  EXPECT_TRUE(refuses([](auto& p) { p.field->upper[0] = 0; }, "upper_m"));
  EXPECT_TRUE(refuses([](auto& p) { p.field->upper[0] = 9e4; }, "places for boxes"));
  EXPECT_TRUE(refuses([](auto& p) { p.field->upper = {9e4, -2 + 1e-9}; }, "places for boxes"));
  EXPECT_TRUE(refuses([](auto& p) { p.field->upper[0] = 1e17; }, "upper_m"));
  EXPECT_TRUE(refuses([](auto& p) { p.field->size[0] = 1e-4; }, "size_m"));
  EXPECT_TRUE(refuses([](auto& p) { p.boxes[0].centre[0] = 1e13; }, "centre_m"));
  EXPECT_TRUE(refuses([](auto& p) { p.field->gap = -1; }, "gap_m"));
  EXPECT_TRUE(refuses([](auto& p) { p.field->coverage = 2; }, "coverage"));
  EXPECT_TRUE(refuses([](auto& p) { p.field->kinds.clear(); }, "kinds"));
}

const ObstacleDetectorParams kParams{
    .obstacles = {{{3, 0}, 0.2}, {{-5, 4}, 0.5}}, .range = 1, .half_width = 0.4};

bool Sees(double x, double y, double yaw) {
  TestRig<ObstacleDetector> rig(kParams);
  rig.Fix(rig->state, {.p_WB = {x, y, 0.4}, .q_WB = QuaternionFromRotationVector({0, 0, yaw})});
  return rig[rig->obstacle];
}

TEST(ObstacleDetectorTest, SeesObstaclesAheadInRange) {
  EXPECT_FALSE(Sees(1.79, 0, 0));
  EXPECT_TRUE(Sees(1.81, 0, 0)) << "the surface of the pillar is at 2.8 m";
  EXPECT_TRUE(Sees(2.9, 0, 0));
  EXPECT_FALSE(Sees(3.1, 0, 0)) << "behind";
  EXPECT_FALSE(Sees(2, 0, 3));
}

TEST(ObstacleDetectorTest, LooksAsWideAsTheRobotsWay) {
  EXPECT_TRUE(Sees(2, 0.59, 0));
  EXPECT_FALSE(Sees(2, 0.61, 0));
  EXPECT_TRUE(Sees(2, -0.59, 0));
  EXPECT_FALSE(Sees(2, -0.61, 0));
}

// All lengths are exact in binary.
TEST(ObstacleDetectorTest, TheBoundsOfItsViewAreExcluded) {
  TestRig<ObstacleDetector> rig(
      ObstacleDetectorParams{.obstacles = {{{3, 0}, 0.25}}, .range = 1, .half_width = 0.5});
  const auto sees = [&](double x, double y) {
    rig.Fix(rig->state, {.p_WB = {x, y, 0.5}});
    return rig[rig->obstacle];
  };
  EXPECT_FALSE(sees(2.5, 0.75));
  EXPECT_FALSE(sees(2.5, -0.75));
  EXPECT_FALSE(sees(1.75, 0));
  EXPECT_FALSE(sees(3, 0)) << "beside, if it could be there";
  EXPECT_TRUE(sees(1.75 + 1e-9, 0.75 - 1e-9));
}

TEST(ObstacleDetectorTest, TurnsWithTheRobotAndSeesAllObstacles) {
  EXPECT_TRUE(Sees(-5, 2.6, 1.57));
  EXPECT_FALSE(Sees(-5, 2.4, 1.57));
  EXPECT_FALSE(Sees(-5, 2.6, 0));
}

TEST(ObstacleDetectorTest, KeepsAnObstacleInSightThatTheRobotSwaysAwayFrom) {
  TestRig<ObstacleDetector> rig(kParams);
  const auto in_sight = [&](double x) {
    rig.Fix(rig->state, {.p_WB = {x, 0, 0.4}});
    return rig.Tick()[rig->in_sight];
  };
  EXPECT_FALSE(in_sight(1.79));
  EXPECT_TRUE(in_sight(1.81));
  EXPECT_TRUE(in_sight(1.76)) << "0.04 m beyond the range";
  EXPECT_FALSE(in_sight(1.74)) << "0.06 m";
  EXPECT_FALSE(in_sight(1.76)) << "it would be a new one";
}

TEST(ObstacleDetectorTest, DrawsThePillars) {
  TestRig<ObstacleDetector> rig(kParams);
  rig.Fix(rig->state, LeggedState());
  const Geometry& shapes = rig[rig->geometry];
  ASSERT_EQ(shapes.size(), 2U);
  EXPECT_THAT(Vec<2>(shapes[1].p_W.head<2>()), IsNear(Vec<2>(-5, 4), 1e-15));
  EXPECT_EQ(shapes[1].size[0], 0.5);
  EXPECT_EQ(shapes[1].p_W[2], shapes[1].size[1] / 2) << "stands on the ground";
}

TEST(ObstacleDetectorTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<ObstacleDetector>({.obstacles = {{{1, 2}, 1}, {{1, 2}, 0}}}, "obstacles.1"));
  EXPECT_TRUE(Refuses<ObstacleDetector>({.obstacles = {{{NAN, 2}, 1}}}, "obstacles.0"));
}

TEST(ObstacleDetectorTest, LooksFartherInARun) {
  TestRig<ObstacleDetector> rig(kParams);
  rig.Fix(rig->state, {.p_WB = {1, 0.7, 0.4}});
  EXPECT_FALSE(rig[rig->obstacle]);
  rig.Set(rig->range, 2);
  EXPECT_FALSE(rig[rig->obstacle]);
  rig.Set(rig->half_width, 0.6);
  EXPECT_TRUE(rig[rig->obstacle]);
}

}  // namespace tenon::terrain_test
