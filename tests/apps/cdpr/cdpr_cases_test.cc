// The goals of the cable robot's cases, seeds 1 and 2. A goal that is missed is expected to be missed, by
// name: who reaches it will hear of it here.

#include <map>

#include <tenon/tests/apps/run_case.h>

namespace tenon {
namespace {

class CdprCasesTest : public test::CaseTest {
 protected:
  /// The controllers' flights, which must reach their ends.
  std::map<std::string, test::Case> Compare(const std::string& scenario, int seed) const {
    const test::Result result =
        test::RunCommand(std::string(TENON_CDPR) + " " + scenario +
                         " --compare --set log_rate_hz=10 --seed " + std::to_string(seed) + Out());
    EXPECT_EQ(result.exit_code, 0) << result.text;
    const auto summaries = nlohmann::json::parse(test::Read(out / "summary.json"));
    std::map<std::string, test::Case> runs;
    for (const auto& [controller, summary] : summaries.items()) {
      runs[controller] = {summary};
      EXPECT_TRUE(runs[controller].finished()) << controller;
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
    EXPECT_LT(ours["tension_rate_rms_N_per_s"], zero["tension_rate_rms_N_per_s"]);
    EXPECT_LT(ours["tension_rate_rms_N_per_s"], pd["tension_rate_rms_N_per_s"]);
    EXPECT_LE(ours["tracking_error_rms_m"], 0.01);
    EXPECT_GE(ours["tension_min_N"], 5);
    for (const auto& [controller, run] : runs) {
      EXPECT_GE(run["command_min_N"], 0) << controller;
      EXPECT_LE(run["command_max_N"], 800) << controller;
      EXPECT_GT(run["tension_min_N"], 0) << controller;
    }
  }
}

TEST_F(CdprCasesTest, MissedThatThePdChangesTensionsFastestInD1) {
  auto runs = Compare("D1", 1);
  EXPECT_GT(runs["mpc_zero"]["tension_rate_rms_N_per_s"], runs["pd"]["tension_rate_rms_N_per_s"]);
}

TEST_F(CdprCasesTest, MissedThatTheMpcTracksD1To1500Micrometres) {
  EXPECT_GT(Compare("D1", 1)["mpc_equilibrium"]["tracking_error_rms_m"], 0.0015);
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
    for (const char* key : {"loaded_error_rms_m", "loaded_swing_rms_rad"})
      EXPECT_GE(pd[key], 1.5 * mpc[key]) << key;
    EXPECT_GT(mpc["command_min_N"], 0) << "a bound";
    EXPECT_LT(mpc["command_max_N"], 800) << "a bound";
  }
}

}  // namespace
}  // namespace tenon
