// The goals of the cases of the guide dog, with DogBot and the observers in the loop.

#include <tenon/tests/apps/run_case.h>

namespace tenon::guide_dog_cases_test {

using test::Case;

class GuideDogCasesTest : public test::CaseTest {
 protected:
  /// Runs a scenario, which must finish.
  Case RunCase(const std::string& arguments) const {
    const Case run = Run(TENON_GUIDE_DOG, arguments);
    EXPECT_TRUE(run.finished()) << arguments << ": " << run.summary.at("end_reason");
    return run;
  }
};

void ExpectSteady(const Case& run) {
  EXPECT_NEAR(run["tension_mean_N"], 30, 3);
  EXPECT_GT(run["distance_min_m"], 0.95 * run["distance_mean_m"]);
  EXPECT_LT(run["distance_max_m"], 1.05 * run["distance_mean_m"]);
  EXPECT_LT(run["force_estimate_error_rms_N"], 2);
  EXPECT_EQ(run["qp_failures"], 0);
}

TEST_F(GuideDogCasesTest, C1OnALeashAndByAHandle) {
  for (const char* scenario : {"C1", "C1-handle"}) {
    const Case run = RunCase(scenario);
    ExpectSteady(run);
    EXPECT_GT(run["tension_max_N"], 50) << "the person has stopped the robot";
    EXPECT_LT(run["tension_max_N"], 60);
    EXPECT_LT(run["stop_delay_s"], 1);
  }
}

TEST_F(GuideDogCasesTest, C1SineAndC2) {
  for (const char* scenario : {"C1-sine", "C2"}) {
    const Case run = RunCase(scenario);
    ExpectSteady(run);
    EXPECT_LT(run["tension_max_N"], 45) << scenario;
  }
}

TEST_F(GuideDogCasesTest, C3) {
  const Case run = RunCase("C3");
  ExpectSteady(run);
  EXPECT_LT(run["heading_error_deg"], 5);
  EXPECT_LT(run["stop_delay_s"], 1);
}

TEST_F(GuideDogCasesTest, C3FromOtherSidesAndOverBlocks) {
  for (const char* scenario : {"C3-right", "C3-diagonal", "C3-blocks"}) {
    const Case run = RunCase(scenario);
    EXPECT_LT(run["heading_error_deg"], 5) << scenario;
  }
}

TEST_F(GuideDogCasesTest, AtAPersonsPace) {
  const Case stops = RunCase("C1-pace");
  EXPECT_NEAR(stops["tension_walking_mean_N"], 30, 3);
  EXPECT_LT(stops["slack_ratio"], 0.05) << "until the robot first leads";
  EXPECT_LT(stops["stop_delay_s"], 4) << "it stops, and steps back towards the person";
  const std::vector<double> time = test::Column(out, "time [s]");
  const std::vector<double> mode = test::Column(out, "loop.supervisor.status.mode");
  for (std::size_t row = 0; row < time.size(); ++row)
    EXPECT_EQ(mode[row], time[row] < 24 ? 0 : time[row] < 25 ? mode[row] : 2) << "at " << time[row] << " s";
  EXPECT_NEAR(RunCase("C2-pace")["tension_walking_mean_N"], 30, 3);
  EXPECT_LT(RunCase("C3-pace")["heading_error_deg"], 5);
}

// A foot that hits the side of a block is held there by friction, and with seed 2 the robot falls unless the
// step reflex frees the foot. With seed 5 the result depends on rounding.
TEST_F(GuideDogCasesTest, TheStepReflexIsNeededForC3Blocks) {
  for (const char* scenario : {"C3-blocks --seed 2", "C3-blocks --seed 5"})
    EXPECT_TRUE(Run(TENON_GUIDE_DOG, scenario).finished()) << scenario;
  EXPECT_FALSE(Run(TENON_GUIDE_DOG, "C3-blocks --seed 2 --set walk.step.reflex.enabled=false").finished());
}

// 150 N more from 10 s to 10.3 s displace the robot by some centimetres; it recovers within a second.
TEST_F(GuideDogCasesTest, APersonWhoStumblesDoesNotPullTheRobotOver) {
  const double largest = RunCase("C1-stumble")["com_error_max_m"];
  EXPECT_GT(largest, 0.01) << "it was felt";
  EXPECT_LT(largest, 0.1);
  const std::vector<double> time = test::Column(out, "time [s]");
  const std::vector<double> error = test::Column(out, "loop.errors.errors.com.x [m]");
  for (std::size_t row = 0; row < time.size(); ++row) {
    if (time[row] < 11.3) continue;
    EXPECT_LT(std::abs(error[row]), 3e-3) << "at " << time[row] << " s";
  }
}

// Torque, foot force and accelerometer are noisy; after the person stops the robot the leash is slack for 60
// s.
TEST_F(GuideDogCasesTest, DoesNotStartByItselfInNoise) {
  const Case run = RunCase(
      "C1 --duration 82 --set 'person.phases=[{activity: follow, duration_s: 15, speed_m_per_s: 0.07}]' "
      "--set 'sensors={torque: {noise_ratio: 0.1}, foot_force: {noise_ratio: 0.1}, "
      "imu: {acceleration_noise_m_per_s2: 0.05}}'");
  EXPECT_LT(run["stop_delay_s"], 1);
  EXPECT_EQ(run["qp_failures"], 0);
  const std::vector<double> time = test::Column(out, "time [s]");
  const std::vector<double> mode = test::Column(out, "loop.supervisor.status.mode");
  int standing = 0;
  for (std::size_t row = 0; row < time.size(); ++row) {
    if (time[row] < 22) continue;
    EXPECT_EQ(mode[row], 2) << "not in stop at " << time[row] << " s";
    ++standing;
  }
  EXPECT_GT(standing, 1000);
}

}  // namespace tenon::guide_dog_cases_test
