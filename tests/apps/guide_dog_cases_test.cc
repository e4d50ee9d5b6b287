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

/// The figures of a scenario that must run to its end.
class Case {
 public:
  explicit Case(const std::string& scenario) {
    const fs::path out = fs::temp_directory_path() / ("tenon_guide_dog_case_" + scenario);
    const std::string command =
        std::string(TENON_GUIDE_DOG) + " " + scenario + " --out " + out.string() + " > /dev/null 2>&1";
    EXPECT_EQ(WEXITSTATUS(std::system(command.c_str())), 0);
    std::ifstream file(out / "summary.json");
    file >> summary_;
    fs::remove_all(out);
    EXPECT_TRUE(summary_.at("finished").get<bool>());
  }
  double operator[](const char* key) const { return summary_.at(key).get<double>(); }

 private:
  nlohmann::json summary_;
};

void ExpectSteady(const Case& run) {
  EXPECT_NEAR(run["tension_mean_N"], 30, 3);
  EXPECT_GT(run["distance_min_m"], 0.95 * run["distance_mean_m"]);
  EXPECT_LT(run["distance_max_m"], 1.05 * run["distance_mean_m"]);
  EXPECT_LT(run["force_estimate_error_rms_N"], 2);
  EXPECT_EQ(run["qp_failures"], 0);
}

TEST(GuideDogCasesTest, C1) {
  const Case run("C1");
  ExpectSteady(run);
  EXPECT_GT(run["tension_max_N"], 50) << "the person has stopped the robot";
  EXPECT_LT(run["tension_max_N"], 60);
  EXPECT_LT(run["stop_delay_s"], 1);
}

TEST(GuideDogCasesTest, C1Sine) {
  const Case run("C1-sine");
  ExpectSteady(run);
  EXPECT_LT(run["tension_max_N"], 45);
}

TEST(GuideDogCasesTest, C2) {
  const Case run("C2");
  ExpectSteady(run);
  EXPECT_LT(run["tension_max_N"], 45);
}

TEST(GuideDogCasesTest, C3) {
  const Case run("C3");
  ExpectSteady(run);
  EXPECT_LT(run["heading_error_deg"], 5);
  EXPECT_LT(run["stop_delay_s"], 1);
}

}  // namespace
