#include <tenon/plants/model/path.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/systems/yaml/yaml.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Dense>

namespace tenon::cdpr_description_test {

const std::string kRobots = TENON_ROBOTS_DIR;

CdprDescription Robot() {
  return LoadCdpr(kRobots + "/cdpr_4.yaml");
}

/// Whether the default robot is refused after a change, with a message that names all the keys.
template <class Change, class... Keys>
::testing::AssertionResult RefusedAfter(const Change& change, const Keys&... keys) {
  CdprDescription robot = Robot();
  change(robot);
  return Throws<ParameterError>([&] { robot.Validate(); }, keys...);
}

/// The tensions nearest to `middle` on all cables that carry the platform at rest and level at `p_WB`. Empty
/// if the cables cannot carry it.
Eigen::VectorXd TensionsAt(const CdprDescription& robot, const Eigen::Vector3d& p_WB, double middle) {
  Eigen::MatrixXd structure(6, robot.num_cables());
  for (int i = 0; i < robot.num_cables(); ++i) {
    const Eigen::Vector3d& arm = robot.cables[i].attachment_B;
    const Eigen::Vector3d direction = (robot.cables[i].anchor_W - p_WB - arm).normalized();
    structure.col(i) << direction, arm.cross(direction);
  }
  Eigen::VectorXd wrench = Eigen::VectorXd::Zero(6);
  wrench[2] = robot.mass * 9.81;
  Eigen::VectorXd tensions = Eigen::VectorXd::Constant(robot.num_cables(), middle);
  tensions += structure.completeOrthogonalDecomposition().solve(wrench - structure * tensions);
  return (structure * tensions - wrench).norm() < 1e-6 ? tensions : Eigen::VectorXd();
}

struct RobotFile {
  const char* name;
  int num_cables;
  double middle;   ///< the tensions are the nearest to this one [N]
  double frame_x;  ///< from the first to the last anchor [m]
};

class RobotFileTest : public ::testing::TestWithParam<RobotFile> {};
INSTANTIATE_TEST_SUITE_P(All, RobotFileTest,
                         ::testing::Values(RobotFile{"cdpr_4", 4, 0, 7}, RobotFile{"cdpr_6", 6, 0, 6.928},
                                           RobotFile{"cdpr_8", 8, 200, 7}, RobotFile{"cogiro", 8, 300, 14.98},
                                           RobotFile{"ipanema_3", 8, 800, 16.77},
                                           RobotFile{"c4", 12, 400, 10}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST_P(RobotFileTest, CarriesItsWeightWithinTheLimitsAndComesBackFromItsText) {
  const auto [name, num_cables, middle, frame_x] = GetParam();
  const auto robot = LoadCdpr(kRobots + "/" + name + ".yaml");
  EXPECT_EQ(robot.name, name);
  ASSERT_EQ(robot.num_cables(), num_cables);
  const auto by_x = [](const CableDescription& a, const CableDescription& b) {
    return a.anchor_W.x() < b.anchor_W.x();
  };
  const auto [low, high] = std::minmax_element(robot.cables.begin(), robot.cables.end(), by_x);
  EXPECT_NEAR(high->anchor_W.x() - low->anchor_W.x(), frame_x, 0.01);
  for (const double z : {1.0, 1.5, 2.0}) {
    const Eigen::VectorXd tensions = TensionsAt(robot, {0, 0, z}, middle);
    ASSERT_EQ(tensions.size(), num_cables) << "at z = " << z;
    EXPECT_GT(tensions.minCoeff(), robot.cable.tension_min) << "at z = " << z;
    EXPECT_LT(tensions.maxCoeff(), robot.cable.tension_max) << "at z = " << z;
  }
  const auto again = YamlDocument::Parse(WriteYaml(robot), "again").Read<CdprDescription>();
  EXPECT_EQ(again.inertia_B, robot.inertia_B);
  EXPECT_EQ(again.cables.back().anchor_W, robot.cables.back().anchor_W);
  EXPECT_EQ(WriteYaml(again), WriteYaml(robot));
}

// Both cables of each lower pair of C4 are parallel at every position, which keeps the platform level.
TEST(CdprDescriptionTest, PairsOfC4AreParallel) {
  const auto robot = LoadCdpr(kRobots + "/c4.yaml");
  for (int i = 4; i < 12; i += 2) {
    const auto span = [&](int k) -> Eigen::Vector3d {
      return robot.cables[k].anchor_W - robot.cables[k].attachment_B;
    };
    EXPECT_LT((span(i) - span(i + 1)).norm(), 1e-12) << "cables " << i << " and " << i + 1;
  }
}

TEST(CdprDescriptionTest, AnyNumberOfCablesIsReadFromText) {
  for (const int n : {4, 12, 16, 40}) {
    const CdprDescription robot = test::RobotWithCables(n);
    const auto read = YamlDocument::Parse(WriteYaml(robot), "rings").Read<CdprDescription>();
    ASSERT_EQ(read.num_cables(), n);
    EXPECT_EQ(read.cables.back().anchor_W, robot.cables.back().anchor_W);
    EXPECT_NO_THROW(read.Validate());
  }
}

TEST(CdprDescriptionTest, TheSixCableFileStatesItsTension) {
  const auto tensions = TensionsAt(LoadCdpr(kRobots + "/cdpr_6.yaml"), {0, 0, 1.5}, 0);
  EXPECT_NEAR(tensions.minCoeff(), 46, 0.5);
  EXPECT_NEAR(tensions.maxCoeff(), 46, 0.5);
}

TEST(CdprDescriptionTest, NumbersOfTheDefaultRobot) {
  const CdprDescription robot = Robot();
  EXPECT_EQ(robot.cables[1].anchor_W, Eigen::Vector3d(-3.5, 4.5, 4));
  EXPECT_EQ(robot.cables[1].attachment_B, Eigen::Vector3d(-0.075, 0.075, 0.093));
  EXPECT_NEAR(robot.inertia_B(0, 0), 0.184 * 15 / 12.99, 5e-5);
  EXPECT_EQ(robot.inertia_B(0, 1), 0);
  EXPECT_NEAR(robot.cable.axial_damping / robot.cable.axial_stiffness, 0.005, 1e-12);
  EXPECT_NEAR(robot.cable.axial_stiffness / 5 / robot.winch.reel_damping, 60, 1e-9);
  EXPECT_NEAR(robot.winch.effective_mass, 2.6e-5 * 20 * 20 / (0.036 * 0.036), 0.005);
}

TEST(CdprDescriptionTest, ErrorsNameTheirPlace) {
  auto document = YamlDocument::Load(kRobots + "/cdpr_4.yaml");
  const auto read = [&] { document.Read<CdprDescription>(); };
  document.Set("winch.mode", "velocity");
  EXPECT_TRUE(Throws<ParameterError>(read, "--set winch.mode=velocity: winch.mode", "tension", "torque"));
  document.Set("winch.mode", "tension");
  document.Set("mass_kg", "-1");
  EXPECT_TRUE(Throws<ParameterError>(read, "--set mass_kg=-1: mass_kg", "--set winch.mode=tension"));
}

TEST(CdprDescriptionTest, RefusesImpossibleNumbers) {
  struct Case {
    std::function<void(CdprDescription&)> change;
    const char* key;
  };
  const auto torque_mode = [](double WinchProperties::*member, double value) {
    return [=](CdprDescription& robot) {
      robot.winch.mode = WinchMode::kTorque;
      robot.winch.*member = value;
    };
  };
  const auto drum = [](double DrumProperties::*member, double value) {
    return [=](CdprDescription& robot) {
      robot.winch.drum = DrumProperties{0.036, 0.005, 10, 9};
      (*robot.winch.drum).*member = value;
    };
  };
  const auto pairs = [](std::vector<std::array<int, 2>> pairs, double limit = 100) {
    return [=](CdprDescription& robot) { robot.winch.differential = DifferentialProperties{pairs, limit}; };
  };
  const auto anchors = [](std::vector<double> times, std::vector<Eigen::Vector3d> offsets) {
    return [=](CdprDescription& robot) { robot.cables[1].anchor_path = AnchorPath{times, offsets}; };
  };
  const Case cases[] = {
      {[](auto& robot) { robot.mass = 0; }, "mass_kg"},
      {[](auto& robot) { robot.mass = -2; }, "mass_kg"},
      {[](auto& robot) { robot.mass = NAN; }, "mass_kg"},
      {[](auto& robot) { robot.inertia_B(0, 2) = 0.01; }, "row 0 column 2"},
      {[](auto& robot) { robot.inertia_B(1, 1) = -0.1; }, "principal moments are -0.1,"},
      {[](auto& robot) { robot.inertia_B.diagonal() << 1, 2, 3.5; }, "1, 2, 3.5 kg m^2"},
      {[](auto& robot) { robot.inertia_B(0, 0) = INFINITY; }, "inertia"},
      {[](auto& robot) { robot.cables.resize(1); }, "cables"},
      {[](auto& robot) { robot.cables[2] = robot.cables[1]; }, "cables.1 and 2"},
      {[](auto& robot) { robot.cables[0].anchor_W[1] = NAN; }, "cables.0"},
      {anchors({0, 1}, {{0, 0, 0}}), "cables.1.anchor_path.times_s has 2 entries and offsets_m has 1"},
      {anchors({1}, {{0, 0, 0}}), "two or more"},
      {anchors({-1, 1}, {{0, 0, 0}, {1, 0, 0}}), "cables.1.anchor_path.times_s.0"},
      {anchors({2, 2}, {{0, 0, 0}, {1, 0, 0}}), "cables.1.anchor_path.times_s.1 = 2"},
      {anchors({0, NAN}, {{0, 0, 0}, {1, 0, 0}}), "cables.1.anchor_path.times_s.1"},
      {anchors({0, 1}, {{0, 0, 0}, {1, NAN, 0}}), "cables.1.anchor_path.offsets_m.1"},
      {anchors({0, 1}, {{0, 0, 0}, {1, 2e4, 0}}), "cables.1.anchor_path.offsets_m.1"},
      {anchors({0, 1}, {{0, 0, 1}, {1, 0, 0}}), "cables.1.anchor_path.offsets_m.0"},
      {[](auto& robot) { robot.cable.axial_stiffness = 0; }, "axial_stiffness"},
      {[](auto& robot) { robot.cable.axial_damping = -1; }, "axial_damping"},
      {[](auto& robot) { robot.cable.tension_min = -5; }, "tension_min"},
      {[](auto& robot) { robot.cable.tension_min = 800; }, "tension_max"},
      {[](auto& robot) { robot.cables[2].tension_min = 800; }, "cables.2"},
      {[](auto& robot) { robot.cables[3].tension_min = -5; }, "tension_min"},
      {[](auto& robot) { robot.cable.mass_per_length = -1; }, "mass_kg_per_m"},
      {[](auto& robot) { robot.on_table = true; }, "on_table"},
      {[](auto& robot) { robot.winch.time_constant = 0; }, "time_constant"},
      {[](auto& robot) { robot.winch.reel_damping = 0; }, "reel_damping"},
      {[](auto& robot) { robot.winch.effective_mass = -1; }, "effective_mass"},
      {[](auto& robot) { robot.winch.pulley_radius = -0.04; }, "pulley_radius"},
      {torque_mode(&WinchProperties::reel_damping, -1), "reel_damping"},
      {torque_mode(&WinchProperties::effective_mass, 0), "effective_mass"},
      {drum(&DrumProperties::radius, 0), "radius"},
      {drum(&DrumProperties::cable_diameter, -1), "cable_diameter"},
      {drum(&DrumProperties::turns_per_layer, 0), "turns_per_layer"},
      {drum(&DrumProperties::cable_length, 0), "cable_length"},
      {pairs({{0, 1}, {2, 1}}), "[2, 1]"},
      {pairs({{0, 0}}), "cable 0"},
      {pairs({{0, -1}}), "cable -1"},
      {pairs({{0, 4}}), "cable 4"},
      {pairs({{0, 1}}, 0), "motor_tension_max"}};
  for (const auto& [change, key] : cases) EXPECT_TRUE(RefusedAfter(change, key)) << key;
}

TEST(CdprDescriptionTest, AcceptsAFlatPlateAndPairsInAnyOrder) {
  CdprDescription robot = Robot();
  robot.inertia_B.diagonal() << 1, 2, 3;
  robot.winch.differential = DifferentialProperties{{{0, 1}, {3, 2}}, 100};
  EXPECT_NO_THROW(robot.Validate());
}

TEST(CdprDescriptionTest, PropertiesOfThePlantAreReadAndWritten) {
  auto document = YamlDocument::Load(kRobots + "/cdpr_4.yaml");
  EXPECT_EQ(document.Read<CdprDescription>().cable.mass_per_length, 0);
  document.Set("cable_properties.mass_kg_per_m", "0.05");
  document.Set("winch.pulley_radius_m", "0.04");
  document.Set("winch.drum",
               "{radius_m: 0.036, cable_diameter_m: 0.005, turns_per_layer: 10, cable_length_m: 9}");
  document.Set("winch.differential", "{pairs: [[0, 1], [2, 3]], motor_tension_max_N: 400}");
  const auto robot = document.Read<CdprDescription>();
  EXPECT_EQ(robot.cable.mass_per_length, 0.05);
  EXPECT_EQ(robot.winch.pulley_radius, 0.04);
  EXPECT_EQ(robot.winch.drum->cable_length, 9);
  EXPECT_EQ(robot.winch.differential->pairs[1][0], 2);
  EXPECT_EQ(WriteYaml(YamlDocument::Parse(WriteYaml(robot), "again").Read<CdprDescription>()),
            WriteYaml(robot));
}

TEST(CdprDescriptionTest, ACableMayHaveLimitsOfItsOwn) {
  auto document = YamlDocument::Load(kRobots + "/cdpr_4.yaml");
  document.Set("cables.1.tension_max_N", "300");
  document.Set("cables.2.tension_min_N", "5");
  document.Set("cables.3.pulley_radius_m", "0.03");
  const auto robot = document.Read<CdprDescription>();
  EXPECT_EQ(robot.tension_max(), (CableVector{{800, 300, 800, 800}}));
  EXPECT_EQ(robot.tension_min(), (CableVector{{0, 0, 5, 0}}));
  EXPECT_EQ(robot.pulley_radius(0), 0);
  EXPECT_EQ(robot.pulley_radius(3), 0.03);
  CableVector tension{{900, 900, 0, 100}};
  robot.LimitTension(&tension);
  EXPECT_EQ(tension, (CableVector{{800, 300, 5, 100}}));
}

TEST(CdprDescriptionTest, SpringsAreReadAndCheckedByKey) {
  auto document = YamlDocument::Load(kRobots + "/cdpr_4.yaml");
  document.Set("springs",
               "[{anchor_m: [0, 0, 5], attachment_m: [0, 0, 0.1], stiffness_N_per_m: 40, rest_length_m: 1}]");
  const auto robot = document.Read<CdprDescription>();
  EXPECT_EQ(robot.springs.at(0).stiffness, 40);
  EXPECT_EQ(robot.springs.at(0).attachment_B.z(), 0.1);
  document.Set("springs.0.stiffness_N_per_m", "-40");
  EXPECT_TRUE(Throws<Error>([&] { document.Read<CdprDescription>(); }, "springs.0.stiffness_N_per_m"));
}

TEST(CdprDescriptionTest, AnAnchorMayMove) {
  auto document = YamlDocument::Load(kRobots + "/cdpr_4.yaml");
  document.Set("cables.1.anchor_path",
               "{times_s: [1, 3, 4], offsets_m: [[0, 0, 0], [1, 0, 0.5], [1, 0, 0.5]]}");
  const auto robot = document.Read<CdprDescription>();
  const MovingAnchors anchors(robot);
  EXPECT_TRUE(anchors.any());
  EXPECT_EQ(anchors.start_time(), 1);
  EXPECT_EQ(anchors.end_time(), 4);
  EXPECT_EQ(anchors.At(0, 2).position.norm(), 0);
  EXPECT_THAT(anchors.At(1, 2).position, IsNear(Eigen::Vector3d(0.5, 0, 0.25), 1e-14));
  EXPECT_THAT(anchors.At(1, 2).velocity, IsNear(15.0 / 8 / 2 * Eigen::Vector3d(1, 0, 0.5), 1e-14));
  EXPECT_THAT(anchors.RobotAt(robot, 9).cables[1].anchor_W - robot.cables[1].anchor_W,
              IsNear(Eigen::Vector3d(1, 0, 0.5), 1e-14));
  EXPECT_FALSE(MovingAnchors(anchors.RobotAt(robot, 9)).any());
  EXPECT_FALSE(MovingAnchors(Robot()).any());
  EXPECT_EQ(MovingAnchors(Robot()).At(1, 2).velocity.norm(), 0);
}

TEST(CdprDescriptionTest, ARobotIsReadWithChanges) {
  const CdprDescription robot = LoadCdpr(YamlFile{"{file: cdpr_4, cable_properties: {mass_kg_per_m: 0.05}}"});
  EXPECT_EQ(robot.cable.mass_per_length, 0.05);
  EXPECT_EQ(robot.cable.axial_stiffness, Robot().cable.axial_stiffness);
  EXPECT_EQ(WriteYaml(LoadCdpr(YamlFile{"cdpr_4"})), WriteYaml(Robot()));
}

}  // namespace tenon::cdpr_description_test
