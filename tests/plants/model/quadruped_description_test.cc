#include <tenon/systems/files/input_file.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/systems/yaml/yaml.h>
#include <tenon/tests/plants/model/mesh_test_files.h>
#include <tenon/tests/plants/model/quadruped_test_arm.h>
#include <tenon/tests/plants/model/quadruped_test_robot.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace tenon::quadruped_description_test {

namespace fs = std::filesystem;
using ::testing::Contains, ::testing::ElementsAre, ::testing::HasSubstr;
const std::string kRobots = TENON_ROBOTS_DIR;

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
    yaml = ReadText(kRobots + "/" + robot + ".yaml");
    urdf = ReadText(kRobots + "/" + robot + ".urdf");
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
    return LoadQuadruped(Write(directory));
  }
  std::vector<std::string> Warnings() const {
    const Directory directory;
    return QuadrupedWarnings(YamlFile{Write(directory)});
  }

 private:
  std::string Write(const Directory& directory) const {
    std::ofstream(directory.path / (robot_ + ".yaml")) << yaml;
    std::ofstream(directory.path / (robot_ + ".urdf")) << urdf;
    return directory.path / (robot_ + ".yaml");
  }
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
  EXPECT_EQ(robot.joint(1).lower, -INFINITY);
  EXPECT_EQ(robot.joint(1).upper, INFINITY);
  EXPECT_EQ(robot.joint(4).upper, 4.1888);
}

/// A change of a robot's files, and the place and the key that the message then names.
struct BadFile {
  const char* robot;
  std::string from, to;
  const char *place, *key;
};

void ExpectRefused(std::string RobotFiles::*file, const std::vector<BadFile>& cases) {
  for (const auto& [robot, from, to, place, key] : cases) {
    RobotFiles files(robot);
    files.Change(file, from, to);
    EXPECT_TRUE(Refused(files, place, key)) << "'" << to.substr(0, 200) << "' instead of '" << from << "'";
  }
}

TEST(QuadrupedDescriptionTest, RefusesBadYaml) {
  std::vector<BadFile> cases{
      {"dogbot", "front_left: front_left_foot", "front_left: front_left_fot", "dogbot.urdf",
       "'front_left_fot'"},
      {"dogbot", "foot_radius_m: 0.028", "foot_radius_m: 0.028\nfoot_mass_kg: 0.1", "dogbot.yaml:1",
       "foot_mass_kg"},
      {"dogbot", "foot_radius_m: 0.028", "", "dogbot.yaml", "foot_radius_m"},
      {"dogbot", "foot_radius_m: 0.028", "foot_radius_m: 0", "dogbot.yaml", "foot_radius_m"},
      {"dogbot", "foot_radius_m: 0.028", "foot_radius_m: 1.1", "dogbot.yaml", "foot_radius_m"},
      {"dogbot", "imu_position_m: [0, 0, 0]", "imu_position_m: [.nan, 0, 0]", "dogbot.yaml",
       "imu_position_m.0"},
      {"dogbot", "front_left: front_left_foot, front_right: front_right_foot",
       "front_left: front_right_foot, front_right: front_left_foot", "dogbot.yaml", "feet.front_left"},
      {"dogbot", "front_right: front_right_foot", "front_right: front_left_foot", "dogbot.urdf",
       "front_left and front_right"},
      {"a1", "rear_left:   [0, 0.8, -1.6]", "rear_left:   [0, 0.8, 0]", "a1.yaml",
       "nominal_stance.rear_left.2"},
      {"dogbot", "urdf: dogbot.urdf", "urdf: dogbto.urdf", "dogbot.yaml:", "dogbto.urdf"},
      {"dogbot", "damping_N_m_s_per_rad: 0", "damping_N_m_s_per_rad: 1e6", "dogbot.yaml",
       "damping_N_m_s_per_rad"},
      {"dogbot", "full_torque_speed_ratio: 0.5", "full_torque_speed_ratio: 1", "dogbot.yaml",
       "full_torque_speed_ratio"}};
  for (const char* key : {"rotor_inertia_kg_m2", "damping_N_m_s_per_rad", "friction_N_m",
                          "stop_stiffness_N_m_per_rad", "stop_dissipation_s_per_rad", "stiffness_N_per_m",
                          "dissipation_s_per_m", "blend_m", "bristle_stiffness_per_m",
                          "bristle_damping_s_per_m", "bristle_friction", "full_friction_N", "release_time_s"})
    cases.push_back(
        {"dogbot", fmt::format("  {}: ", key), fmt::format("  {}: -1  # ", key), "dogbot.yaml", key});
  ExpectRefused(&RobotFiles::yaml, cases);
}

TEST(QuadrupedDescriptionTest, RefusesBadBodiesAndJoints) {
  ExpectRefused(
      &RobotFiles::urdf,
      {{"a1", "\"RR_calf_joint\" type=\"revolute\"", "\"RR_calf_joint\" type=\"fixed\"", "a1.urdf",
        "rear_right"},
       {"a1", "\"FL_foot_fixed\" type=\"fixed\"", "\"FL_foot_fixed\" type=\"floating\"", "a1.urdf",
        "'FL_foot_fixed'"},
       {"a1", "</robot>",
        "<link name=\"arm\"/><joint name=\"shoulder\" type=\"continuous\"><parent link=\"trunk\"/>"
        "<child link=\"arm\"/><axis xyz=\"0 0 1\"/></joint></robot>",
        "a1.urdf", "'shoulder'"},
       {"a1", "effort=\"33.5\"", "effort=\"0\"", "a1.urdf", "'FL_hip_joint'"},
       {"a1", "lower=\"-0.8029\"", "lower=\"0.9\"", "a1.urdf", "'FL_hip_joint'"},
       {"a1", "<axis xyz=\"1 0 0\"/>", "<axis xyz=\"0 0 0\"/>", "a1.urdf", "'FL_hip_joint'"},
       {"a1", "<origin xyz=\"0.1805 0.047 0\"/>", "<origin xyz=\"0.1805 101 0\"/>", "a1.urdf:", "100"},
       {"dogbot", "<mass value=\"0.836\"/>", "<mass value=\"0\"/>",
        "dogbot.urdf:", "bodies of link 'front_left_hip'"},
       {"dogbot", "<mass value=\"9.3\"/>", "<mass value=\"9.3e9\"/>", "dogbot.urdf", "link 'body'"},
       // A foot above its knee cannot stand.
       {"dogbot", "<origin xyz=\"0.035 0 -0.3\"/>", "<origin xyz=\"0.035 0 0.1\"/>",
        "dogbot.yaml:", "nominal_stance"},
       // A loop beside the robot, and one from a foot to the first link of its leg.
       {"a1", "</robot>",
        "<link name=\"x\"/><link name=\"y\"/>"
        "<joint name=\"xy\" type=\"fixed\"><parent link=\"x\"/><child link=\"y\"/></joint>"
        "<joint name=\"yx\" type=\"fixed\"><parent link=\"y\"/><child link=\"x\"/></joint></robot>",
        "a1.urdf:", "'xy', 'yx'"},
       {"a1", "</robot>",
        "<joint name=\"back\" type=\"fixed\"><parent link=\"FL_foot\"/><child "
        "link=\"FL_hip\"/></joint></robot>",
        "a1.urdf:", "'FL_hip_joint' and 'back'"}});
}

// Otherwise the robot would lack what cannot be read.
TEST(QuadrupedDescriptionTest, RefusesUrdfThatCannotBeRead) {
  const auto in_a_shape = [](const std::string& shape) {
    return "<link name=\"q\"><collision><geometry>" + shape + "</geometry></collision></link></robot>";
  };
  std::vector<BadFile> cases{
      {"a1", "<axis xyz=\"1 0 0\"/>", "<axis xyz=\"1 0\"/>", "joint 'FL_hip_joint'", "<axis xyz=\"1 0\">"},
      {"a1", "<mass value=\"0.151\"/>", "<mass/>", "a1.urdf:", "link 'FL_calf'"},
      {"a1", "<mass value=\"0.151\"/>", "<mass valu=\"0.151\"/>", "a1.urdf:", "link 'FL_calf'"},
      {"a1", "<mass value=\"0.151\"/>", "<mas value=\"0.151\"/>", "a1.urdf:", "link 'FL_calf'"},
      {"a1", "<mass value=\"0.151\"/>", "<mass value=\"0.151\"/></inertial><inertial>",
       "a1.urdf:", "link 'FL_calf'"},
      {"a1", " iyz=", " iyx=", "a1.urdf:", "iyz"},
      {"a1", "</robot>", "\n<link/></robot>", "a1.urdf:", "name"},
      {"a1", "</robot>", "<link name=\"" + std::string(201, 'x') + "\"/></robot>", "a1.urdf:", "201 bytes"},
      {"a1", "</robot>", in_a_shape("<sphere radius=\"2cm\"/>"), "a1.urdf:", "link 'q'"},
      {"a1", "</robot>", in_a_shape("<cylinder radius=\"0,02\" length=\"1\"/>"), "a1.urdf:", "link 'q'"},
      {"a1", "</robot>", in_a_shape("<box size=\"1 2\"/>"), "a1.urdf:", "link 'q'"},
      {"a1", "</robot>", in_a_shape("<mesh filename=\"a.stl\" scale=\"1\"/>"), "a1.urdf:", "link 'q'"},
      {"a1", "type=\"revolute\"", "type=\"screw\"", "a1.urdf:", "'screw'"},
      {"a1", "</robot>", "<link name=\"trunk\"/></robot>", "a1.urdf:", "link 'trunk'"},
      {"a1", "</robot>", "<link name=\"apart\"/></robot>", "a1.urdf:", "'apart'"},
      {"a1", "<parent link=\"trunk\"/>", "", "a1.urdf:", "joint 'FL_hip_joint'"},
      {"a1", "<parent link=\"trunk\"/>", "<parent link=\"tronk\"/>", "a1.urdf:", "'tronk'"},
      {"a1", "<axis xyz=\"1 0 0\"/>", "<axis xyz=\"1 0 0\"/><mimic/>", "a1.urdf:", "joint 'FL_hip_joint'"},
      {"a1", "<axis xyz=\"1 0 0\"/>", "<dynamics damping=\"x\"/>", "a1.urdf:", "joint 'FL_hip_joint'"}};
  for (const std::string bad : {"9.3kg", "9,3", "", "nan", "9.3 1", "1e999"})
    cases.push_back(
        {"dogbot", "<mass value=\"9.3\"/>", "<mass value=\"" + bad + "\"/>", "dogbot.urdf:", "link 'body'"});
  ExpectRefused(&RobotFiles::urdf, cases);
  for (const char* text : {"<robot name=\"dogbot\"><link", "<mass value=\"x\"/>"}) {
    RobotFiles files("dogbot");
    files.urdf = text;
    EXPECT_TRUE(Refused(files, "dogbot.urdf:1")) << text;
  }
}

TEST(QuadrupedDescriptionTest, BlanksAroundNumbersDoNotCount) {
  RobotFiles files("a1");
  files.Change(&RobotFiles::urdf, "<mass value=\"0.151\"/>", "<mass value=\"\t0.151 \"/>");
  EXPECT_EQ(files.Load().mass(), RobotFiles("a1").Load().mass());
}

TEST(QuadrupedDescriptionTest, ListsElementsThatAreNotRead) {
  RobotFiles files("a1");
  files.Change(&RobotFiles::urdf, "</robot>", "<gazebo><any/></gazebo><transmission/>\n<frame/></robot>");
  const auto line = std::count(files.urdf.begin(), files.urdf.end(), '\n');
  files.Change(&RobotFiles::urdf, "<mass value=\"0.151\"/>", "<mass value=\"0.151\"/><density/>");
  files.Change(&RobotFiles::urdf, "</inertial>", "</inertial><inertial><mass value=\"9\"/></inertial>");
  files.Change(&RobotFiles::urdf, "<axis xyz=\"1 0 0\"/>",
               "<axis xyz=\"1 0 0\"/><dynamics rotor_inertia=\"1\"/>");
  EXPECT_THAT(files.Warnings(),
              ElementsAre(HasSubstrs("a1.urdf:", "inertial/density"), HasSubstrs("a1.urdf:", "link/inertial"),
                          HasSubstrs("a1.urdf:" + std::to_string(line), "robot/frame")));
}

// A shape that is not read does not hide those after it.
TEST(QuadrupedDescriptionTest, DrawsTheShapesAfterAnUnknownOne) {
  RobotFiles files("a1");
  const std::string shape = "<visual><geometry><capsule/></geometry></visual>";
  files.Change(&RobotFiles::urdf, "</inertial>",
               "</inertial>" + shape + "<visual><geometry><mesh filename=\"no.stl\"/></geometry></visual>");
  EXPECT_THAT(files.Warnings(), Contains(HasSubstr("'no.stl'")));
}

TEST(QuadrupedDescriptionTest, RefusesHugeUrdf) {
  std::string nest, links, attributes;
  for (int i = 0; i < 100000; ++i) nest += "<a>";
  for (int i = 0; i < 1000; ++i) links += fmt::format("<link name=\"link_{}\"/>", i);
  for (int i = 0; i < 40; ++i) attributes += fmt::format(" a{}=\"1\"", i);
  ExpectRefused(&RobotFiles::urdf,
                {{"a1", "</robot>", nest, "a1.urdf:", "32"},
                 {"a1", "</robot>", links + "</robot>", "a1.urdf:", "1000 links"},
                 {"a1", "</robot>", "<link" + attributes + "/></robot>", "a1.urdf:", "40 attributes"},
                 {"a1", "</robot>", "</robot>" + std::string(17 << 20, ' '), "a1.urdf", "bytes"}});
}

TEST(QuadrupedDescriptionTest, ErrorsNameTheLine) {
  RobotFiles files("dogbot");
  const auto at = files.urdf.begin() + static_cast<std::ptrdiff_t>(files.urdf.find("<link name=\"body\">"));
  const auto line = 1 + std::count(files.urdf.begin(), at, '\n');
  files.Change(&RobotFiles::urdf, "<mass value=\"9.3\"/>", "<mass value=\"-9.3\"/>");
  EXPECT_TRUE(Refused(files, "dogbot.urdf:" + std::to_string(line) + ": link 'body'"));
}

// The length of a leg is the largest distance of foot and hip over all knee angles.
TEST(QuadrupedDescriptionTest, LegLengthIsTheLargestReach) {
  const QuadrupedDescription robot = LoadQuadruped(kRobots + "/dogbot.yaml");
  Vec<12> q = robot.stance;
  double most = 0;
  for (double knee = -1; knee <= 1; knee += 1e-3) {
    q[3 * kRearLeft + 2] = knee;
    most = std::max(most, (robot.FootPosition(kRearLeft, q) - robot.HipPosition(kRearLeft, q)).norm());
  }
  EXPECT_NEAR(robot.LegLength(kRearLeft), most, 1e-3 * most);
}

TEST(QuadrupedDescriptionTest, ReadsThePositionOfTheImu) {
  RobotFiles moved("dogbot");
  moved.Change(&RobotFiles::yaml, "imu_position_m: [0, 0, 0]", "imu_position_m: [0.1, -0.2, 0.3]");
  EXPECT_EQ(moved.Load().imu_B, Eigen::Vector3d(0.1, -0.2, 0.3));
}

TEST(QuadrupedDescriptionTest, WarnsOnceAboutMissingMeshes) {
  RobotFiles files("a1");
  EXPECT_EQ(files.Load().meshes[0], nullptr);
  for (const char* link : {"trunk", "FL_calf"}) {
    const std::string start = std::string("<link name=\"") + link + "\">";
    files.Change(&RobotFiles::urdf, start,
                 start + "<visual><geometry><mesh filename=\"package://a1/no.stl\"/></geometry></visual>");
  }
  const std::vector<std::string> warnings = files.Warnings();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0], HasSubstrs("a1.urdf:", "link 'trunk'", "package://a1/no.stl", "1 other"));
  EXPECT_EQ(files.Load().meshes[0], nullptr);
  files.Change(&RobotFiles::urdf, "<visual><geometry><mesh", "<collision><geometry><mesh");
  files.Change(&RobotFiles::urdf, "</visual>", "</collision>");
  EXPECT_THAT(files.Warnings(), Contains(HasSubstrs("link 'trunk'", "contact of the trunk")));
}

// The mesh of a camera alone would hide the trunk, but a trunk without its camera is still one.
TEST(QuadrupedDescriptionTest, DrawsABodyByItsShapeIfTheMeshOfItsMainLinkIsMissing) {
  const Directory directory;
  const std::string mesh = directory.path / "my mesh \u00e4.stl";
  test::WriteTetrahedron(mesh);
  std::ofstream(directory.path / "text.stl") << "text";
  const auto with = [&](std::initializer_list<std::pair<std::string, std::string>> meshes) {
    RobotFiles files("a1");
    for (const auto& [link, name] : meshes) {
      const std::string start = "<link name=\"" + link + "\"" + (link == "base" ? "" : ">");
      files.Change(&RobotFiles::urdf, start + (link == "base" ? "/>" : ""),
                   "<link name=\"" + link + "\"><visual><geometry><mesh filename=\"" + name +
                       "\"/></geometry></visual>" + (link == "base" ? "</link>" : ""));
    }
    return files;
  };
  const std::string found = "file://" + mesh, unreadable = "file://" + (directory.path / "text.stl").string();
  const auto trunk = [](const RobotFiles& files) { return files.Load().meshes[0]; };
  EXPECT_NE(trunk(with({{"trunk", found}})), nullptr);
  EXPECT_NE(trunk(with({{"trunk", found}, {"base", "no.stl"}})), nullptr);
  EXPECT_EQ(trunk(with({{"base", found}, {"trunk", "no.stl"}})), nullptr);
  EXPECT_NE(with({{"FL_calf", found}}).Load().meshes[1 + kJointsPerLeg * kFrontLeft + 2], nullptr);
  EXPECT_THAT(with({{"base", unreadable}, {"trunk", "no.stl"}}).Warnings(),
              ElementsAre(HasSubstr("'no.stl' is not found"), HasSubstr("can be read")));
}

// The shapes of a frame alone are not those of the trunk.
TEST(QuadrupedDescriptionTest, ReadsTheCollisionShapesOfTheTrunk) {
  const auto with = [](const std::string& link, const std::string& shape) {
    RobotFiles files("a1");
    const std::string collision =
        "<collision><origin xyz=\"0 0 0.1\" rpy=\"0 1.5707963267948966 0\"/><geometry>" + shape +
        "</geometry></collision>";
    files.Change(&RobotFiles::urdf, "<link name=\"trunk\">",
                 "<link name=\"trunk\">" + (link == "trunk" ? collision : ""));
    files.Change(&RobotFiles::urdf, "<link name=\"base\"/>",
                 "<link name=\"base\">" + (link == "base" ? collision : "") + "</link>");
    return files.Load().trunk_shapes;
  };
  EXPECT_TRUE(with("base", "<sphere radius=\"0.01\"/>").empty());
  const RoundedBox box = with("trunk", "<box size=\"0.1 0.2 0.3\"/>").at(0);
  EXPECT_THAT(box.half, IsNear(Eigen::Vector3d(0.05, 0.1, 0.15), 1e-15));
  EXPECT_THAT(box.p_B, IsNear(Eigen::Vector3d(0, 0, 0.1), 1e-15));
  EXPECT_THAT(box.R_BS.col(2), IsNear(Eigen::Vector3d::UnitX(), 1e-15));
  const RoundedBox capsule = with("trunk", "<cylinder radius=\"0.1\" length=\"0.6\"/>").at(0);
  EXPECT_EQ(capsule.radius, 0.1);
  EXPECT_THAT(capsule.half, IsNear(Eigen::Vector3d(0, 0, 0.2), 1e-15));
}

TEST(QuadrupedDescriptionTest, SharesAMassByTheVolumeOfShapes) {
  const double mass = LoadQuadruped(kRobots + "/a1.yaml").mass();
  const auto without = [](const std::string& shape) {
    RobotFiles files("a1");
    files.Change(&RobotFiles::urdf, "<mass value=\"6\"/>", "<mass value=\"0\"/>");
    for (int leg = 0; leg < kNumLegs; ++leg)  // shanks and feet
      files.Change(&RobotFiles::urdf, "<mass value=\"0.151\"/>", "<mass value=\"0\"/>")
          .Change(&RobotFiles::urdf, "<mass value=\"0.06\"/>", "<mass value=\"0\"/>");
    for (const auto& [link, geometry] : {std::pair<std::string, std::string>{"trunk", shape},
                                         {"FL_calf", "<sphere radius=\"0.03\"/>"},
                                         {"FR_calf", "<cylinder radius=\"0.02\" length=\"0.1\"/>"},
                                         {"RL_calf", "<sphere radius=\"0.03\"/>"},
                                         {"RR_calf", "<sphere radius=\"0.03\"/>"}})
      if (!geometry.empty())
        files.Change(&RobotFiles::urdf, "<link name=\"" + link + "\">",
                     "<link name=\"" + link + "\"><collision><origin xyz=\"0 0 -0.1\"/><geometry>" +
                         geometry + "</geometry></collision>");
    return files;
  };
  RobotFiles files = without("<box size=\"0.3 0.2 0.1\"/>");
  EXPECT_TRUE(Refused(files, "'trunk'", "'FL_calf'", "--mass"));
  files.yaml += "mass_kg: 10\n";
  const QuadrupedDescription robot = files.Load();
  EXPECT_NEAR(robot.mass(), 10, 1e-12);
  const double given = mass - 6 - 4 * 0.211, ball = 4 * M_PI / 3 * 2.7e-5, bar = M_PI * 4e-5,
               density = (10 - given) / (0.006 + 3 * ball + bar);
  EXPECT_NEAR(robot.trunk.mass, density * 0.006, 1e-12);
  EXPECT_NEAR(robot.trunk.inertia(0, 0), robot.trunk.mass / 12 * 0.05, 1e-12);
  const RigidInertia& shank = robot.legs[kFrontRight].bodies[2];
  EXPECT_NEAR(shank.mass, density * bar, 1e-12);
  EXPECT_NEAR(shank.inertia(0, 0), shank.mass * (4e-4 / 4 + 0.01 / 12), 1e-12);
  EXPECT_NEAR(shank.com.z(), -0.1, 1e-12);
  EXPECT_THAT(files.Warnings(), Contains(HasSubstr("without mass: 5 of 13")));
  RobotFiles less = without("<box size=\"0.3 0.2 0.1\"/>"), bare = without(""), whole("a1");
  less.yaml += "mass_kg: 1\n";
  bare.yaml += "mass_kg: 10\n";
  whole.yaml += "mass_kg: 20\n";
  EXPECT_TRUE(Refused(less, "1 kg", "give more"));
  EXPECT_TRUE(Refused(bare, "'trunk'", "<collision>"));
  EXPECT_TRUE(Refused(without(""), "<collision>", "--mass"));
  EXPECT_TRUE(Refused(whole, "take it out"));
}

// Links that only mark a frame: impossible inertias are corrected, inertias without mass ignored, each with a
// warning.
TEST(QuadrupedDescriptionTest, CorrectsTheInertiaOfFrames) {
  const auto with_frame = [](const std::string& inertial) {
    RobotFiles files("a1");
    files.Change(&RobotFiles::urdf, "</robot>",
                 "<link name=\"imu\">" + inertial +
                     "</link><joint name=\"imu_joint\" type=\"fixed\"><parent link=\"trunk\"/><child "
                     "link=\"imu\"/></joint>"
                     "</robot>");
    return files;
  };
  EXPECT_TRUE(RobotFiles("a1").Warnings().empty());
  const double trunk = LoadQuadruped(kRobots + "/a1.yaml").trunk.inertia(0, 0);

  const RobotFiles negative = with_frame(
      "<inertial><mass value=\"0.001\"/><inertia ixx=\"-1\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" "
      "izz=\"0\"/></inertial>");
  EXPECT_NEAR(negative.Load().trunk.inertia(0, 0), trunk, 1e-6);
  ASSERT_EQ(negative.Warnings().size(), 1u);
  EXPECT_THAT(negative.Warnings()[0], HasSubstrs("a1.urdf:", "link 'imu'"));
  const RobotFiles massless = with_frame(
      "<inertial><mass value=\"0\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" "
      "izz=\"1\"/></inertial>");
  EXPECT_NEAR(massless.Load().trunk.inertia(0, 0), trunk, 1e-15);
  EXPECT_THAT(massless.Warnings()[0], HasSubstr("link 'imu'"));
  // The nearest: 1, 2 and 4e-6 kg m^2 have second moments of 2.5, 1.5 and -0.5, and without the last 1.5, 2.5
  // and 4.
  const RobotFiles flat = with_frame(
      "<inertial><mass value=\"0.001\"/><inertia ixx=\"1e-6\" ixy=\"0\" ixz=\"0\" iyy=\"2e-6\" iyz=\"0\" "
      "izz=\"4e-6\"/></inertial>");
  EXPECT_THAT(flat.Warnings()[0], HasSubstr("1.5e-06, 2.5e-06, 4e-06 kg m^2"));
}

// So has the main link of a body, with a warning.
TEST(QuadrupedDescriptionTest, CorrectsTheInertiaOfBodies) {
  RobotFiles zero("dogbot");
  zero.Change(&RobotFiles::urdf,
              "ixx=\"0.00509\" ixy=\"0\" ixz=\"0\" iyy=\"0.00527\" iyz=\"0\" izz=\"0.0008\"",
              "ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"");
  EXPECT_THAT(zero.Warnings()[0], HasSubstr("link 'front_left_lower_leg'"));
  EXPECT_GT(zero.Load().legs[0].bodies[2].inertia(0, 0), 0);
  RobotFiles wrong("dogbot");
  wrong.Change(&RobotFiles::urdf, "ixx=\"0.091\"", "ixx=\"1.91\"");
  EXPECT_THAT(wrong.Warnings()[0], HasSubstrs("dogbot.urdf:", "link 'body'"));
  CheckInertia(wrong.Load().trunk.inertia);
}

TEST(QuadrupedDescriptionTest, TheYamlGivesLimitsThatTheUrdfLacks) {
  RobotFiles files("a1");
  files.Change(&RobotFiles::urdf,
               "<limit lower=\"-0.8029\" upper=\"0.8029\" effort=\"33.5\" velocity=\"21\"/>", "");
  EXPECT_TRUE(Refused(files, "a1.urdf:", "'FL_hip_joint'", "joint_limits.abduction"));
  files.yaml += "joint_limits:\n  abduction: {torque_N_m: 30, speed_rad_per_s: 20, range_rad: [-1, 1]}\n";
  const QuadrupedDescription robot = files.Load();
  EXPECT_EQ(robot.joint(0).torque_limit, 30);
  EXPECT_EQ(robot.joint(0).lower, -1);
  EXPECT_EQ(robot.joint(1).torque_limit, 33.5);
  files.Change(&RobotFiles::yaml, "[-1, 1]", "[1, -1]");
  EXPECT_TRUE(Refused(files, "a1.yaml", "range_rad"));
}

TEST(QuadrupedDescriptionTest, LockedJointsAreFixed) {
  RobotFiles files("a1");
  // A wheel below each foot would be a fourth joint.
  files.Change(
      &RobotFiles::urdf, "</robot>",
      "<link name=\"wheel\"/><joint name=\"wheel_joint\" type=\"continuous\"><parent link=\"FL_foot\"/>"
      "<child link=\"wheel\"/><origin xyz=\"0.1 0 0\"/><axis xyz=\"0 1 0\"/></joint>"
      "<link name=\"tip\"/><joint name=\"tip_joint\" type=\"fixed\"><parent link=\"wheel\"/>"
      "<child link=\"tip\"/><origin xyz=\"0 0 -0.1\"/></joint></robot>");
  files.Change(&RobotFiles::yaml, "front_left: FL_foot", "front_left: tip");
  EXPECT_TRUE(Refused(files, "front_left", "'wheel_joint'", "'locked_joints'"));
  files.yaml += "locked_joints: [{joint: wheel_joint, angle_rad: 1.5707963267948966}]\n";
  EXPECT_THAT(files.Load().legs[0].foot_J, IsNear(Eigen::Vector3d(0.1 - 0.1, 0, -0.2), 1e-12));
  files.Change(&RobotFiles::yaml, "joint: wheel_joint", "joint: wheel_joitn");
  EXPECT_TRUE(Refused(files, "'wheel_joitn'", "'wheel_joint'"));
}

// Joints of an arm under `actuated_joints`. The tests of attached bodies test how it moves.
TEST(QuadrupedDescriptionTest, RefusesActuatedJointsThatMakeNoSense) {
  const auto with = [](const std::string& joints) {
    RobotFiles files("aliengo");
    files.urdf = test::WithArm(files.urdf);
    files.yaml += "locked_joints: [{joint: arm_yaw, angle_rad: 0}, {joint: arm_pitch, angle_rad: 0}]\n" +
                  ("actuated_joints: [" + joints + "]\n");
    return files;
  };
  const std::string gains = "stiffness_N_m_per_rad: 50, damping_N_m_s_per_rad: 1",
                    elbow = "{joint: arm_elbow, angle_rad: 1.5, " + gains;
  EXPECT_NEAR(with(elbow + "}").Load().mass(), LoadQuadruped(kRobots + "/aliengo.yaml").mass() + 2.9, 1e-12);
  EXPECT_TRUE(Refused(with(""), "'arm_elbow'", "'actuated_joints'"));
  EXPECT_TRUE(
      Refused(with("{joint: arm_elbo, " + gains + "}"), "'arm_elbo'", "'arm_elbow'", "'actuated_joints'"));
  EXPECT_TRUE(Refused(with("{joint: gripper_mount, " + gains + "}"), "aliengo.urdf:", "'gripper_mount'",
                      "'actuated_joints'"));
  EXPECT_TRUE(
      Refused(with(elbow + "}, " + elbow + "}"), "aliengo.yaml:", "actuated_joints.1.joint", "'arm_elbow'"));
  EXPECT_TRUE(Refused(with("{joint: arm_yaw, " + gains + "}"), "actuated_joints.0.joint", "'arm_yaw'",
                      "'locked_joints'"));
  EXPECT_TRUE(
      Refused(with(elbow + ", amplitude_rad: 0.6, period_s: 1}"), "'arm_elbow'", "amplitude_rad", "2 rad"));
  const std::string downwards = ", amplitude_rad: 0.6, period_s: 1, phase_rad: 1.5707963267948966}";
  EXPECT_NO_THROW(with(elbow + downwards).Load());
  EXPECT_TRUE(Refused(with(elbow + ", amplitude_rad: 1.8, period_s: 1, phase_rad: 1.5707963267948966}"),
                      "'arm_elbow'", "phase_rad", "-2 to 2 rad"));
  EXPECT_TRUE(Refused(with(elbow + ", amplitude_rad: 0.3}"), "actuated_joints.0", "period_s"));
  EXPECT_TRUE(Refused(with("{joint: arm_elbow, stiffness_N_m_per_rad: -1, damping_N_m_s_per_rad: 1}"),
                      "actuated_joints.0.stiffness_N_m_per_rad"));
  EXPECT_TRUE(Refused(with("{joint: arm_elbow, stiffness_N_m_per_rad: 1, damping_N_m_s_per_rad: -1}"),
                      "actuated_joints.0.damping_N_m_s_per_rad"));
  for (const std::string joint : {"front_left_knee", "tail"}) {
    RobotFiles files = with(elbow + "}, {joint: " + joint + ", " + gains + "}");
    files.Change(
        &RobotFiles::urdf, "</robot>",
        "<link name=\"tip\"/><joint name=\"tail\" type=\"continuous\"><parent link=\"front_left_foot\"/>"
        "<child link=\"tip\"/><axis xyz=\"0 1 0\"/></joint></robot>");
    EXPECT_TRUE(Refused(files, "aliengo.urdf:", "'" + joint + "'", "'actuated_joints'"));
  }
  RobotFiles files = with(elbow + "}");
  files.Change(&RobotFiles::urdf, "0 1 -0.2\"/><limit effort=\"40\"", "0 1 -0.2\"/><limit effort=\"0\"");
  EXPECT_TRUE(Refused(files, "aliengo.urdf:", "'arm_elbow'", "effort"));
}

// First moment and inertia about B's origin are additive.
TEST(WithPayloadTest, AddsMassAndInertiaAboutTheTrunksOrigin) {
  const QuadrupedDescription robot = test::DogBot();
  RigidInertia payload{.mass = 4, .com = {0.1, -0.2, 0.15}};
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

TEST(QuadrupedDescriptionTest, RefusesImpossiblePayloadsAndMassFactors) {
  const RigidInertia payload{.mass = -1};
  EXPECT_TRUE(Throws<ParameterError>([&] { WithPayload(test::DogBot(), payload); }, "payload"));
  EXPECT_TRUE(Throws<ParameterError>([] { WithMassFactor(test::DogBot(), 0); }, "factor"));
}

}  // namespace tenon::quadruped_description_test
