// Walks that use the state estimator, compared with the true state of the plant.

#include <tenon/diagrams/legged/quadruped_walk.h>
#include <tenon/diagrams/recommended_options.h>
#include <tenon/systems/simulation/simulator.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>

#include <gtest/gtest.h>

namespace tenon::quadruped_walk_estimated_test {

/// DogBot trots from a stand, with noise on all sensors that its controller uses.
QuadrupedWalkParams Trot() {
  QuadrupedWalkParams params = MakeQuadrupedWalk(test::DogBot());
  params.world.encoders.angle.absolute = 1e-4;
  params.world.encoders.speed.absolute = 0.02;
  params.world.foot_sensor.error.relative = 0.1;
  params.walk.segments = {{.duration = 0.3}, {.gait = Gait::kTrot, .forward = 0.12, .duration = 10}};
  params.estimator.emplace();
  params.estimator->robot = params.world.plant.robot;
  params.estimator->initial = params.world.plant.initial;
  return params;
}

struct Errors {
  bool ended = false;
  double velocity_rms = 0, velocity_max = 0, tilt_max = 0;
  double weighted = 0;  ///< mean square of the velocity error over its estimated deviation
  Vec<3> drift = Vec<3>::Zero();
  int min_feet = kNumLegs;
  LeggedEstimatorDiagnostics diagnostics;
};

Errors Walk(const QuadrupedWalkParams& params, double duration) {
  DiagramBuilder builder;
  auto& loop = builder.Add<QuadrupedWalk>("loop", params);
  Simulator simulator(builder.Build(), RecommendedOptions(loop));
  Errors errors;
  const int ticks = static_cast<int>(std::lround(1000 * duration));
  for (int k = 1; k <= ticks && !errors.ended; ++k) {
    errors.ended = simulator.AdvanceTo(1e-3 * k).ended;
    const LeggedState& truth = simulator.context().Eval(loop.world.state);
    const LeggedState& estimate = simulator.context().Eval(loop.estimator->state);
    errors.diagnostics = simulator.context().Eval(loop.estimator->diagnostics);
    const Vec<3> off = estimate.v_W - truth.v_W;
    errors.velocity_rms += off.squaredNorm() / ticks;
    errors.velocity_max = std::max(errors.velocity_max, off.norm());
    errors.weighted += off.cwiseQuotient(errors.diagnostics.velocity_deviation).squaredNorm() / 3 / ticks;
    errors.tilt_max = std::max(errors.tilt_max, (estimate.R_WB().row(2) - truth.R_WB().row(2)).norm());
    errors.drift = estimate.p_WB - truth.p_WB;
    errors.min_feet = std::min(errors.min_feet, errors.diagnostics.feet);
  }
  errors.velocity_rms = std::sqrt(errors.velocity_rms);
  return errors;
}

TEST(QuadrupedWalkEstimatedTest, TrotsByImuEncodersAndContacts) {
  const Errors errors = Walk(Trot(), 3);
  EXPECT_FALSE(errors.ended);
  EXPECT_LT(errors.velocity_rms, 0.003);
  EXPECT_LT(errors.velocity_max, 0.01);
  EXPECT_LT(errors.tilt_max, 2e-3);
  EXPECT_LT(errors.drift.norm(), 0.005);
  EXPECT_GT(errors.velocity_rms, 1e-4);  // the estimate is not the true state
  EXPECT_LT(errors.weighted, 1);         // the estimated deviation is not too small
  EXPECT_EQ(errors.min_feet, 2);
  EXPECT_EQ(errors.diagnostics.moved_feet, 0);
}

// Feet of 28 mm radius roll forward by some millimetres in each stance. A filter of point feet drifts.
TEST(QuadrupedWalkEstimatedTest, PointFeetWouldDrift) {
  const QuadrupedWalkParams params = Trot();
  QuadrupedWalkParams points = params;
  points.estimator->robot.foot_radius = 0;
  EXPECT_GT(std::abs(Walk(points, 3).drift[0]), 4 * std::abs(Walk(params, 3).drift[0]));
}

TEST(QuadrupedWalkEstimatedTest, WalksWithBiasedSensors) {
  QuadrupedWalkParams params = Trot();
  params.world.imu.specific_force_bias = {0.03, -0.02, 0.04};
  params.world.imu.angular_velocity_bias = {0.003, -0.002, 0.002};
  const Errors errors = Walk(params, 3);
  EXPECT_FALSE(errors.ended);
  EXPECT_LT(errors.velocity_rms, 0.006);
  EXPECT_LT((errors.diagnostics.angular_velocity_bias_B - params.world.imu.angular_velocity_bias).norm(),
            1e-3);
  EXPECT_NEAR(errors.diagnostics.specific_force_bias_B[2], 0.04, 0.005);
}

}  // namespace tenon::quadruped_walk_estimated_test
