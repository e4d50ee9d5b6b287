// The cases of the guide dog, with DogBot and the observers in the loop.

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace {

namespace fs = std::filesystem;

/// summary.json of a scenario that must run to its end.
nlohmann::json RunCase(const std::string& scenario) {
  const fs::path out = fs::temp_directory_path() / ("tenon_guide_dog_case_" + scenario);
  const std::string command =
      std::string(TENON_GUIDE_DOG) + " " + scenario + " --out " + out.string() + " > /dev/null 2>&1";
  EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 0);
  const auto summary = nlohmann::json::parse(std::ifstream(out / "summary.json"));
  fs::remove_all(out);
  EXPECT_TRUE(summary["finished"]);
  return summary;
}

void ExpectSteady(const nlohmann::json& summary) {
  EXPECT_NEAR(summary["tension_mean_N"], 30, 3);
  const double distance = summary["distance_mean_m"];
  EXPECT_GT(summary["distance_min_m"], 0.95 * distance);
  EXPECT_LT(summary["distance_max_m"], 1.05 * distance);
  EXPECT_LT(summary["force_estimate_error_rms_N"], 2);
  EXPECT_EQ(summary["qp_failures"], 0);
}

TEST(GuideDogCasesTest, C1) {
  const auto summary = RunCase("C1");
  ExpectSteady(summary);
  EXPECT_GT(summary["tension_max_N"], 50) << "the person has stopped the robot";
  EXPECT_LT(summary["tension_max_N"], 60);
  EXPECT_LT(summary["stop_delay_s"], 1);
}

TEST(GuideDogCasesTest, C1Sine) {
  const auto summary = RunCase("C1-sine");
  ExpectSteady(summary);
  EXPECT_LT(summary["tension_max_N"], 45);
}

TEST(GuideDogCasesTest, C2) {
  const auto summary = RunCase("C2");
  ExpectSteady(summary);
  EXPECT_LT(summary["tension_max_N"], 45);
}

TEST(GuideDogCasesTest, C3) {
  const auto summary = RunCase("C3");
  ExpectSteady(summary);
  EXPECT_LT(summary["heading_error_deg"], 5);
  EXPECT_LT(summary["stop_delay_s"], 1);
}

}  // namespace
