#include <tenon/plants/model/quadruped_description.h>
#include <tenon/plants/model/quadruped_model.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/framework/types/errors.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/systems/yaml/yaml.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/expect_throws.h>
#include <tenon/tests/testing/matchers.h>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>

namespace tenon::quadruped_description_test {
namespace {

namespace fs = std::filesystem;
const std::string kRobots = TENON_ROBOTS_DIR;

std::string ReadFile(const fs::path& path) {
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

/// A new directory, for as long as it lives.
struct Directory {
  Directory() {
    std::string name = (fs::temp_directory_path() / "tenon_quadruped_XXXXXX").string();
    path = ::mkdtemp(name.data());
  }
  ~Directory() { fs::remove_all(path); }
  fs::path path;
};

/// A copy of a robot's two files with one change each, in a directory of its own.
class RobotFiles {
 public:
  explicit RobotFiles(const std::string& robot) : robot_(robot) {
    yaml = ReadFile(kRobots + "/" + robot + ".yaml");
    urdf = ReadFile(kRobots + "/" + robot + ".urdf");
  }
  std::string yaml, urdf;

  RobotFiles& Change(std::string RobotFiles::*file, const std::string& from, const std::string& to) {
    const std::size_t at = (this->*file).find(from);
    EXPECT_NE(at, std::string::npos) << from;
    (this->*file).replace(at, from.size(), to);
    return *this;
  }
  QuadrupedDescription Load() const {
    const Directory directory;
    std::ofstream(directory.path / (robot_ + ".yaml")) << yaml;
    std::ofstream(directory.path / (robot_ + ".urdf")) << urdf;
    return LoadQuadruped(directory.path / (robot_ + ".yaml"));
  }

 private:
  std::string robot_;
};

template <class... Parts>
::testing::AssertionResult Refused(const RobotFiles& files, const Parts&... parts) {
  return Throws<ParameterError>([&] { files.Load(); }, parts...);
}

TEST(QuadrupedDescriptionTest, ReadsDogBot) {
  const QuadrupedDescription robot = LoadQuadruped(kRobots + "/dogbot.yaml");
  EXPECT_EQ(robot.name, "dogbot");
  EXPECT_NEAR(robot.mass(), 9.3 + 4 * (0.836 + 1.851 + 0.302), 1e-12);
  EXPECT_EQ(robot.foot_radius, 0.028);
  // Its stance: trunk 0.43 m high; hip, thigh and shank of 0.315 m and (0.035, -0.3) m by hand.
  EXPECT_NEAR(robot.StanceHeight(), 0.43, 1e-3);
  const double hip = 0.886, shank = 0.886 - 1.604;
  const Eigen::Vector3d foot(
      -0.2875 - 0.315 * std::sin(hip) + 0.035 * std::cos(shank) - 0.3 * std::sin(shank), -0.088 - 0.09875,
      -0.315 * std::cos(hip) - 0.035 * std::sin(shank) - 0.3 * std::cos(shank));
  EXPECT_THAT(robot.FootPosition(kRearRight, robot.stance), IsNear(foot, 1e-14));
  for (int j = 0; j < kNumJoints; ++j) {
    EXPECT_EQ(robot.joint(j).torque_limit, 60);
    EXPECT_EQ(robot.joint(j).speed_limit, 6);
    EXPECT_THAT(robot.joint(j).axis,
                IsNear(j % 3 == 0 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY(), 0));
  }
  EXPECT_EQ(robot.joint(3 * kFrontRight).name, "front_right_abduction");
}

TEST(QuadrupedDescriptionTest, ReadsA1AndMergesItsFeetIntoItsCalves) {
  const QuadrupedDescription robot = LoadQuadruped(kRobots + "/a1.yaml");
  EXPECT_NEAR(robot.mass(), 6 + 4 * (0.595 + 0.888 + 0.151 + 0.06), 1e-12);
  EXPECT_NEAR(robot.StanceHeight(), 0.4 * std::cos(0.8) + 0.02, 1e-12);
  EXPECT_EQ(robot.joint(3 * kRearLeft + 2).name, "RL_calf_joint");
  // Calf and foot as one: total mass, common CoM, parallel axes.
  const RigidInertia& shank = robot.legs[kFrontLeft].bodies[2];
  const double m1 = 0.151, m2 = 0.06;
  const Eigen::Vector3d c1(0.007105, -0.000239, -0.096933), c2(0, 0, -0.2);
  EXPECT_NEAR(shank.mass, m1 + m2, 1e-15);
  EXPECT_THAT(shank.com, IsNear((m1 * c1 + m2 * c2) / (m1 + m2), 1e-14));
  const Eigen::Vector3d d = c1 - c2;  // two masses about their CoM: reduced mass times distance squared
  Eigen::Matrix3d inertia;
  inertia << 0.002344758 + 9.6e-6, 0, -0.000141275, 0, 0.002360755 + 9.6e-6, 0, -0.000141275, 0,
      3.1158e-5 + 9.6e-6;
  inertia += m1 * m2 / (m1 + m2) * (d.squaredNorm() * Eigen::Matrix3d::Identity() - d * d.transpose());
  EXPECT_THAT(shank.inertia, IsNear(inertia, 1e-15));
}

TEST(QuadrupedDescriptionTest, TurnedLinksAndJointsAreTheSameRobot) {
  // The front-left calf as before, but with its frame turned by 90 degrees about x, and its axis with it.
  RobotFiles files("dogbot");
  files.Change(
      &RobotFiles::urdf,
      "<child link=\"front_left_lower_leg\"/>\n    <origin xyz=\"0 0 -0.315\"/>\n    <axis xyz=\"0 1 0\"/>",
      "<child link=\"front_left_lower_leg\"/>\n    <origin xyz=\"0 0 -0.315\" rpy=\"1.5707963267948966 0 "
      "0\"/>\n"
      "    <axis xyz=\"0 0 -1\"/>");
  files.Change(
      &RobotFiles::urdf,
      "<link name=\"front_left_lower_leg\">\n    <inertial>\n      <origin xyz=\"0.029 0 -0.1439\"/>",
      "<link name=\"front_left_lower_leg\">\n    <inertial>\n      <origin xyz=\"0.029 -0.1439 0\" "
      "rpy=\"-1.5707963267948966 0 0\"/>");
  files.Change(&RobotFiles::urdf, "<child link=\"front_left_foot\"/>\n    <origin xyz=\"0.035 0 -0.3\"/>",
               "<child link=\"front_left_foot\"/>\n    <origin xyz=\"0.035 -0.3 0\"/>");
  const QuadrupedDescription turned = files.Load(), plain = LoadQuadruped(kRobots + "/dogbot.yaml");
  const LegDescription &a = turned.legs[kFrontLeft], &b = plain.legs[kFrontLeft];
  EXPECT_THAT(a.joints[2].axis, IsNear(b.joints[2].axis, 1e-15));
  EXPECT_THAT(a.joints[2].p_PJ, IsNear(b.joints[2].p_PJ, 1e-15));
  EXPECT_THAT(a.bodies[2].com, IsNear(b.bodies[2].com, 1e-15));
  EXPECT_THAT(a.bodies[2].inertia, IsNear(b.bodies[2].inertia, 1e-15));
  EXPECT_THAT(a.foot_J, IsNear(b.foot_J, 1e-15));
}

TEST(QuadrupedDescriptionTest, ContinuousJointsHaveNoEnd) {
  RobotFiles files("a1");
  files.Change(&RobotFiles::urdf, "\"FL_thigh_joint\" type=\"revolute\"",
               "\"FL_thigh_joint\" type=\"continuous\"");
  const QuadrupedDescription robot = files.Load();
  EXPECT_EQ(robot.joint(1).lower, -std::numeric_limits<double>::infinity());
  EXPECT_EQ(robot.joint(1).upper, std::numeric_limits<double>::infinity());
  EXPECT_EQ(robot.joint(4).upper, 4.1888);
}

TEST(QuadrupedDescriptionTest, RefusesFeetThatTheUrdfLacks) {
  RobotFiles files("dogbot");
  files.Change(&RobotFiles::yaml, "front_left: front_left_foot", "front_left: front_left_fot");
  EXPECT_TRUE(
      Refused(files, "dogbot.urdf", "no link 'front_left_fot'", "did you mean 'front_left_foot'", "'feet'"));
}

TEST(QuadrupedDescriptionTest, RefusesAMissingJoint) {
  RobotFiles files("a1");
  files.Change(&RobotFiles::urdf, "\"RR_calf_joint\" type=\"revolute\"", "\"RR_calf_joint\" type=\"fixed\"");
  EXPECT_TRUE(Refused(files, "a1.urdf", "leg rear_right has 2 revolute joints",
                      "'RR_hip_joint', 'RR_thigh_joint'", "must have 3", "add missing joints"));
}

TEST(QuadrupedDescriptionTest, RefusesJointsThatItCannotUse) {
  RobotFiles slider("a1");
  slider.Change(&RobotFiles::urdf, "\"FL_foot_fixed\" type=\"fixed\"", "\"FL_foot_fixed\" type=\"floating\"");
  EXPECT_TRUE(Refused(slider, "a1.urdf", "'FL_foot_fixed' must be revolute or fixed", "make it fixed"));

  RobotFiles arm("a1");
  arm.Change(&RobotFiles::urdf, "</robot>",
             "<link name=\"arm\"/><joint name=\"shoulder\" type=\"continuous\"><parent link=\"trunk\"/>"
             "<child link=\"arm\"/><axis xyz=\"0 0 1\"/></joint></robot>");
  EXPECT_TRUE(Refused(arm, "a1.urdf", "'shoulder' turns but belongs to no leg", "make it fixed"));

  RobotFiles weak("a1");
  weak.Change(&RobotFiles::urdf, "effort=\"33.5\"", "effort=\"0\"");
  EXPECT_TRUE(Refused(weak, "a1.urdf", "'FL_hip_joint' has no limits of torque and speed", "<limit effort"));

  RobotFiles range("a1");
  range.Change(&RobotFiles::urdf, "lower=\"-0.8029\"", "lower=\"0.9\"");
  EXPECT_TRUE(Refused(range, "a1.urdf", "'FL_hip_joint' has the range 0.9 to 0.8029 rad", "below"));

  RobotFiles axis("a1");
  axis.Change(&RobotFiles::urdf, "<axis xyz=\"1 0 0\"/>", "<axis xyz=\"0 0 0\"/>");
  EXPECT_TRUE(Throws<ParameterError>([&] { axis.Load(); }, "a1.urdf", "'FL_hip_joint'", "axis"));
}

TEST(QuadrupedDescriptionTest, RefusesBodiesThatCannotBe) {
  RobotFiles zero("dogbot");
  zero.Change(&RobotFiles::urdf,
              "ixx=\"0.00509\" ixy=\"0\" ixz=\"0\" iyy=\"0.00527\" iyz=\"0\" izz=\"0.0008\"",
              "ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"");
  EXPECT_TRUE(
      Refused(zero, "dogbot.urdf", "link 'front_left_lower_leg'", "not positive definite", "check signs"));

  RobotFiles impossible("dogbot");
  impossible.Change(&RobotFiles::urdf, "ixx=\"0.091\"", "ixx=\"1.91\"");
  EXPECT_TRUE(Refused(impossible, "dogbot.urdf", "link 'body'", "above the sum of the other two", "check"));

  RobotFiles massless("dogbot");
  massless.Change(&RobotFiles::urdf, "<mass value=\"0.836\"/>", "<mass value=\"0\"/>");
  EXPECT_TRUE(Refused(massless, "dogbot.urdf", "'front_left_hip' has no mass", "<inertial>"));

  RobotFiles negative("dogbot");
  negative.Change(&RobotFiles::urdf, "<mass value=\"9.3\"/>", "<mass value=\"-9.3\"/>");
  EXPECT_TRUE(Refused(negative, "dogbot.urdf", "link 'body' has the mass -9.3 kg", "positive"));
}

TEST(QuadrupedDescriptionTest, RefusesYamlThatItDoesNotKnow) {
  RobotFiles unknown("dogbot");
  unknown.Change(&RobotFiles::yaml, "foot_radius_m: 0.028", "foot_radius_m: 0.028\nfoot_mass_kg: 0.1");
  EXPECT_TRUE(Refused(unknown, "dogbot.yaml:1", "foot_mass_kg"));

  RobotFiles missing("dogbot");
  missing.Change(&RobotFiles::yaml, "foot_radius_m: 0.028", "");
  EXPECT_TRUE(Refused(missing, "dogbot.yaml", "foot_radius_m"));

  RobotFiles radius("dogbot");
  radius.Change(&RobotFiles::yaml, "foot_radius_m: 0.028", "foot_radius_m: 0");
  EXPECT_TRUE(Refused(radius, "dogbot.yaml", "foot_radius_m is 0 m", "must be positive"));
}

// As far as the foot gets from the hip over all knee angles.
TEST(QuadrupedDescriptionTest, LegsAreAsLongAsTheyReach) {
  const QuadrupedDescription robot = LoadQuadruped(kRobots + "/dogbot.yaml");
  Vec<12> q = robot.stance;
  double most = 0;
  for (double knee = -1; knee <= 1; knee += 1e-3) {
    q[3 * kRearLeft + 2] = knee;
    most = std::max(most, (robot.FootPosition(kRearLeft, q) - robot.HipPosition(kRearLeft, q)).norm());
  }
  EXPECT_NEAR(robot.LegLength(kRearLeft), most, 1e-3 * most);
}

TEST(QuadrupedDescriptionTest, ReadsWhereTheInertialUnitIs) {
  RobotFiles moved("dogbot");
  moved.Change(&RobotFiles::yaml, "imu_position_m: [0, 0, 0]", "imu_position_m: [0.1, -0.2, 0.3]");
  EXPECT_EQ(moved.Load().imu_B, Eigen::Vector3d(0.1, -0.2, 0.3));
  RobotFiles nowhere("dogbot");
  nowhere.Change(&RobotFiles::yaml, "imu_position_m: [0, 0, 0]", "imu_position_m: [.nan, 0, 0]");
  EXPECT_TRUE(Refused(nowhere, "dogbot.yaml", "imu_position_m.0: expected a finite number"));
}

TEST(QuadrupedDescriptionTest, SaysOnceWhichMeshesAreMissing) {
  RobotFiles files("a1");
  EXPECT_EQ(files.Load().meshes[0], nullptr);
  for (const char* link : {"trunk", "FL_calf"}) {
    const std::string start = std::string("<link name=\"") + link + "\">";
    files.Change(&RobotFiles::urdf, start,
                 start + "<visual><geometry><mesh filename=\"package://a1/no.stl\"/></geometry></visual>");
  }
  const Directory directory;
  std::ofstream(directory.path / "a1.yaml") << files.yaml;
  std::ofstream(directory.path / "a1.urdf") << files.urdf;
  const std::vector<std::string> warnings =
      QuadrupedWarnings(YamlFile{(directory.path / "a1.yaml").string()});
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0],
              ::testing::AllOf(::testing::HasSubstr("a1.urdf:"),
                               ::testing::HasSubstr("link 'trunk': the mesh 'package://a1/no.stl' is not "
                                                    "found, nor is 1 other; plain shapes are drawn"),
                               ::testing::HasSubstr("ROS_PACKAGE_PATH")));
  EXPECT_EQ(files.Load().meshes[0], nullptr);
}

// Frames that only name a place: an inertia that no body has is mended and told, one without mass left out.
TEST(QuadrupedDescriptionTest, MendsTheInertiaOfFrames) {
  const auto with_frame = [](const std::string& inertial) {
    RobotFiles files("a1");
    files.Change(&RobotFiles::urdf, "</robot>",
                 "<link name=\"imu\">" + inertial +
                     "</link><joint name=\"imu_joint\" type=\"fixed\"><parent link=\"trunk\"/><child "
                     "link=\"imu\"/></joint>"
                     "</robot>");
    return files;
  };
  const auto warnings = [](const RobotFiles& files) {
    const Directory directory;
    std::ofstream(directory.path / "a1.yaml") << files.yaml;
    std::ofstream(directory.path / "a1.urdf") << files.urdf;
    return QuadrupedWarnings(YamlFile{(directory.path / "a1.yaml").string()});
  };
  EXPECT_TRUE(warnings(RobotFiles("a1")).empty());
  const double trunk = LoadQuadruped(kRobots + "/a1.yaml").trunk.inertia(0, 0);

  const RobotFiles negative = with_frame(
      "<inertial><mass value=\"0.001\"/><inertia ixx=\"-1\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" "
      "izz=\"0\"/></inertial>");
  EXPECT_NEAR(negative.Load().trunk.inertia(0, 0), trunk, 1e-6);
  ASSERT_EQ(warnings(negative).size(), 1u);
  EXPECT_THAT(warnings(negative)[0],
              ::testing::AllOf(::testing::HasSubstr("a1.urdf:"), ::testing::HasSubstr("link 'imu'"),
                               ::testing::HasSubstr("taken with")));
  const RobotFiles massless = with_frame(
      "<inertial><mass value=\"0\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" "
      "izz=\"1\"/></inertial>");
  EXPECT_NEAR(massless.Load().trunk.inertia(0, 0), trunk, 1e-15);
  EXPECT_THAT(warnings(massless)[0], ::testing::HasSubstr("has an inertia but no mass"));
  // The nearest: 1, 2 and 4 kg m^2 have second moments of 2.5, 1.5 and -0.5, and without the last 1.5, 2.5
  // and 4.
  const RobotFiles flat = with_frame(
      "<inertial><mass value=\"0.001\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"2\" iyz=\"0\" "
      "izz=\"4\"/></inertial>");
  EXPECT_THAT(warnings(flat)[0], ::testing::HasSubstr("taken with 1.5, 2.5, 4 kg m^2"));
}

TEST(QuadrupedDescriptionTest, TheYamlGivesLimitsThatTheUrdfLacks) {
  RobotFiles files("a1");
  files.Change(&RobotFiles::urdf,
               "<limit lower=\"-0.8029\" upper=\"0.8029\" effort=\"33.5\" velocity=\"21\"/>", "");
  EXPECT_TRUE(Refused(files, "a1.urdf:", "'FL_hip_joint' has no limits", "joint_limits.abduction"));
  files.yaml += "joint_limits:\n  abduction: {torque_N_m: 30, speed_rad_per_s: 20, range_rad: [-1, 1]}\n";
  const QuadrupedDescription robot = files.Load();
  EXPECT_EQ(robot.joint(0).torque_limit, 30);
  EXPECT_EQ(robot.joint(0).lower, -1);
  EXPECT_EQ(robot.joint(1).torque_limit, 33.5);
  files.Change(&RobotFiles::yaml, "[-1, 1]", "[1, -1]");
  EXPECT_TRUE(Refused(files, "a1.yaml", "range_rad is 1 to -1", "below"));
}

TEST(QuadrupedDescriptionTest, LockedJointsAreNone) {
  RobotFiles files("a1");
  // A wheel below each foot would be a fourth joint.
  files.Change(
      &RobotFiles::urdf, "</robot>",
      "<link name=\"wheel\"/><joint name=\"wheel_joint\" type=\"continuous\"><parent link=\"FL_foot\"/>"
      "<child link=\"wheel\"/><origin xyz=\"0.1 0 0\"/><axis xyz=\"0 1 0\"/></joint>"
      "<link name=\"tip\"/><joint name=\"tip_joint\" type=\"fixed\"><parent link=\"wheel\"/>"
      "<child link=\"tip\"/><origin xyz=\"0 0 -0.1\"/></joint></robot>");
  files.Change(&RobotFiles::yaml, "front_left: FL_foot", "front_left: tip");
  EXPECT_TRUE(Refused(files, "leg front_left has 4 revolute joints", "'wheel_joint'", "'locked_joints'"));
  files.yaml += "locked_joints: [{joint: wheel_joint, angle_rad: 1.5707963267948966}]\n";
  EXPECT_THAT(files.Load().legs[0].foot_J, IsNear(Eigen::Vector3d(0.1 - 0.1, 0, -0.2), 1e-12));
  files.Change(&RobotFiles::yaml, "joint: wheel_joint", "joint: wheel_joitn");
  EXPECT_TRUE(Refused(files, "no joint 'wheel_joitn'", "did you mean 'wheel_joint'"));
}

TEST(QuadrupedDescriptionTest, RefusesAStanceThatCannotBe) {
  RobotFiles order("dogbot");
  order.Change(&RobotFiles::yaml, "front_left: front_left_foot, front_right: front_right_foot",
               "front_left: front_right_foot, front_right: front_left_foot");
  EXPECT_TRUE(Refused(order, "dogbot.yaml", "feet.front_left", "which is front right", "swap"));

  RobotFiles shared("dogbot");
  shared.Change(&RobotFiles::yaml, "front_right: front_right_foot", "front_right: front_left_foot");
  EXPECT_TRUE(Refused(shared, "dogbot.urdf", "is in the legs front_left and front_right", "'feet'"));

  RobotFiles range("a1");
  range.Change(&RobotFiles::yaml, "rear_left:   [0, 0.8, -1.6]", "rear_left:   [0, 0.8, 0]");
  EXPECT_TRUE(Refused(range, "a1.yaml", "nominal_stance.rear_left.2", "'RL_calf_joint'", "change one"));
}

TEST(QuadrupedDescriptionTest, RefusesDrivesAndContactsThatCannotBe) {
  for (const std::string key :
       {"rotor_inertia_kg_m2", "damping_N_m_s_per_rad", "friction_N_m", "stop_stiffness_N_m_per_rad",
        "stop_dissipation_s_per_rad", "stiffness_N_per_m", "dissipation_s_per_m", "blend_m",
        "bristle_stiffness_per_m", "bristle_damping_s_per_m", "bristle_friction", "full_friction_N",
        "release_time_s"}) {
    RobotFiles files("dogbot");
    files.Change(&RobotFiles::yaml, "  " + key + ": ", "  " + key + ": -1  # ");
    EXPECT_TRUE(Refused(files, "dogbot.yaml", key + " is -", "must"));
  }
  RobotFiles damping("dogbot");
  damping.Change(&RobotFiles::yaml, "damping_N_m_s_per_rad: 0", "damping_N_m_s_per_rad: 1e6");
  EXPECT_TRUE(Refused(damping, "dogbot.yaml", "damping_N_m_s_per_rad is 1", "must be at most 10000"));
  RobotFiles ratio("dogbot");
  ratio.Change(&RobotFiles::yaml, "full_torque_speed_ratio: 0.5", "full_torque_speed_ratio: 1");
  EXPECT_TRUE(Refused(ratio, "dogbot.yaml", "full_torque_speed_ratio is 1", "below 1"));
}

TEST(QuadrupedDescriptionTest, RefusesFilesThatAreNoUrdf) {
  RobotFiles files("dogbot");
  files.urdf = "<robot name=\"dogbot\"><link";
  EXPECT_TRUE(Refused(files, "dogbot.urdf:1", "not a valid URDF", "correct the XML"));
  RobotFiles missing("dogbot");
  missing.Change(&RobotFiles::yaml, "urdf: dogbot.urdf", "urdf: dogbto.urdf");
  EXPECT_TRUE(Refused(missing, "dogbot.yaml:", "urdf: ", "dogbto.urdf", "cannot be read"));
}

// urdfdom would leave out what it cannot read: a lighter robot.
TEST(QuadrupedDescriptionTest, RefusesNumbersThatAreNone) {
  for (const char* bad : {"9.3kg", "9,3", "", "nan", "9.3 1", "1e999"}) {
    RobotFiles files("dogbot");
    files.Change(&RobotFiles::urdf, "<mass value=\"9.3\"/>", "<mass value=\"" + std::string(bad) + "\"/>");
    EXPECT_TRUE(
        Refused(files, "dogbot.urdf:", "link 'body': <mass value=\"" + std::string(bad), "one number"));
  }
  RobotFiles root("a1");
  root.urdf = "<mass value=\"x\"/>";
  EXPECT_TRUE(Refused(root, "a1.urdf:1", "<mass value=\"x\">", "one number"));
  RobotFiles axis("a1");
  axis.Change(&RobotFiles::urdf, "<axis xyz=\"1 0 0\"/>", "<axis xyz=\"1 0\"/>");
  EXPECT_TRUE(Refused(axis, "joint 'FL_hip_joint': <axis xyz=\"1 0\">", "three numbers"));
}

TEST(QuadrupedDescriptionTest, RefusesInertiasWithoutAMass) {
  for (const char* mass : {"<mass/>", "<mass valu=\"0.151\"/>", "<mas value=\"0.151\"/>"}) {
    RobotFiles files("a1");
    files.Change(&RobotFiles::urdf, "<mass value=\"0.151\"/>", mass);
    EXPECT_TRUE(Refused(files, "a1.urdf:", "link 'FL_calf'", "<inertial> has no mass")) << mass;
  }
}

TEST(QuadrupedDescriptionTest, RefusesInertiasThatAreNotWhole) {
  RobotFiles without("a1");
  without.Change(&RobotFiles::urdf, "<mass value=\"0.151\"/>",
                 "<mass value=\"0.151\"/></inertial><inertial>");
  EXPECT_TRUE(
      Refused(without, "a1.yaml:", "urdf: ", "a1.urdf:", "link 'FL_calf'", "<inertial> has no inertia"));
  RobotFiles part("a1");
  part.Change(&RobotFiles::urdf, " iyz=", " iyx=");
  EXPECT_TRUE(Refused(part, "a1.urdf:", "its <inertia> has no iyz"));
}

TEST(QuadrupedDescriptionTest, RefusesLinksWithoutOrWithHugeNames) {
  RobotFiles nameless("a1");
  nameless.Change(&RobotFiles::urdf, "</robot>", "\n<link/></robot>");
  EXPECT_TRUE(Refused(nameless, "a1.urdf:", "a link has no name"));
  RobotFiles huge("a1");
  huge.Change(&RobotFiles::urdf, "</robot>", "<link name=\"" + std::string(81, 'x') + "\"/></robot>");
  EXPECT_TRUE(Refused(huge, "a1.urdf:", "the name of an element has 81 bytes"));
}

TEST(QuadrupedDescriptionTest, RefusesAStanceInWhichItCannotStand) {
  RobotFiles files("dogbot");  // a foot above its knee
  files.Change(&RobotFiles::urdf, "<origin xyz=\"0.035 0 -0.3\"/>", "<origin xyz=\"0.035 0 0.1\"/>");
  EXPECT_TRUE(Refused(files, "dogbot.yaml:", "nominal_stance: ", "does not reach ground of slope (0, 0)"));
}

TEST(QuadrupedDescriptionTest, RefusesFeetThatAreNone) {
  RobotFiles files("dogbot");
  files.Change(&RobotFiles::yaml, "foot_radius_m: ", "foot_radius_m: 1.1 #");
  EXPECT_TRUE(Refused(files, "foot_radius_m: foot_radius_m is 1.1 m but must be at most 0.1"));
}

TEST(QuadrupedDescriptionTest, RefusesShapesThatAreNoNumbers) {
  for (const char* shape : {"<sphere radius=\"2cm\"/>", "<cylinder radius=\"0,02\" length=\"1\"/>",
                            "<box size=\"1 2\"/>", "<mesh filename=\"a.stl\" scale=\"1\"/>"}) {
    RobotFiles files("a1");
    files.Change(
        &RobotFiles::urdf, "</robot>",
        fmt::format("<link name=\"q\"><collision><geometry>{}</geometry></collision></link></robot>", shape));
    EXPECT_TRUE(Refused(files, "a1.urdf:", "link 'q'", "numbers with blanks") ||
                Refused(files, "a1.urdf:", "link 'q'", "write one number"))
        << shape;
  }
}

TEST(QuadrupedDescriptionTest, RefusesLinksThatFormNoTree) {
  RobotFiles ring("a1");  // beside the robot
  ring.Change(&RobotFiles::urdf, "</robot>",
              "<link name=\"x\"/><link name=\"y\"/>"
              "<joint name=\"xy\" type=\"fixed\"><parent link=\"x\"/><child link=\"y\"/></joint>"
              "<joint name=\"yx\" type=\"fixed\"><parent link=\"y\"/><child link=\"x\"/></joint></robot>");
  EXPECT_TRUE(Refused(ring, "a1.urdf:", "the joints 'xy', 'yx' form a loop", "remove one"));
  RobotFiles back("a1");  // from a foot to the leg's first link
  back.Change(&RobotFiles::urdf, "</robot>",
              "<joint name=\"back\" type=\"fixed\"><parent link=\"FL_foot\"/><child link=\"FL_hip\"/>"
              "</joint></robot>");
  EXPECT_TRUE(Refused(back, "'FL_hip' has two parent joints, 'FL_hip_joint' and 'back'"));
}

TEST(QuadrupedDescriptionTest, RefusesWhatIsTooDeepOrTooLarge) {
  RobotFiles deep("a1");
  std::string nest;
  for (int i = 0; i < 100000; ++i) nest += "<a>";
  deep.Change(&RobotFiles::urdf, "</robot>", nest);
  EXPECT_TRUE(Refused(deep, "a1.urdf:", "nested deeper than 32"));
  RobotFiles large("a1");
  large.urdf.append(17 << 20, ' ');
  EXPECT_TRUE(Refused(large, "a1.urdf", "limit of", "bytes"));
  RobotFiles many("a1");
  std::string links;
  for (int i = 0; i < 1000; ++i) links += fmt::format("<link name=\"link_{}\"/>", i);
  many.Change(&RobotFiles::urdf, "</robot>", links + "</robot>");
  EXPECT_TRUE(Refused(many, "a1.urdf:", "more than 1000 links"));
  RobotFiles wide("a1");
  std::string attributes;
  for (int i = 0; i < 40; ++i) attributes += fmt::format(" a{}=\"1\"", i);
  wide.Change(&RobotFiles::urdf, "</robot>", "<link" + attributes + "/></robot>");
  EXPECT_TRUE(Refused(wide, "a1.urdf:", "40 attributes", "at most 32"));
}

TEST(QuadrupedDescriptionTest, RefusesWhatIsNoRobotsSize) {
  RobotFiles files("dogbot");
  files.Change(&RobotFiles::urdf, "<mass value=\"9.3\"/>", "<mass value=\"9.3e9\"/>");
  EXPECT_TRUE(Refused(files, "link 'body': <mass value=\"9.3e9\">", "the absolute value must be at most"));
  RobotFiles far("a1");
  far.Change(&RobotFiles::urdf, "<origin xyz=\"0.1805 0.047 0\"/>", "<origin xyz=\"0.1805 101 0\"/>");
  EXPECT_TRUE(Refused(far, "a1.urdf:", "must be at most 100", "SI unit"));
}

TEST(QuadrupedDescriptionTest, ErrorsGiveTheLine) {
  RobotFiles files("dogbot");
  const std::string link = "<link name=\"body\">";
  const auto at = files.urdf.find(link);
  ASSERT_NE(at, std::string::npos);
  const auto line =
      1 + std::count(files.urdf.begin(), files.urdf.begin() + static_cast<std::ptrdiff_t>(at), '\n');
  files.Change(&RobotFiles::urdf, "<mass value=\"9.3\"/>", "<mass value=\"-9.3\"/>");
  EXPECT_TRUE(Refused(files, "dogbot.urdf:" + std::to_string(line) + ": link 'body' has the mass -9.3 kg"));
  RobotFiles untyped("a1");  // what the parser says has the line, too
  untyped.Change(&RobotFiles::urdf, "type=\"revolute\"", "type=\"screw\"");
  EXPECT_TRUE(Refused(untyped, "a1.urdf:", ": not a valid URDF: Joint [", "has no known type [screw]"));
}

// Momentum and inertia about B's origin add up.
TEST(WithPayloadTest, AddsMassAndInertiaAboutTheTrunksOrigin) {
  const QuadrupedDescription robot = test::DogBot();
  RigidInertia payload;
  payload.mass = 4;
  payload.com = {0.1, -0.2, 0.15};
  payload.inertia.diagonal() << 0.02, 0.03, 0.04;
  const RigidInertia sum = WithPayload(robot, payload).trunk;
  EXPECT_DOUBLE_EQ(sum.mass, robot.trunk.mass + 4);
  EXPECT_TRUE((sum.mass * sum.com).isApprox(robot.trunk.mass * robot.trunk.com + 4 * payload.com, 1e-12));
  const auto about_origin = [](const RigidInertia& body) -> Eigen::Matrix3d {
    return body.inertia + body.mass * (body.com.squaredNorm() * Eigen::Matrix3d::Identity() -
                                       body.com * body.com.transpose());
  };
  EXPECT_TRUE(about_origin(sum).isApprox(about_origin(robot.trunk) + about_origin(payload), 1e-12));
  EXPECT_DOUBLE_EQ(WithPayload(robot, payload).mass(), robot.mass() + 4);
}

// A robot of other density moves in the same way under forces that grow with its mass.
TEST(WithMassFactorTest, ScalesMassesAndInertias) {
  const QuadrupedDescription robot = test::DogBot(), heavy = WithMassFactor(robot, 1.3);
  EXPECT_NEAR(heavy.mass(), 1.3 * robot.mass(), 1e-12);
  QuadrupedDescription still = robot, heavier = heavy;
  still.drive.rotor_inertia = heavier.drive.rotor_inertia = 0;
  RandomStream random(3);
  const LeggedState x = test::RandomState(random);
  QuadrupedDynamics a, b;
  QuadrupedModel(still).Calc(x, &a);
  QuadrupedModel(heavier).Calc(x, &b);
  EXPECT_TRUE(b.M.isApprox(1.3 * a.M, 1e-12));
  EXPECT_TRUE(b.bias().isApprox(1.3 * a.bias(), 1e-12));
  EXPECT_TRUE(b.com_W.isApprox(a.com_W, 1e-12));
}

TEST(WithMassFactorTest, RefusesWhatIsNoFactor) {
  EXPECT_TRUE(
      Throws<ParameterError>([] { WithMassFactor(test::DogBot(), 0); }, "a mass factor of 0", "positive"));
}

TEST(WithPayloadTest, RefusesNegativeMass) {
  RigidInertia payload;
  payload.mass = -1;
  EXPECT_TRUE(Throws<ParameterError>([&] { WithPayload(test::DogBot(), payload); }, "a payload of -1 kg",
                                     "give 0 for none"));
}

}  // namespace
}  // namespace tenon::quadruped_description_test
