#include <tenon/controllers/cdpr/reference_generator.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::reference_generator_test {
namespace {

TEST(ReferenceGeneratorTest, PlaysThePathAtItsRateAndHoldsItBetween) {
  const auto path = std::make_shared<EquilibriumPath>(LoadCdpr(FindResource("robots", "cdpr_4")),
                                                      Path::Line({0, 0, 2}, {0.4, 0, 2}, 2));
  TestRig<ReferenceGenerator> rig(ReferenceGeneratorParams{path, Hz(100)});
  rig.RunTo(1.005);
  EXPECT_THAT(rig[rig->reference].position, IsNear(Eigen::Vector3d(0.2, 0, 2), 1e-12));
  EXPECT_THAT(rig[rig->reference].tension, IsNear(path->At(1).tension, 1e-12));
  rig.Tick();
  EXPECT_THAT(rig[rig->reference].position, IsNear(path->At(1.01).position, 1e-12));
}

TEST(ReferenceGeneratorTest, ShowsWhereTheRobotShouldBe) {
  const auto path = std::make_shared<EquilibriumPath>(LoadCdpr(FindResource("robots", "cdpr_4")),
                                                      Path::Line({0, 0, 2}, {0.4, 0, 2}, 2));
  TestRig<ReferenceGenerator> rig(ReferenceGeneratorParams{path, Hz(100)});
  rig.RunTo(1);
  const Geometry& geometry = rig[rig->geometry];
  ASSERT_EQ(geometry.size(), 1);
  EXPECT_EQ(geometry[0].kind, ShapeKind::kTrace);
  EXPECT_EQ(geometry[0].role, ShapeRole::kReference);
  EXPECT_THAT(geometry[0].p_W, IsNear(Vec<3>(0.2, 0, 2), 1e-12));
}

TEST(ReferenceGeneratorTest, NeedsAPath) {
  EXPECT_TRUE(Throws<ParameterError>([] { TestRig<ReferenceGenerator> rig; }, "path"));
}

}  // namespace
}  // namespace tenon::reference_generator_test
