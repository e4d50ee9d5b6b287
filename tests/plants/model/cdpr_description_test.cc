#include <tenon/plants/model/cdpr_description.h>
#include <tenon/plants/robots/load_robot.h>
#include <tenon/systems/yaml/resources.h>
#include <tenon/systems/yaml/yaml.h>
#include <tenon/tests/plants/model/cdpr_test_robots.h>
#include <tenon/tests/testing/block_test.h>

#include <Eigen/Dense>

#include <algorithm>

namespace tenon::cdpr_description_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::StartsWith;

const std::string kRobots = TENON_ROBOTS_DIR;

CdprDescription Robot() {
  return LoadCdpr(kRobots + "/cdpr_4.yaml");
}

template <class Change>
std::string ErrorAfter(Change&& change) {
  CdprDescription robot = Robot();
  change(robot);
  try {
    robot.Validate();
  } catch (const ParameterError& error) {
    return error.what();
  }
  return "no error";
}

/// One choice of tensions that carries the platform at rest and level at `p_WB`: the one nearest to `middle`
/// on all cables. Empty if the cables cannot carry it at all.
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

class RobotFileTest : public ::testing::TestWithParam<int> {};

TEST_P(RobotFileTest, LoadsAndComesBackFromItsText) {
  const int n = GetParam();
  const auto robot = LoadCdpr(kRobots + "/cdpr_" + std::to_string(n) + ".yaml");
  EXPECT_EQ(robot.num_cables(), n);
  EXPECT_EQ(robot.name, "cdpr_" + std::to_string(n));
  EXPECT_EQ(robot.mass, 15);
  EXPECT_EQ(robot.winch.mode, WinchMode::kTension);
  const auto again = YamlDocument::Parse(WriteYaml(robot), "again").Read<CdprDescription>();
  EXPECT_EQ(again.inertia_B, robot.inertia_B);
  EXPECT_EQ(again.cables[n - 1].anchor_W, robot.cables[n - 1].anchor_W);
  EXPECT_EQ(WriteYaml(again), WriteYaml(robot));
}

TEST_P(RobotFileTest, CarriesItsWeightWithinTheLimits) {
  const auto robot = LoadCdpr(kRobots + "/cdpr_" + std::to_string(GetParam()) + ".yaml");
  for (const double z : {1.0, 1.5, 2.0}) {
    const Eigen::VectorXd tensions = TensionsAt(robot, {0, 0, z}, GetParam() == 8 ? 200 : 0);
    ASSERT_EQ(tensions.size(), robot.num_cables()) << "at z = " << z;
    EXPECT_GT(tensions.minCoeff(), robot.cable.tension_min);
    EXPECT_LT(tensions.maxCoeff(), robot.cable.tension_max);
  }
}

INSTANTIATE_TEST_SUITE_P(All, RobotFileTest, ::testing::Values(4, 6, 8));

struct Published {
  const char* name;
  int num_cables;
  double middle;   ///< tensions near this one are looked for [N]
  double frame_x;  ///< from the first to the last anchor [m]
};

class PublishedRobotTest : public ::testing::TestWithParam<Published> {};

TEST_P(PublishedRobotTest, CarriesItsWeightWithinTheLimits) {
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
}

INSTANTIATE_TEST_SUITE_P(All, PublishedRobotTest,
                         ::testing::Values(Published{"cogiro", 8, 300, 14.98},
                                           Published{"ipanema_3", 8, 800, 16.77},
                                           Published{"c4", 12, 400, 10}));

// Both cables of a lower pair of C4 are parallel wherever the level platform is, which is what holds it
// level.
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

TEST(CdprDescriptionTest, ErrorsOfAFileNameItsLine) {
  auto document = YamlDocument::Load(kRobots + "/cdpr_4.yaml");
  document.Set("winch.mode", "velocity");
  EXPECT_THROW(
      {
        try {
          document.Read<CdprDescription>();
        } catch (const ParameterError& error) {
          EXPECT_THAT(error.what(),
                      StartsWith("--set winch.mode=velocity: winch.mode: expected one of tension, torque"));
          throw;
        }
      },
      ParameterError);
  document.Set("winch.mode", "tension");
  document.Set("mass_kg", "-1");
  try {
    document.Read<CdprDescription>();
    FAIL();
  } catch (const ParameterError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("--set mass_kg=-1: mass_kg: mass is -1 kg"),
                                    HasSubstr("(with --set winch.mode=tension)")));
  }
}

TEST(CdprDescriptionTest, Mass) {
  for (const double mass : {0.0, -2.0, NAN})
    EXPECT_THAT(ErrorAfter([&](auto& robot) { robot.mass = mass; }),
                AllOf(HasSubstr("mass is"), HasSubstr("kg but must be positive; give mass_kg above 0")));
}

TEST(CdprDescriptionTest, Inertia) {
  EXPECT_THAT(ErrorAfter([](auto& robot) { robot.inertia_B(0, 2) = 0.01; }),
              AllOf(HasSubstr("not symmetric: row 0 column 2 is 0.01 kg m^2, row 2 column 0 is 0 kg m^2"),
                    HasSubstr("give both the same value")));
  EXPECT_THAT(
      ErrorAfter([](auto& robot) { robot.inertia_B(1, 1) = -0.1; }),
      AllOf(HasSubstr("not positive definite: its principal moments are -0.1,"), HasSubstr("kg m^2")));
  EXPECT_THAT(ErrorAfter([](auto& robot) { robot.inertia_B.diagonal() << 1, 2, 3.5; }),
              AllOf(HasSubstr("inertia of no rigid body: its principal moments are 1, 2, 3.5 kg m^2"),
                    HasSubstr("above the sum of the other two")));
  EXPECT_THAT(ErrorAfter([](auto& robot) { robot.inertia_B(0, 0) = INFINITY; }),
              HasSubstr("inertia has entries that are not finite"));
  EXPECT_EQ(ErrorAfter([](auto& robot) { robot.inertia_B.diagonal() << 1, 2, 3; }), "no error")
      << "a flat plate";
}

TEST(CdprDescriptionTest, Cables) {
  EXPECT_THAT(ErrorAfter([](auto& robot) { robot.cables.pop_back(); }),
              HasSubstr("cables has 3 entries but must have at least 4; add cables"));
  EXPECT_THAT(ErrorAfter([](auto& robot) { robot.cables[2] = robot.cables[1]; }),
              AllOf(HasSubstr("cables.1 and 2 both run from anchor (-3.5, 4.5, 4) m to attachment"),
                    HasSubstr("move or remove one")));
  EXPECT_THAT(ErrorAfter([](auto& robot) { robot.cables[3].attachment_B = robot.cables[3].anchor_W; }),
              AllOf(HasSubstr("cables.3 has zero length: anchor and attachment are both (3.5, -4.5, 4) m"),
                    HasSubstr("from the platform's CoM")));
  EXPECT_THAT(ErrorAfter([](auto& robot) { robot.cables[0].anchor_W[1] = NAN; }),
              HasSubstr("cables.0 has a coordinate that is not finite"));
}

TEST(CdprDescriptionTest, CableProperties) {
  EXPECT_THAT(ErrorAfter([](auto& robot) { robot.cable.axial_stiffness = 0; }),
              HasSubstr("axial_stiffness is 0 N but must be positive; give EA"));
  EXPECT_THAT(ErrorAfter([](auto& robot) { robot.cable.axial_damping = -1; }),
              HasSubstr("axial_damping is -1 N s but must not be negative; give EA times"));
  EXPECT_THAT(ErrorAfter([](auto& robot) { robot.cable.tension_min = -5; }),
              HasSubstr("tension_min is -5 N but must not be negative; a cable cannot push"));
  EXPECT_THAT(ErrorAfter([](auto& robot) { robot.cable.tension_min = 800; }),
              HasSubstr("tension_min = 800 N must be below tension_max = 800 N; raise tension_max_N"));
}

TEST(CdprDescriptionTest, Winch) {
  EXPECT_THAT(ErrorAfter([](auto& robot) { robot.winch.time_constant = 0; }),
              HasSubstr("time_constant is 0 s but must be positive; give the lag"));
  EXPECT_THAT(ErrorAfter([](auto& robot) { robot.winch.reel_damping = 0; }),
              AllOf(HasSubstr("reel_damping is 0 N s/m but must be positive; in mode 'tension'"),
                    HasSubstr("bandwidth")));
  EXPECT_THAT(ErrorAfter([](auto& robot) { robot.winch.effective_mass = -1; }),
              HasSubstr("effective_mass is -1 kg but must not be negative"));
  EXPECT_THAT(ErrorAfter([](auto& robot) {
                robot.winch.mode = WinchMode::kTorque;
                robot.winch.reel_damping = -1;
              }),
              HasSubstr("reel_damping is -1 N s/m but must not be negative; give the friction"));
  EXPECT_THAT(ErrorAfter([](auto& robot) {
                robot.winch.mode = WinchMode::kTorque;
                robot.winch.effective_mass = 0;
              }),
              HasSubstr("effective_mass is 0 kg but must be positive; mode 'torque' needs"));
}

TEST(CdprDescriptionTest, WhatOnlyThePlantKnowsIsReadAndWritten) {
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

TEST(CdprDescriptionTest, ARobotIsReadWithWhatDiffers) {
  const CdprDescription robot = LoadCdpr(YamlFile{"{file: cdpr_4, cable_properties: {mass_kg_per_m: 0.05}}"});
  EXPECT_EQ(robot.cable.mass_per_length, 0.05);
  EXPECT_EQ(robot.cable.axial_stiffness, Robot().cable.axial_stiffness);
  EXPECT_EQ(WriteYaml(LoadCdpr(YamlFile{"cdpr_4"})), WriteYaml(Robot()));
}

TEST(CdprDescriptionTest, WinchesAndCablesThatCannotBeAreRefused) {
  const auto with_drum = [](double DrumProperties::*member, double value) {
    return ErrorAfter([&](CdprDescription& robot) {
      robot.winch.drum = DrumProperties{0.036, 0.005, 10, 9};
      (*robot.winch.drum).*member = value;
    });
  };
  const auto with_pairs = [](std::vector<std::array<int, 2>> pairs, double limit = 100) {
    return ErrorAfter([&](CdprDescription& robot) {
      robot.winch.differential = DifferentialProperties{std::move(pairs), limit};
    });
  };
  EXPECT_THAT(ErrorAfter([](auto& robot) { robot.cable.mass_per_length = -1; }),
              AllOf(HasSubstr("mass_kg_per_m is -1 kg/m"), HasSubstr("must not be negative")));
  EXPECT_THAT(ErrorAfter([](auto& robot) { robot.winch.pulley_radius = -0.04; }),
              AllOf(HasSubstr("pulley_radius is -0.04 m"), HasSubstr("must not be negative")));
  EXPECT_THAT(with_drum(&DrumProperties::radius, 0), HasSubstr("radius is 0 m"));
  EXPECT_THAT(with_drum(&DrumProperties::cable_diameter, -1), HasSubstr("cable_diameter is -1 m"));
  EXPECT_THAT(with_drum(&DrumProperties::turns_per_layer, 0), HasSubstr("turns_per_layer is 0"));
  EXPECT_THAT(with_drum(&DrumProperties::cable_length, 0), HasSubstr("cable_length is 0 m"));
  EXPECT_EQ(with_pairs({{0, 1}, {3, 2}}), "no error");
  EXPECT_THAT(with_pairs({{0, 1}, {2, 1}}), AllOf(HasSubstr("[2, 1]"), HasSubstr("already in a pair")));
  EXPECT_THAT(with_pairs({{0, 0}}), HasSubstr("names cable 0, which is already in a pair"));
  EXPECT_THAT(with_pairs({{0, -1}}), HasSubstr("names cable -1, which is none"));
  EXPECT_THAT(with_pairs({{0, 4}}), AllOf(HasSubstr("names cable 4, but there are 4"), HasSubstr("0 to 3")));
  EXPECT_THAT(with_pairs({{0, 1}}, 0), HasSubstr("motor_tension_max is 0 N"));
}

}  // namespace
}  // namespace tenon::cdpr_description_test
