// The errors of the sensors do not depend on the controller, so --compare compares only controllers.

#include <tenon/apps/cdpr/cdpr_scenario.h>

#include <gtest/gtest.h>

namespace tenon::apps::same_noise_test {

struct Errors {
  std::vector<Eigen::Vector3d> position, angular_velocity;
};

/// Errors of the sensors in the first 0.2 s of D1.
Errors ErrorsUnder(CdprController controller) {
  auto scenario = LoadScenario("D1", {}, "tenon-cdpr").Read<CdprScenario>();
  scenario.controller = controller;
  DiagramBuilder builder;
  auto& loop = builder.Add<CdprLoop>("loop", MakeLoopParams(scenario));
  Simulator simulator(builder.Build(), MakeSimulatorOptions(scenario));
  Errors errors;
  for (int tick = 0; tick < 40; ++tick) {
    simulator.RunTo(tick / 200.0);
    const auto& context = simulator.context();
    const PlatformState& state = context.Eval(loop.world.plant.platform);
    errors.position.emplace_back(context.Eval(loop.world.pose_sensor.pose).p_WB - state.p_WB);
    errors.angular_velocity.emplace_back(context.Eval(loop.world.imu.measurement).angular_velocity_B -
                                         state.R_WB().transpose() * state.w_W);
  }
  return errors;
}

TEST(SameNoiseTest, ForEveryController) {
  const Errors reference = ErrorsUnder(CdprController::kMpcEquilibrium);
  EXPECT_GT(reference.position.front().norm(), 1e-4);
  EXPECT_NE(reference.position[0], reference.position[1]);
  for (const auto& [controller, name] : EnumNames(CdprController{})) {
    const Errors errors = ErrorsUnder(controller);
    for (std::size_t i = 0; i < errors.position.size(); ++i) {
      EXPECT_LT((errors.position[i] - reference.position[i]).norm(), 1e-12) << name << " at tick " << i;
      EXPECT_LT((errors.angular_velocity[i] - reference.angular_velocity[i]).norm(), 1e-12) << name;
    }
  }
}

}  // namespace tenon::apps::same_noise_test
