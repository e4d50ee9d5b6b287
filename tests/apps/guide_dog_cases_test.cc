// The cases of the guide dog, with DogBot and the observers in the loop.

#include <nlohmann/json.hpp>

#include "tenon/tests/apps/run_app.h"

namespace tenon {
namespace {

/// The figures of a scenario that has run.
struct Case {
  double operator[](const char* key) const { return summary.at(key).get<double>(); }
  nlohmann::json summary;
};

class GuideDogCasesTest : public test::AppTest {
 protected:
  /// Runs a scenario, which must reach its end.
  Case RunCase(const std::string& scenario) const {
    const test::Result result = test::RunCommand(std::string(TENON_GUIDE_DOG) + " " + scenario + Out());
    EXPECT_EQ(result.exit_code, 0) << result.text;
    const Case run{nlohmann::json::parse(test::Read(out / "summary.json"))};
    EXPECT_TRUE(run.summary.at("finished").get<bool>());
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

TEST_F(GuideDogCasesTest, C1) {
  const Case run = RunCase("C1");
  ExpectSteady(run);
  EXPECT_GT(run["tension_max_N"], 50) << "the person has stopped the robot";
  EXPECT_LT(run["tension_max_N"], 60);
  EXPECT_LT(run["stop_delay_s"], 1);
}

TEST_F(GuideDogCasesTest, C1Sine) {
  const Case run = RunCase("C1-sine");
  ExpectSteady(run);
  EXPECT_LT(run["tension_max_N"], 45);
}

TEST_F(GuideDogCasesTest, C2) {
  const Case run = RunCase("C2");
  ExpectSteady(run);
  EXPECT_LT(run["tension_max_N"], 45);
}

TEST_F(GuideDogCasesTest, C3) {
  const Case run = RunCase("C3");
  ExpectSteady(run);
  EXPECT_LT(run["heading_error_deg"], 5);
  EXPECT_LT(run["stop_delay_s"], 1);
}

}  // namespace
}  // namespace tenon
