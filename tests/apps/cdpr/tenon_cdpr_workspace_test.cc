// Runs the binary as its users do.

#include <tenon/tests/apps/run_app.h>

#include <nlohmann/json.hpp>

#include <cmath>
#include <fstream>

namespace tenon::tenon_cdpr_workspace_test {
namespace {

namespace fs = std::filesystem;
using test::BadUsage;
using test::Read;
using test::Result;
using test::RunCommand;
using ::testing::AllOf;
using ::testing::HasSubstr;
using Json = nlohmann::json;

Result RunApp(const std::string& arguments) {
  return RunCommand(std::string(TENON_CDPR_WORKSPACE) + " " + arguments);
}

using TenonCdprWorkspaceTest = test::AppTest;

TEST_F(TenonCdprWorkspaceTest, WritesFiguresCellsAndReport) {
  const Result result = RunApp("cogiro --load 100 --acceleration 0.5 --cell 1 --turn 0.4" + Out());
  ASSERT_EQ(result.exit_code, 0) << result.text;
  EXPECT_THAT(result.text,
              AllOf(HasSubstr("static_volume_proven_m3"), HasSubstr("any_axis_turn_proven_rad")));
  const Json summary = Json::parse(Read(out / "summary.json"));
  EXPECT_EQ(summary["robot"], "cogiro");
  EXPECT_EQ(summary["load_kg"], 100);
  for (const char* name : {"required", "static", "attitude"}) {
    const std::string unit = name == std::string("attitude") ? "rad3" : "m3";
    const auto figure = [&](const std::string& rest) {
      return summary.at(name + ("_" + rest)).get<double>();
    };
    EXPECT_LE(figure("volume_proven_" + unit), figure("volume_" + unit)) << name;
    EXPECT_LE(figure("volume_" + unit), figure("volume_possible_" + unit)) << name;
    EXPECT_LE(figure("clear_volume_" + unit), figure("volume_" + unit)) << name;
    EXPECT_GT(figure("tension_margin_max_N"), 0) << name;
    EXPECT_GT(figure("stiffness_min_N_per_m"), 0) << name;
    EXPECT_LE(figure("stiffness_min_N_per_m"), figure("stiffness_max_N_per_m")) << name;
  }
  EXPECT_LE(summary["required_volume_m3"].get<double>(), summary["static_volume_m3"].get<double>());
  EXPECT_GT(summary["static_volume_m3"].get<double>(), 300);
  EXPECT_LT(summary["static_volume_m3"].get<double>(), summary["box_volume_m3"].get<double>());

  // The cells fill the box.
  std::ifstream cells(out / "cells.csv");
  std::string line;
  std::getline(cells, line);
  EXPECT_THAT(line, HasSubstr("x [m],y [m],z [m],size_x [m]"));
  double volume = 0;
  while (std::getline(cells, line)) {
    double x, y, z, dx, dy, dz;
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf,", &x, &y, &z, &dx, &dy, &dz), 6) << line;
    volume += dx * dy * dz;
  }
  EXPECT_NEAR(volume, summary["box_volume_m3"].get<double>(), 1e-3 * volume);
  EXPECT_THAT(Read(out / "attitudes.csv"), HasSubstr("x [rad]"));
  EXPECT_THAT(Read(out / "report.html").substr(0, 500), HasSubstr("<title>cogiro: workspace"));
}

// A robot of one's own, by its path, with a value of its own.
TEST_F(TenonCdprWorkspaceTest, TakesAFileAndSettings) {
  const std::string file = (fs::path(TENON_ROBOTS_DIR) / "cdpr_6.yaml").string();
  const std::string common = file + " --cell 0.5 --turn 0.2 --position 0 0 1.5";
  ASSERT_EQ(RunApp(common + Out()).exit_code, 0);
  const double strong = Json::parse(Read(out / "summary.json"))["static_volume_m3"];
  const Result weak = RunApp(common + " --set cable_properties.tension_max_N=60" + Out());
  ASSERT_EQ(weak.exit_code, 0) << weak.text;
  const Json summary = Json::parse(Read(out / "summary.json"));
  EXPECT_LT(summary["static_volume_m3"].get<double>(), strong);
  EXPECT_EQ(summary["tension_max_N"], 60);
  EXPECT_EQ(summary["attitude_position_m"], Json({0, 0, 1.5}));
}

TEST_F(TenonCdprWorkspaceTest, OutputThatCannotBeWrittenIsExitCode5) {
  std::ofstream(out).put('x');  // a file where the directory should be
  EXPECT_EQ(RunApp("cdpr_6 --cell 1" + Out()).exit_code, 5);
}

using TenonCdprWorkspaceUsageTest = test::UsageTest;

TEST_P(TenonCdprWorkspaceUsageTest, ExitCode2WithItsMessage) {
  ExpectExitCode2WithItsMessage(TENON_CDPR_WORKSPACE);
}

INSTANTIATE_TEST_SUITE_P(
    All, TenonCdprWorkspaceUsageTest,
    ::testing::Values(BadUsage{"", "ROBOT is required"}, BadUsage{"cogirro", "did you mean 'cogiro'?"},
                      BadUsage{"cdpr_4", "robot 'cdpr_4' has 4 cables"},
                      BadUsage{"cdpr_8 --load -1", "load [kg]"}, BadUsage{"cdpr_8 --cell 0", "cells of 0"},
                      BadUsage{"cdpr_8 --turn 4", "at most pi"},
                      BadUsage{"cdpr_8 --low 0 0 9", "from 9 to 4 along z"},
                      BadUsage{"cdpr_8 --cell 0.001", "make the cells larger"},
                      BadUsage{"cdpr_8 --cable-diameter -1", "cable diameter"},
                      BadUsage{"cdpr_8 --set mass_kg=0", "give mass_kg above 0"},
                      BadUsage{"cdpr_8 --set mass_kg", "key=value"}, BadUsage{"cdpr_8 --low 0 0", "--low"},
                      BadUsage{"cdpr_8 --low -inf 0 0", "from -inf to"},
                      BadUsage{"cdpr_8 --attitude nan 0 0", "not finite"}));

}  // namespace
}  // namespace tenon::tenon_cdpr_workspace_test
