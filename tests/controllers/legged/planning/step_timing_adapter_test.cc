#include <tenon/controllers/legged/planning/step_timing_adapter.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>

namespace tenon::step_timing_adapter_test {

constexpr StepTiming kTiming{.lookahead = 0.1, .free_tilt = 0.3, .clock_rate = 2};

/// Two ticks with this attitude and angular velocity against this reference; the second one has the output.
double ClockRate(const Vec<4>& q_WB, const Vec<3>& w_W, const BodyReference& body = {},
                 const StepTiming& timing = kTiming) {
  TestRig<StepTimingAdapter> rig({.timing = timing});
  LeggedState state;
  state.q_WB = q_WB;
  state.w_W = w_W;
  rig.Fix(rig->state, state).Fix(rig->body, body);
  EXPECT_EQ(rig.Tick()[rig->clock_rate], 1) << "before the first update";
  return rig.Tick()[rig->clock_rate];
}
Vec<4> Tilted(double angle, double yaw = 0) {
  return QuaternionProduct(QuaternionFromEuler({0, 0, yaw}), QuaternionFromRotationVector({angle, 0, 0}));
}

TEST(StepTimingAdapterTest, SwingsAreFasterWhileThePredictedTiltIsLarge) {
  EXPECT_EQ(ClockRate(Tilted(0), {0, 0, 0}), 1);
  EXPECT_EQ(ClockRate(Tilted(std::asin(0.299)), {0, 0, 0}), 1);
  EXPECT_EQ(ClockRate(Tilted(std::asin(0.301)), {0, 0, 0}), 2);
  EXPECT_EQ(ClockRate(Tilted(0), {0, -2.99, 0}), 1);
  EXPECT_EQ(ClockRate(Tilted(0), {0, -3.01, 0}), 2);
  EXPECT_EQ(ClockRate(Tilted(0.2), {1.1, 0, 0}), 2);  // falls further
  EXPECT_EQ(ClockRate(Tilted(0.2), {-4, 0, 0}), 1);   // rises, and is level in 50 ms
  EXPECT_EQ(ClockRate(Tilted(0, 2), {0, 0, 50}), 1);  // a turn is no fall
}

// The trunk is parallel to a slope, turned, and follows the rates of its reference.
TEST(StepTimingAdapterTest, TiltAndRateCountFromTheReference) {
  const BodyReference body{.q_WB = QuaternionProduct(Tilted(0.5), QuaternionFromEuler({0, 0, 1})),
                           .w_W = {0, 4, 0}};
  EXPECT_EQ(ClockRate(Tilted(0.5), body.w_W, body), 1);
  EXPECT_EQ(ClockRate(Tilted(0.5), {0, 0, 0}, body), 2);
  EXPECT_EQ(ClockRate(Tilted(0), body.w_W, body), 2);
}

}  // namespace tenon::step_timing_adapter_test
