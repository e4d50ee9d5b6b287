// The goals of the cases of the cable robot, with seeds 1 and 2. A test whose name begins with Missed expects
// that a goal is missed; it fails once the goal is reached.

#include <tenon/tests/apps/run_case.h>

#include <map>

namespace tenon::cdpr_cases_test {

class CdprCasesTest : public test::CaseTest {
 protected:
  /// Runs all controllers, whose flights must finish.
  std::map<std::string, test::Case> Compare(const std::string& scenario, int seed) const {
    const test::Result result =
        test::RunCommand(std::string(TENON_CDPR) + " " + scenario +
                         " --compare --set log_rate_hz=10 --seed " + std::to_string(seed) + Out());
    EXPECT_EQ(result.exit_code, 0) << result.text;
    const auto summaries = nlohmann::json::parse(Summary());
    std::map<std::string, test::Case> runs;
    for (const auto& [controller, summary] : summaries.items()) {
      runs[controller] = {summary};
      EXPECT_TRUE(runs[controller].finished()) << controller;
    }
    return runs;
  }
  /// The runs of a scenario with seeds 1 and 2, which must finish.
  std::vector<test::Case> RunSeeds(const std::string& scenario) const {
    std::vector<test::Case> runs;
    for (const std::string seed : {"1", "2"}) {
      runs.push_back(Run(TENON_CDPR, scenario + " --set log_rate_hz=10 --seed " + seed));
      EXPECT_TRUE(runs.back().finished()) << scenario;
    }
    return runs;
  }
};

TEST_F(CdprCasesTest, D1) {
  for (const int seed : {1, 2}) {
    auto runs = Compare("D1", seed);
    const test::Case &ours = runs["mpc_equilibrium"], &zero = runs["mpc_zero"], &pd = runs["pd"];
    for (const char* key : {"euler_oscillation_rms_rad", "acceleration_rms_m_per_s2"}) {
      EXPECT_LT(ours[key], zero[key]) << key;
      EXPECT_LT(zero[key], pd[key]) << key;
    }
    for (const test::Case* other : {&zero, &pd})
      EXPECT_LT(ours["tension_rate_rms_N_per_s"], (*other)["tension_rate_rms_N_per_s"]);
    EXPECT_LE(ours["tracking_error_rms_m"], 0.0015);
    EXPECT_GE(ours["tension_min_N"], 5);
    for (const auto& [controller, run] : runs) {
      EXPECT_GE(run["command_min_N"], 0) << controller;
      EXPECT_LE(run["command_max_N"], 800) << controller;
      EXPECT_GT(run["tension_min_N"], 0) << controller;
    }
  }
}

// The MPC reduces the initial tensions in the first second.
TEST_F(CdprCasesTest, MissedThatThePdChangesTensionsFasterThanMpcZeroInD1) {
  auto runs = Compare("D1", 1);
  EXPECT_GT(runs["mpc_zero"]["tension_rate_rms_N_per_s"], runs["pd"]["tension_rate_rms_N_per_s"]);
}

// With the errors of real sensors and winches the order is as expected.
TEST_F(CdprCasesTest, D1WithTheHardwareOfARobot) {
  for (const int seed : {1, 2}) {
    const auto rate = [&](const std::string& controller) {
      return Run(TENON_CDPR, "D1 --set hardware=standard --set log_rate_hz=10 --controller " + controller +
                                 " --seed " + std::to_string(seed))["tension_rate_rms_N_per_s"];
    };
    const double ours = rate("mpc_equilibrium"), zero = rate("mpc_zero"), pd = rate("pd");
    EXPECT_LT(ours, zero);
    EXPECT_LT(zero, pd);
  }
}

TEST_F(CdprCasesTest, D2) {
  for (const int seed : {1, 2}) {
    auto runs = Compare("D2", seed);
    const double ours = runs["mpc_equilibrium"]["settling_time_s"];
    EXPECT_GT(ours, 0.1) << "the release was felt";
    EXPECT_LE(ours, 3);
    EXPECT_GE(runs["pd"]["settling_time_s"], 2 * ours);

    const test::Case &mpc = runs["mpc_equilibrium"], &pd = runs["pd_feedforward"];
    EXPECT_LE(ours, 2);
    EXPECT_LE(mpc["loaded_error_rms_m"], 0.01);
    EXPECT_LE(mpc["release_peak_m"], pd["release_peak_m"]);
    for (const char* key : {"loaded_error_rms_m", "loaded_swing_rms_rad"})
      EXPECT_GE(pd[key], 1.5 * mpc[key]) << key;
    EXPECT_GT(mpc["command_min_N"], 0) << "a bound";
    EXPECT_LT(mpc["command_max_N"], 800) << "a bound";
  }
}

// With weights that give up position to damp rotation, the MPC in the thesis's form settles 1.8 times faster
// than the PD; the thesis, which does not print its weights, reports 1.75. It does not know the load, which
// leaves an error.
TEST_F(CdprCasesTest, ThesisMpcInD2) {
  const auto run = [&](const std::string& options) {
    return Run(TENON_CDPR, "D2 --set log_rate_hz=10 " + options);
  };
  const test::Case pd = run("--controller pd"),
                   thesis =
                       run("mpc.weights.position_per_m2=1000 mpc.weights.velocity_s2_per_m2=20 "
                           "mpc.weights.attitude_per_rad2=20 "
                           "mpc.weights.angular_velocity_s2_per_rad2=4 --controller mpc_thesis");
  EXPECT_TRUE(thesis.finished());
  EXPECT_NEAR(pd["settling_time_s"] / thesis["settling_time_s"], 1.84, 0.1);
  EXPECT_NEAR(thesis["loaded_error_rms_m"], 0.35, 0.01);
}

// Without bounds that act, the regulator with the same weights and load estimate is as good as the MPC, which
// plans ahead; where they act, it is not.
TEST_F(CdprCasesTest, TheHorizonMattersWhereBoundsAct) {
  const auto ratio = [&](const std::string& scenario) {
    const auto run = [&](const std::string& controller) {
      return Run(TENON_CDPR, scenario + " --duration 20 --set log_rate_hz=10 --controller " +
                                 controller)["tracking_error_rms_m"];
    };
    return run("lqr") / run("mpc_equilibrium");
  };
  EXPECT_NEAR(ratio("D1"), 1, 0.15);
  for (const std::string scenario : {"D1-fast", "D1-edge"}) EXPECT_GT(ratio(scenario), 1.5) << scenario;
}

// Tension bounds act: the solver that knows them tracks better than one that clamps its commands.
TEST_F(CdprCasesTest, BoundsActInFastCirclesAndNearTheEdge) {
  for (const std::string scenario : {"D1-fast", "D1-edge"}) {
    const auto run = [&](const std::string& options) {
      return Run(TENON_CDPR, scenario + " --duration 20 --set log_rate_hz=10 " + options);
    };
    const test::Case newton = run(""), none = run("--set mpc.bounds=none"),
                     pd = run("--controller pd_feedforward");
    EXPECT_TRUE(newton.finished()) << scenario;
    EXPECT_EQ(newton["command_min_N"], 0) << scenario;
    EXPECT_LE(newton["tracking_error_rms_m"], 0.01) << scenario;
    for (const test::Case* other : {&none, &pd})
      EXPECT_LT(1.2 * newton["tracking_error_rms_m"], (*other)["tracking_error_rms_m"]) << scenario;
  }
}

// Path constraints keep platform and cables away from a post, and cables from one another.
TEST_F(CdprCasesTest, D1AroundAPost) {
  for (const test::Case& run : RunSeeds("D1-post")) EXPECT_GE(run["clearance_min_m"], 0.1);
  const test::Case without = Run(TENON_CDPR, "D1-post --set mpc.clearance_m=null --set log_rate_hz=10");
  EXPECT_FALSE(without.finished());
  EXPECT_LT(without["clearance_min_m"], 0);
  EXPECT_GT(Run(TENON_CDPR, "waypoints --set mpc.cable_clearance_m=0.3")["cable_distance_min_m"], 0.29);
}

// Pulleys that the controllers model hardly change the errors.
TEST_F(CdprCasesTest, PulleysThatAreKnown) {
  for (const int seed : {1, 3}) {
    const auto run = [&](const std::string& scenario, const std::string& robot) {
      return Run(TENON_CDPR, scenario + " --set 'robot={file: cdpr_4" + robot +
                                 "}' --set log_rate_hz=10 --seed " + std::to_string(seed));
    };
    const std::string pulleys = ", winch: {pulley_radius_m: 0.04}";
    auto circle = run("D1 --controller mpc_equilibrium", pulleys);
    EXPECT_TRUE(circle.finished());
    EXPECT_LE(circle["tracking_error_rms_m"], 0.0015);
    EXPECT_LE(run("D1 --controller pd", pulleys)["tracking_error_rms_m"], 0.008);
    auto load = run("D2 --controller mpc_equilibrium", pulleys);
    EXPECT_TRUE(load.finished());
    EXPECT_LE(load["loaded_error_rms_m"], 0.01);
    EXPECT_LE(load["tension_rate_rms_N_per_s"],
              1.1 * run("D2 --controller mpc_equilibrium", "")["tension_rate_rms_N_per_s"]);
  }
}

// 6, 8 and 12 cables; with rotations where the cables permit these.
TEST_F(CdprCasesTest, CirclesAndTurns) {
  for (const std::string scenario : {"circle_6", "circle_8", "circle_12", "turn_8", "turn_12"}) {
    for (const test::Case& run : RunSeeds(scenario)) {
      EXPECT_LE(run["tracking_error_rms_m"], 0.005) << scenario;
      EXPECT_LE(run["euler_oscillation_rms_rad"], 0.005) << scenario;
      EXPECT_GT(run["tension_min_N"], 0) << scenario;
      EXPECT_EQ(run["mpc_fallbacks"], 0) << scenario;
    }
  }
}

TEST_F(CdprCasesTest, D2OfManyCables) {
  for (const std::string scenario : {"D2-6", "D2-8", "D2-12"}) {
    for (const test::Case& run : RunSeeds(scenario)) {
      EXPECT_LE(run["loaded_error_rms_m"], 0.01) << scenario;
      EXPECT_LE(run["settling_time_s"], 2) << scenario;
      EXPECT_GT(run["tension_min_N"], 0) << scenario;
    }
  }
}

// A gust of a fifth of the weight, and a load that swings under the platform.
TEST_F(CdprCasesTest, GustAndPendulum) {
  for (const std::string scenario : {"gust", "pendulum"}) {
    for (const test::Case& run : RunSeeds(scenario)) EXPECT_LE(run["tracking_error_rms_m"], 0.02) << scenario;
  }
}

// The other seven cables hold the platform within 0.1 m; none becomes slack or leaves its bounds.
TEST_F(CdprCasesTest, BrokenCable) {
  for (const int seed : {1, 2}) {
    const test::Case run =
        Run(TENON_CDPR, "broken_cable --set log_rate_hz=200 --seed " + std::to_string(seed));
    EXPECT_TRUE(run.finished());
    const std::vector<double> time = test::Column(out, "time [s]");
    double farthest = 0;
    for (const char* axis : {"x", "y", "z"}) {
      const auto is = test::Column(out, std::string("loop.plant.platform.p_WB.") + axis + " [m]");
      const auto should =
          test::Column(out, std::string("loop.reference.reference.position.") + axis + " [m]");
      for (std::size_t i = 0; i < time.size(); ++i)
        farthest = std::max(farthest, std::abs(is[i] - should[i]));
    }
    EXPECT_GT(farthest, 0.01) << "it was felt";
    EXPECT_LT(farthest, 0.1);
    for (int cable = 0; cable < 8; ++cable) {
      const std::string n = std::to_string(cable);
      const auto tension = test::Column(out, "loop.plant.cables.tension." + n + " [N]"),
                 command = test::Column(out, "loop.command." + n + " [N]");
      for (std::size_t i = 0; i < time.size(); ++i) {
        if (cable == 0 && time[i] >= 12) {
          EXPECT_EQ(tension[i], 0);
          if (time[i] > 12.1) {
            EXPECT_EQ(command[i], 0) << "the controller knows";
          }
        } else {
          ASSERT_GT(tension[i], 0) << cable << " at " << time[i];
          ASSERT_GE(command[i], 10);
          ASSERT_LE(command[i], 800);
        }
      }
    }
  }
}

TEST_F(CdprCasesTest, ABrokenCableThatIsNeededEndsTheRun) {
  const test::Case run = Run(TENON_CDPR, "broken_cable --set path.center_m=[0,0,1.6] --set log_rate_hz=10");
  EXPECT_FALSE(run.finished());
  EXPECT_THAT(run.summary.at("end_reason").get<std::string>(), ::testing::HasSubstr("cable 0"));
}

}  // namespace tenon::cdpr_cases_test
