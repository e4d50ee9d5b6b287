// The search for gains of the PD controller.

#include <tenon/tests/apps/run_app.h>

#include <fstream>

namespace tenon::tenon_tune_pd_test {
namespace {

using test::Result;
using test::RunCommand;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

const std::string kApp = TENON_TUNE_PD;

TEST(TenonTunePdTest, SaysWhatEachTrialOfGainsCameTo) {
  const Result result = RunCommand(kApp + " --evaluations 1");
  EXPECT_EQ(result.exit_code, 0) << result.text;
  EXPECT_THAT(result.text, AllOf(HasSubstr("K_p N/m"), HasSubstr("     400.0       60.0"),
                                 HasSubstr("best: stiffness_N_per_m: 400, damping_N_s_per_m: 60")));
}

// The local search starts from the best point of a grid and may end at a worse one.
TEST(TenonTunePdTest, PrintsTheGainsOfTheLeastCost) {
  const Result result = RunCommand(kApp + " --robot cdpr_12 --evaluations 10");
  EXPECT_EQ(result.exit_code, 0) << result.text;
  double stiffness = 0, damping = 0, cost = 0;
  const std::string best = "best: ";
  ASSERT_EQ(std::sscanf(result.text.c_str() + result.text.find(best),
                        "best: stiffness_N_per_m: %lf, damping_N_s_per_m: %lf (cost %lf)", &stiffness,
                        &damping, &cost),
            3)
      << result.text;
  bool found = false;
  double each[6];  // a trial: gains, error, settling time, tension rate, cost
  std::istringstream lines(result.text);
  for (std::string line; std::getline(lines, line);) {
    if (std::sscanf(line.c_str(), "%lf %lf %lf %lf %lf %lf", each, each + 1, each + 2, each + 3, each + 4,
                    each + 5) != 6)
      continue;
    EXPECT_GE(each[5], cost);
    if (each[5] != cost) continue;
    found = true;
    EXPECT_NEAR(each[0], stiffness, 0.5);
    EXPECT_NEAR(each[1], damping, 0.5);
  }
  EXPECT_TRUE(found) << result.text;
}

// All lengths and the mass are a tenth of the shipped robot's. Unscaled motions would pass through the
// anchors.
TEST(TenonTunePdTest, MotionsScaleWithTheRobot) {
  const std::filesystem::path robot = test::TemporaryPath("small.yaml");
  std::ofstream(robot)
      << "name: small\nmass_kg: 1.5\ninertia_kg_m2: [2e-4, 2e-4, 2e-4]\ncables:\n"
         "  - {anchor_m: [ 0.35,  0.45, 0.4], attachment_m: [ 0.0075,  0.0075, 0.0093]}\n"
         "  - {anchor_m: [-0.35,  0.45, 0.4], attachment_m: [-0.0075,  0.0075, 0.0093]}\n"
         "  - {anchor_m: [-0.35, -0.45, 0.4], attachment_m: [-0.0075, -0.0075, 0.0093]}\n"
         "  - {anchor_m: [ 0.35, -0.45, 0.4], attachment_m: [ 0.0075, -0.0075, 0.0093]}\n"
         "cable_properties: {axial_stiffness_N: 2700, axial_damping_N_s: 13.5, tension_min_N: 0, "
         "tension_max_N: 80}\n"
         "winch: {mode: tension, time_constant_s: 0.02, reel_damping_N_s_per_m: 90}\n";
  const Result result = RunCommand(kApp + " --evaluations 1 --robot " + robot.string());
  EXPECT_THAT(result.text, AllOf(HasSubstr("     400.0       60.0"), Not(HasSubstr("failure"))));
  std::filesystem::remove(robot);
}

TEST(TenonTunePdTest, SaysWhyItCannotSearch) {
  const auto refused = [](const std::string& arguments, const char* why) {
    const Result result = RunCommand(kApp + " " + arguments);
    EXPECT_EQ(result.exit_code, 2) << result.text;
    EXPECT_THAT(result.text, HasSubstr(why));
  };
  refused("--evaluations 0", "--evaluations: 0");
  refused("--robot dogbot", "'dogbot'");
  // The message for a load that the cables cannot carry comes from the statics, not from NLopt.
  const std::filesystem::path weak = test::TemporaryPath("weak.yaml");
  std::string text = test::Read(std::string(TENON_ROBOTS_DIR) + "/cdpr_4.yaml");
  text.replace(text.find("tension_max_N: 800"), 18, "tension_max_N: 8  ");
  std::ofstream(weak) << text;
  const Result result = RunCommand(kApp + " --evaluations 1 --robot " + weak.string());
  EXPECT_THAT(result.text, AllOf(HasSubstr("outside its bounds [0, 8] N"), Not(HasSubstr("nlopt"))));
  EXPECT_NE(result.exit_code, 0);
  std::filesystem::remove(weak);
}

}  // namespace
}  // namespace tenon::tenon_tune_pd_test
