#include <tenon/apps/quadruped/quadruped_scenario.h>

#include <fmt/core.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace tenon::apps::quadruped_scale_test {

using ::testing::ElementsAre, ::testing::HasSubstr, ::testing::IsEmpty;

QuadrupedScenario Load(const char* name, std::vector<std::string> settings) {
  return LoadScenario(name, settings, "tenon-quadruped").Read<QuadrupedScenario>();
}

// Ratios of A1 (12.78 kg, legs of 0.4 m, from its URDF) to DogBot (21.256 kg, 0.617 m).
constexpr double kWeight = (6 + 4 * (0.595 + 0.888 + 0.151 + 0.06)) / 21.256,
                 kLength = 0.4 / 0.6170347662107791;

TEST(QuadrupedScaleTest, ForcesGoWithTheWeightAndBlocksWithTheLegs) {
  const QuadrupedWalkParams dogbot = MakeWalkParams(Load("B1", {})),
                            a1 = MakeWalkParams(Load("B1", {"robot=a1", "scale_forces=true"}));
  EXPECT_NEAR(a1.world.plant.payload.mass, kWeight * dogbot.world.plant.payload.mass, 1e-9);
  EXPECT_NEAR(a1.world.plant.terrain.field->kinds[1].height, kLength * 0.035, 1e-12);
  EXPECT_NEAR(a1.locomotion.swing_planner.step.height, kLength * dogbot.locomotion.swing_planner.step.height,
              1e-12);
  EXPECT_NEAR(a1.locomotion.swing_planner.step.reflex.height, kLength * 0.1, 1e-12);
  const QuadrupedWalkParams pushed = MakeWalkParams(Load("A3", {"robot=a1", "scale_forces=true"}));
  EXPECT_NEAR(pushed.world.pulses[0].push.force_W[0], kWeight * 80, 1e-9);
}

TEST(QuadrupedScaleTest, TheLoadIsAtMostWhatTwoLegsHold) {
  const QuadrupedDescription robot = MakeWalkParams(Load("B1", {})).world.plant.robot;
  const double knee = HeldByTwoLegs(robot).torque;
  const auto loaded = [&](double held, const char* scale) {
    const std::string torque = fmt::format("robot.joint_limits.knee.torque_N_m={}", held * knee);
    return Load("B1", {torque, scale});
  };
  const auto load = [](const QuadrupedScenario& scenario) {
    return MakeWalkParams(scenario).world.plant.payload.mass;
  };
  EXPECT_NEAR(load(loaded(1.3, "scale_forces=true")), 0.3 * robot.mass(), 1e-6);
  EXPECT_EQ(load(loaded(1.3, "scale_forces=false")), 23);
  EXPECT_NEAR(load(loaded(3, "scale_forces=true")), 23, 1e-9);
  EXPECT_EQ(load(loaded(0.9, "scale_forces=true")), 0);

  EXPECT_THAT(Notes(loaded(3, "scale_forces=true")), IsEmpty());
  EXPECT_THAT(
      Notes(loaded(1.3, "scale_forces=true")),
      ElementsAre(HasSubstr("payload: 23 kg, 108 % of the robot's weight, are more than the 6.38 kg")));
  EXPECT_THAT(Notes(loaded(0.9, "scale_forces=false")),
              ElementsAre(HasSubstr("in a trot, two legs hold the robot"), HasSubstr("the robot may fall")));
}

// B's origin may lie anywhere on the trunk.
TEST(QuadrupedScaleTest, PointsOnTheTrunkKeepTheirPlacesRelativeToTheHips) {
  const QuadrupedScenario scenario = Load("B1", {"scale_forces=true"});
  SizeRatio ratio = RatioOf(scenario);
  EXPECT_LT(ratio.offset.norm(), 1e-12);
  ratio.length = 2;
  ratio.offset = {0.1, 0, 0.3};
  EXPECT_LT((ScaledToRobot(scenario, ratio).payload.position_m - Vec<3>(0.1, 0, 0.5)).norm(), 1e-12);
}

TEST(QuadrupedScaleTest, DogBotIsNotScaled) {
  const QuadrupedScenario scenario = Load("B2", {"scale_forces=true"});
  EXPECT_EQ(ScaledToRobot(scenario, RatioOf(scenario)).random_forces[1].upper_N, 40);
  EXPECT_EQ(RatioOf(Load("B2", {"robot=a1"})).weight, 1);  // scale_forces is false
}

// The stiffness over weight times leg length is equal for all robots.
TEST(QuadrupedScaleTest, JointsAreAsStiffAsTheRobotIsHeavy) {
  const auto stiffness = [](const QuadrupedScenario& scenario) {
    const QuadrupedStandParams params = MakeStandParams(scenario);
    const RobotScale scale = ScaleOf(params.pd.robot);
    return Eigen::Vector2d(params.pd.stiffness / (scale.Weight() * scale.length),
                           params.pd.damping / params.pd.stiffness / scale.Time());
  };
  EXPECT_TRUE(stiffness(Load("stand", {"robot=a1"})).isApprox(stiffness(Load("stand", {})), 1e-9));
  EXPECT_NEAR(MakeStandParams(Load("stand", {})).pd.stiffness, 500, 1e-4);
  EXPECT_NEAR(MakeStandParams(Load("stand", {})).pd.damping, 10, 1e-6);
  EXPECT_EQ(MakeStandParams(Load("stand", {"pd.stiffness_N_m_per_rad=70"})).pd.stiffness, 70);
}

}  // namespace tenon::apps::quadruped_scale_test
