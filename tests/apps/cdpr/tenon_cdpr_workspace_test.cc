// Figures, cells and report of a workspace.

#include <tenon/tests/apps/run_app.h>

#include <nlohmann/json.hpp>

namespace tenon::tenon_cdpr_workspace_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using Json = nlohmann::json;

class TenonCdprWorkspaceTest : public test::AppTest {
 protected:
  TenonCdprWorkspaceTest() : AppTest(TENON_CDPR_WORKSPACE) {}
  Json Figures() const { return Json::parse(Summary()); }
};

TEST_F(TenonCdprWorkspaceTest, WritesFiguresCellsAndReport) {
  EXPECT_THAT(Run("cogiro --load 100 --acceleration 0.5 --cell 1 --turn 0.4"),
              HasSubstrs("static_volume_proven_m3", "any_axis_turn_proven_rad"));
  const Json summary = Figures();
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
  EXPECT_THAT(ReadText(out / "attitudes.csv"), HasSubstr("x [rad]"));
  EXPECT_THAT(ReadText(out / "report.html").substr(0, 500), HasSubstr("<title>cogiro: workspace"));
}

TEST_F(TenonCdprWorkspaceTest, TakesAFileAndSettings) {
  const std::string file = (fs::path(TENON_ROBOTS_DIR) / "cdpr_6.yaml").string();
  const std::string common = file + " --cell 0.5 --turn 0.2 --position 0 0 1.5";
  Run(common);
  const double strong = Figures()["static_volume_m3"];
  Run(common + " --set cable_properties.tension_max_N=60");
  const Json summary = Figures();
  EXPECT_LT(summary["static_volume_m3"].get<double>(), strong);
  EXPECT_EQ(summary["tension_max_N"], 60);
  EXPECT_EQ(summary["attitude_position_m"], Json({0, 0, 1.5}));
}

TEST_F(TenonCdprWorkspaceTest, HasEquilibriaOfFourCablesAndWrenchClosureOfEight) {
  EXPECT_THAT(Run("cdpr_4 --cell 1 --load 5"), HasSubstr("equilibrium_volume_m3"));
  const Json four = Figures();
  EXPECT_GT(four["equilibrium_share"].get<double>(), 0.4);
  EXPECT_LT(four["equilibrium_share"].get<double>(), 1);
  EXPECT_GT(four["equilibrium_stiffness_min_N_per_m"].get<double>(), 0);
  EXPECT_THAT(ReadText(out / "cells.csv"), HasSubstrs("tilt [rad]", "holds,", "fails,"));
  Run("cogiro --low -1 -1 1 --high 1 1 2 --cell 0.5 --turn 0.2");
  EXPECT_EQ(Figures()["closure_volume_possible_m3"], 0);  // all its cables come from above
  Run("ipanema_3 --cell 2 --turn 0.2");
  EXPECT_GT(Figures()["closure_volume_m3"].get<double>(), 0);
}

TEST_F(TenonCdprWorkspaceTest, HasAreasOfPlanarRobots) {
  const std::string robot =
      "cdpr_4 --set on_table=true --set 'cables=[{anchor_m: [-1.1, -1, 0], attachment_m: [-0.15, 0, 0]}, "
      "{anchor_m: [-1.1, 1, 0], attachment_m: [-0.15, 0, 0]}, {anchor_m: [1.1, -1, 0], attachment_m: "
      "[0.15, 0, 0]}, {anchor_m: [1.1, 1, 0], attachment_m: [0.15, 0, 0]}]'";
  EXPECT_THAT(Run(robot), HasSubstr("static_area_proven_m2"));
  const Json summary = Figures();
  EXPECT_NEAR(summary["box_area_m2"], 4.4, 1e-12);
  EXPECT_GT(summary["static_clear_area_proven_m2"].get<double>(), 3);
  EXPECT_GT(summary["attitude_range_proven_rad"].get<double>(), 1);
  ExpectRefused(
      {{robot + " --attitude 0.1 0 0", "plane z = 0"}, {robot + " --position 0 0 1", "plane z = 0"}});
}

TEST_F(TenonCdprWorkspaceTest, OutputThatCannotBeWrittenIsExitCode5) {
  std::ofstream(out).put('x');  // a file where the directory should be
  Run("cdpr_6 --cell 1", 5);
}

TEST_F(TenonCdprWorkspaceTest, RefusesBadUsage) {
  ExpectRefused({{"", "ROBOT"},
                 {"cogirro", "'cogiro'"},
                 {"cdpr_4 --force 5", "'cdpr_4'"},
                 {"cdpr_4 --attitude 0 0 1", "attitude"},
                 {"cdpr_8 --load -1", "load"},
                 {"cdpr_8 --cell 0", "cell"},
                 {"cdpr_8 --cell 0.001", "cell"},
                 {"cdpr_8 --turn 4", "turn"},
                 {"cdpr_8 --low 0 0", "--low"},
                 {"cdpr_8 --low 0 0 9", "along z"},
                 {"cdpr_8 --low -inf 0 0", "along x"},
                 {"cdpr_8 --attitude nan 0 0", "attitude"},
                 {"cdpr_8 --cable-diameter -1", "diameter"},
                 {"cdpr_8 --set mass_kg=0", "--set mass_kg=0: mass_kg: "},
                 {"cdpr_8 --set mass_kg", "--set mass_kg: "}});
}

}  // namespace tenon::tenon_cdpr_workspace_test
