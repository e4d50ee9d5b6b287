#include <tenon/tests/apps/run_app.h>
#include <tenon/tests/plants/model/mesh_test_files.h>

namespace tenon::test::tenon_robot_test {

using ::testing::HasSubstr;

namespace fs = std::filesystem;

class TenonRobotTest : public AppTest {
 protected:
  TenonRobotTest() : AppTest(TENON_ROBOT) {}
};

// From a URDF to a robot that trots; all files are in one directory.
TEST_F(TenonRobotTest, MakesARobotWalk) {
  EXPECT_THAT(Run(TENON_ROBOTS_DIR "/a1.urdf"),
              HasSubstrs("mass_kg                      12.78", "trots                        yes",
                         "foot_radius_m is guessed", (out / "stand/report.html").string() + "\n",
                         (out / "trot/report.html").string() + "\n"));
  EXPECT_THAT(ReadText(out / "a1.yaml"), HasSubstrs("urdf: a1.urdf", "front_left: FL_foot"));
  EXPECT_EQ(ReadText(out / "a1.urdf"), ReadText(TENON_ROBOTS_DIR "/a1.urdf"));
  EXPECT_THAT(ReadText(out / "a1.svg"), HasSubstr("<svg"));
  EXPECT_TRUE(fs::exists(out / "stand/report.html"));
  EXPECT_TRUE(fs::exists(out / "trot/summary.json"));
}

// The copies of a URDF refer to the meshes of its package by absolute paths.
TEST_F(TenonRobotTest, CopiesOfTheUrdfFindItsMeshes) {
  const fs::path package = TemporaryPath("a1_description");
  WriteTetrahedron(package / "meshes/t.stl");
  std::string urdf = ReadText(TENON_ROBOTS_DIR "/a1.urdf");
  const std::string link = "<link name=\"FL_calf\">";
  urdf.insert(urdf.find(link) + link.size(), "<visual><geometry><mesh filename=\"package://" +
                                                 package.filename().string() +
                                                 "/meshes/t.stl\"/></geometry></visual>");
  std::ofstream(package / "a1.urdf") << urdf;
  Run((package / "a1.urdf").string());
  const std::string absolute = "\"file://" + fs::canonical(package / "meshes/t.stl").string() + "\"";
  EXPECT_THAT(ReadText(out / "a1.urdf"), HasSubstr(absolute));
  EXPECT_THAT(ReadText(out / "trot/files/robot.urdf"), HasSubstr(absolute));
  EXPECT_THAT(ReadText(out / "trot/report.html"),
              HasSubstr(R"("kind":"mesh","role":"bodies","name":"link of FL_calf_joint")"));
  fs::remove_all(package);
}

// The help shows the option with several values.
TEST_F(TenonRobotTest, OneOptionMayLockSeveralJoints) {
  const std::string locks = " --lock FL_hip_joint=0 FR_hip_joint=0";
  EXPECT_THAT(RunCommand(TENON_ROBOT " --help").text, HasSubstr("--lock JOINT=ANGLE ..."));
  for (const std::string& arguments :
       {TENON_ROBOTS_DIR "/a1.urdf" + locks, locks + " " TENON_ROBOTS_DIR "/a1.urdf"})
    EXPECT_THAT(Run(arguments, 2),
                HasSubstrs("FL_thigh_joint - FL_calf_joint (2)", "FR_thigh_joint - FR_calf_joint (2)"));
}

// A limit of the file size stands for a full disk. After the trial that it stops there is no other one.
TEST_F(TenonRobotTest, EndsWithATrialThatCannotBeWritten) {
  const Result run =
      RunCommand("sh -c 'ulimit -f 100; " TENON_ROBOT " " TENON_ROBOTS_DIR "/a1.urdf" + Out() + "'");
  EXPECT_EQ(run.exit_code, 5) << run.text;
  EXPECT_THAT(run.text, HasSubstr("unknown: "));
  EXPECT_TRUE(fs::exists(out / "stand"));
  EXPECT_FALSE(fs::exists(out / "trot"));
}

TEST_F(TenonRobotTest, WritesIntoNoDirectoryOfAnotherRun) {
  fs::create_directories(out);
  const Result run =
      RunCommand("flock " + out.string() + " " TENON_ROBOT " " TENON_ROBOTS_DIR "/a1.urdf" + Out());
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.text, HasSubstr(out.string()));
  EXPECT_FALSE(fs::exists(out / "a1.yaml"));
}

// A program of this name on the PATH stands for xacro, which Debian has not. No file beside it is
// overwritten.
TEST_F(TenonRobotTest, ExpandsXacroWhereItIsInstalled) {
  const fs::path home = TemporaryPath("xacro_home");
  fs::create_directories(home);
  const std::string urdf = ReadText(TENON_ROBOTS_DIR "/a1.urdf"),
                    xacro =
                        ReadText(TENON_ROBOTS_DIR "/a1.urdf").insert(urdf.find("</robot>"), "<xacro:leg/>");
  for (const char* name : {"dog.xacro", "dog.urdf"}) std::ofstream(home / name) << xacro;
  std::ofstream(home / "xacro") << "#!/bin/sh\n[ $2 = -o ] && sed 's|<xacro:leg/>||' \"$1\" > \"$3\"\n";
  fs::permissions(home / "xacro", fs::perms::owner_all);
  for (const char* name : {"dog.xacro", "dog.urdf"}) {
    const std::string run =
        TENON_ROBOT " " + (home / name).string() + " --strict --up x --out " + home.string();
    EXPECT_THAT(RunCommand(run).text, HasSubstrs("xacro file", "dog_2.urdf"));
    EXPECT_THAT(RunCommand("env PATH=" + home.string() + ":$PATH " + run).text,
                HasSubstr("dog_expanded.urdf:"));
    EXPECT_EQ(ReadText(home / "dog.urdf"), xacro);
    EXPECT_EQ(ReadText(home / "dog_expanded.urdf"), urdf);
  }
  fs::remove_all(home);
}

TEST_F(TenonRobotTest, RefusesBadUsage) {
  const std::string a1 = TENON_ROBOTS_DIR "/a1.urdf";
  ExpectRefused({{"nowhere.urdf", "nowhere.urdf"},
                 {a1 + " --lock FL_hip_joint=up", "--lock FL_hip_joint=up: "},
                 {a1 + " --forward x --up x", "--up x: "},
                 {a1 + " --lock FL_hip_joint=0", "FL_thigh_joint - FL_calf_joint (2)"}});
  EXPECT_FALSE(fs::exists(out / "a1.yaml"));
}

}  // namespace tenon::test::tenon_robot_test
