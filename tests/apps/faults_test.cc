// Every shipped case with every fault that is possible there: the run goes on, or ends with its reason, and
// what it writes is whole.

#include <tenon/tests/apps/run_app.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

namespace tenon::faults_test {
namespace {

using test::BadUsage;
using test::Column;
using test::Read;
using test::Result;
using test::RunCommand;
using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::HasSubstr;

const std::string kQuadruped = TENON_QUADRUPED, kGuideDog = TENON_GUIDE_DOG, kCdpr = TENON_CDPR;

struct FaultyCase {
  std::string app, scenario;
  std::vector<std::string> places;  ///< of signals
  std::string mechanical;           ///< faults of parts
  friend void PrintTo(const FaultyCase& faulty, std::ostream* out) { *out << faulty.scenario; }
};

const std::vector<std::string> kWalk{"torque", "torque_sensor", "foot_force", "imu", "state", "wrench"};
const std::vector<std::string> kMpc{"command", "lengths", "pose", "imu", "estimate"};
const std::vector<std::string> kPd{"command", "lengths", "reference"};
const std::string kJoints =
    "{at: joint, kind: stuck, elements: [front_left_hip_pitch], start_s: 0.05, duration_s: 0.1}, "
    "{at: joint, kind: stuck, elements: [front_right_knee], start_s: 0.1}, "
    "{at: joint, kind: broken, elements: [rear_right_abduction], start_s: 0.02, duration_s: 0.1}";
const std::string kCables =
    "{at: winch, kind: stuck, elements: [1], start_s: 0.05, duration_s: 0.05}, "
    "{at: winch, kind: stuck, elements: [2], start_s: 0.05}, "
    "{at: cable, kind: broken, elements: [0], start_s: 0.15}";

/// With what each kind needs. Sizes are as good or bad for newtons as for radians.
const std::vector<std::string> kKinds{"kind: drop_out",
                                      "kind: stuck",
                                      "kind: spike, size: 20, period_s: 0.005",
                                      "kind: offset, size: 0.5",
                                      "kind: loss, size: 0.5",
                                      "kind: late, samples: 5",
                                      "kind: lost, probability: 0.5"};

class FaultsTest : public test::AppTest, public ::testing::WithParamInterface<FaultyCase> {
 protected:
  /// 0.2 s of a case with faults. Returns the summary.
  nlohmann::json Run(const FaultyCase& faulty, const std::string& faults, const std::string& more = "") {
    const Result result = RunCommand(faulty.app + " " + faulty.scenario + " --duration 0.2 --set 'faults=[" +
                                     faults + "]' " + more + Out());
    exit_code = result.exit_code;
    EXPECT_THAT(exit_code, AnyOf(0, 3, 4)) << faulty.scenario << ", " << faults << ": " << result.text;
    const auto summary = nlohmann::json::parse(Read(out / "summary.json"));
    EXPECT_EQ(summary.at("finished").get<bool>(), exit_code == 0);
    EXPECT_NE(summary.at("end_reason"), "");
    EXPECT_EQ(summary.at("end_reason") == "end of the run", exit_code == 0) << summary.at("end_reason");
    EXPECT_THAT(Read(out / "report.html"), HasSubstr("</html>"));
    ExpectWholeRows(exit_code == 0 ? 0.2 : summary.at("simulated_s").get<double>());
    return summary;
  }
  void ExpectWholeRows(double end) const {
    const std::string text = Read(out / "signals.csv");
    ASSERT_TRUE(text.ends_with("\n"));
    std::istringstream file(text);
    std::string line;
    std::getline(file, line);
    const auto commas = std::count(line.begin(), line.end(), ',');
    double last = -1;
    for (; std::getline(file, line); last = std::stod(line))
      ASSERT_EQ(std::count(line.begin(), line.end(), ','), commas) << line;
    EXPECT_NEAR(last, end, 0.0101);  // logs have 100 Hz at least
  }

  int exit_code = -1;
};

// The kinds act one after the other, 20 ms each. Where one ends the run, those that are left get another.
TEST_P(FaultsTest, GoesOnOrSaysWhyNot) {
  const FaultyCase& faulty = GetParam();
  for (const std::string& place : faulty.places) {
    for (std::size_t done = 0; done < kKinds.size();) {
      std::string faults;
      double start = 0.02;
      for (std::size_t i = done; i < kKinds.size(); ++i, start += 0.025)
        faults += "{at: " + place + ", " + kKinds[i] + ", start_s: " + std::to_string(start) +
                  ", duration_s: 0.02}, ";
      const double end = Run(faulty, faults).at("simulated_s").get<double>();
      EXPECT_EQ(Column(out, "fault_0.acting").front(), 0) << place;
      if (end > 0.03) {  // logged there
        EXPECT_THAT(Column(out, "fault_0.acting"), Contains(1)) << place;
      }
      const std::size_t before = done;
      for (start = 0.02; done < kKinds.size() && start <= end + 1e-9; start += 0.025) ++done;
      ASSERT_GT(done, before) << place << ": ended before its fault";
    }
  }
  Run(faulty, faulty.mechanical);
  EXPECT_THAT(Column(out, "fault_0.acting"), Contains(1));
  const auto summary = Run(faulty, "{at: " + faulty.places[0] + ", kind: nan, start_s: 0.1}");
  EXPECT_EQ(exit_code, 4);
  EXPECT_THAT(summary.at("end_reason").get<std::string>(), HasSubstr("fault_0"));
}

FaultyCase Walks(const std::string& scenario) {
  return {kQuadruped, scenario, kWalk, kJoints};
}
FaultyCase Guides(const std::string& scenario) {
  return {kGuideDog, scenario, kWalk, kJoints};
}
std::string NameOf(const ::testing::TestParamInfo<FaultyCase>& info) {
  std::string name = info.param.scenario;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
  return name;
}
INSTANTIATE_TEST_SUITE_P(Cases, FaultsTest,
                         ::testing::Values(Walks("A1"), Walks("A2"), Walks("A3"), Walks("A4"),
                                           Walks("A5-plus"), Walks("A5-minus"), Walks("A6"), Walks("B1"),
                                           Walks("B2"), Walks("B3-plus"), Walks("B3-minus"), Guides("C1"),
                                           Guides("C2"), Guides("C3"), FaultyCase{kCdpr, "D1", kMpc, kCables},
                                           FaultyCase{kCdpr, "D2", kMpc, kCables},
                                           FaultyCase{kCdpr, "D1 --controller pd", kPd, kCables}),
                         NameOf);
INSTANTIATE_TEST_SUITE_P(
    Estimated, FaultsTest,
    ::testing::Values(FaultyCase{kQuadruped, "estimated", {"encoders", "imu", "state"}, kJoints},
                      FaultyCase{kQuadruped, "stand", {"encoders", "torque"}, kJoints}),
    NameOf);

class FaultTest : public FaultsTest {};

// At each place the error names the fault that made the NaN, not what it led to.
TEST_F(FaultTest, ANanIsReportedWhereItArises) {
  for (const FaultyCase& faulty :
       {FaultyCase{kQuadruped, "A1", kWalk, ""}, FaultyCase{kQuadruped, "estimated", {"encoders"}, ""},
        FaultyCase{kCdpr, "D1", kMpc, ""}, FaultyCase{kCdpr, "D1 --controller pd", kPd, ""}}) {
    for (const std::string& place : faulty.places) {
      const auto summary = Run(faulty, "{at: " + place + ", kind: nan, start_s: 0.02}");
      EXPECT_EQ(exit_code, 4) << place;
      EXPECT_THAT(summary.at("end_reason").get<std::string>(), HasSubstr("fault_0")) << place;
      EXPECT_NEAR(summary.at("simulated_s").get<double>(), 0.02, 1e-9) << place;
    }
  }
}

// Without sensors in the feet their forces come from the torques: who loses these loses contact as well.
TEST_F(FaultTest, OfTheTorqueSensorReachesTheForcesOfTheLegs) {
  Run({kQuadruped, "A1", {}, ""}, "{at: torque_sensor, kind: loss, size: 1, start_s: 0.1}",
      "--set sensors.foot_force.mounted=none");
  const std::vector<double> state = Column(out, "loop.locomotion.schedule.legs.front_left.state");
  EXPECT_EQ(state.front(), 0) << "stance";
  EXPECT_EQ(state.back(), 3) << "searching";
}

// Of the lengths themselves the estimate of the pose alone makes use.
TEST_F(FaultTest, OfLengthsReachesTheEstimate) {
  const auto command = [&](const std::string& faults) {
    Run({kCdpr, "D1", {}, ""}, faults);
    return Column(out, "loop.command.0 [N]").back();
  };
  EXPECT_NE(
      command("{at: lengths, kind: spike, size: 0.02, period_s: 0.05, elements: [length], start_s: 0.1}"),
      command(""));
}

// What is logged behind the fault is what its kind says, and what is logged before it goes on.
TEST_F(FaultTest, IsInTheSignals) {
  Run({kQuadruped, "A1", {}, ""},
      "{at: torque, kind: loss, size: 1, elements: [front_right_hip_pitch], start_s: 0.1, duration_s: 0.05}, "
      "{at: imu, kind: stuck, elements: [specific_force_B], start_s: 0.1}");
  EXPECT_EQ(exit_code, 0);
  const std::vector<double> time = Column(out, "time [s]"),
                            y = Column(out, "fault_0.y.front_right_hip_pitch [N m]"),
                            plant = Column(out, "loop.world.plant.joint_torque.front_right_hip_pitch [N m]"),
                            imu = Column(out, "fault_1.y.specific_force_B.z [m/s^2]"),
                            gyro = Column(out, "fault_1.y.angular_velocity_B.y [rad/s]");
  for (std::size_t i = 1; i < time.size(); ++i) {
    const bool acts = time[i] > 0.0999 && time[i] < 0.1499;
    EXPECT_EQ(y[i] == 0, acts) << time[i];
    EXPECT_EQ(plant[i] == 0, acts) << time[i];
    if (time[i] > 0.1001) {
      EXPECT_EQ(imu[i], imu[i - 1]) << time[i];
      EXPECT_NE(gyro[i], gyro[i - 1]) << time[i];
    }
  }
}

TEST_F(FaultTest, AGuideDogMayNotSeeAnObstacle) {
  for (const char* kind : {"drop_out", "stuck", "late, samples: 3", "lost, probability: 0.5"}) {
    Run({kGuideDog, "C1", {}, ""}, std::string("{at: obstacle, kind: ") + kind + ", start_s: 0.1}");
    EXPECT_EQ(exit_code, 0) << kind;
    EXPECT_EQ(Column(out, "fault_0.acting").back(), 1) << kind;
  }
}

TEST_F(FaultTest, ThoseOfOnePlaceFollowEachOther) {
  Run({kCdpr, "D1", {}, ""},
      "{at: command, kind: loss, size: 0.5, elements: [0], start_s: 0.1}, "
      "{at: command, kind: offset, size: 7, elements: [0], start_s: 0.1}");
  const std::vector<double> time = Column(out, "time [s]"), asked = Column(out, "loop.command.0 [N]"),
                            got = Column(out, "fault_1.y.0 [N]");
  for (std::size_t i = 0; i < time.size(); ++i)
    EXPECT_NEAR(got[i], time[i] > 0.0999 ? 0.5 * asked[i] + 7 : asked[i], 1e-6) << time[i];
}

TEST_F(FaultTest, ABrokenCableEndsARunThatForbidsSlack) {
  const auto summary = Run({kCdpr, "D1", {}, ""}, "{at: cable, kind: broken, elements: [2], start_s: 0.1}",
                           "--set forbid_slack=true");
  EXPECT_EQ(exit_code, 3);
  EXPECT_THAT(summary.at("end_reason").get<std::string>(), HasSubstr("cable 2 is slack"));
  EXPECT_FALSE(summary.at("fell").get<bool>());
  EXPECT_EQ(Column(out, "loop.plant.cables.tension.2 [N]").back(), 0);
}

TEST_F(FaultTest, AStuckWinchKeepsItsRestLength) {
  Run({kCdpr, "D1", {}, ""}, "{at: winch, kind: stuck, elements: [3], start_s: 0.1}");
  const std::vector<double> time = Column(out, "time [s]"),
                            stuck = Column(out, "loop.plant.cables.rest_length.3 [m]"),
                            other = Column(out, "loop.plant.cables.rest_length.1 [m]");
  for (std::size_t i = 1; i < time.size(); ++i) {
    if (time[i] > 0.1001) {
      EXPECT_EQ(stuck[i], stuck[i - 1]);
      EXPECT_NE(other[i], other[i - 1]);
    }
  }
}

TEST_F(FaultTest, ABrokenJointGivesNoTorqueWhateverIsCommanded) {
  Run({kQuadruped, "A1", {}, ""},
      "{at: joint, kind: broken, elements: [front_right_hip_pitch]}, "
      "{at: torque, kind: offset, size: 5, elements: [front_right_hip_pitch]}");
  const std::vector<double> torque = Column(out, "loop.world.plant.joint_torque.front_right_hip_pitch [N m]");
  for (std::size_t i = 1; i < torque.size(); ++i) EXPECT_EQ(torque[i], 0);
}

// scenario.yaml of a run is a scenario: it gives the same run again.
TEST_F(FaultTest, IsWrittenDownAndReadAgain) {
  const std::string faults =
      "{at: torque, kind: lost, probability: 0.3, start_s: 0.05}, {at: joint, kind: stuck, elements: "
      "[front_right_abduction]}";
  Run({kQuadruped, "A1", {}, ""}, faults);
  const std::string signals = Read(out / "signals.csv");
  const std::string scenario = out.string() + ".yaml";
  std::ofstream(scenario) << Read(out / "scenario.yaml");
  EXPECT_EQ(RunCommand(kQuadruped + " " + scenario + Out()).exit_code, exit_code);
  EXPECT_EQ(Read(out / "signals.csv"), signals);
  std::filesystem::remove(scenario);
}

class FaultUsageTest : public test::UsageTest {};
TEST_P(FaultUsageTest, IsRefused) {
  ExpectExitCode2WithItsMessage("");
}
#define TENON_QUADRUPED_FAULT(scenario, fault) TENON_QUADRUPED " " scenario " --set 'faults=[{" fault "}]'"
#define TENON_CDPR_FAULT(scenario, fault) TENON_CDPR " " scenario " --set 'faults=[{" fault "}]'"
INSTANTIATE_TEST_SUITE_P(
    Messages, FaultUsageTest,
    ::testing::Values(
        BadUsage{TENON_QUADRUPED_FAULT("A1", "kind: nan"), "faults.0"},
        BadUsage{TENON_QUADRUPED_FAULT("A1", "at: knee, kind: nan"), "torque_sensor"},
        BadUsage{TENON_QUADRUPED_FAULT("A1", "at: imu, kind: odd"), "drop_out"},
        BadUsage{TENON_QUADRUPED_FAULT("A1", "at: imu, kind: offset"),
                 "a fault of kind 'offset' needs size: give it"},
        BadUsage{TENON_QUADRUPED_FAULT("A1", "at: imu, kind: stuck, size: 1"),
                 "size is for spike, offset and loss, not for a fault of kind 'stuck': leave it away"},
        BadUsage{TENON_QUADRUPED_FAULT("A1", "at: imu, kind: late"), "needs samples"},
        BadUsage{TENON_QUADRUPED_FAULT("A1", "at: imu, kind: late, samples: 0"), "samples = 0"},
        BadUsage{TENON_QUADRUPED_FAULT("A1", "at: imu, kind: lost"), "needs probability"},
        BadUsage{TENON_QUADRUPED_FAULT("A1", "at: imu, kind: lost, probability: 2"), "probability = 2"},
        BadUsage{TENON_QUADRUPED_FAULT("A1", "at: imu, kind: offset, size: 1, period_s: 1"),
                 "period_s is for spike"},
        BadUsage{TENON_QUADRUPED_FAULT("A1", "at: imu, kind: spike, size: 1, period_s: 1e-5"),
                 "faults.0.at: at 'imu': period_s = 1e-05 is below the 0.001 s"},
        BadUsage{TENON_QUADRUPED_FAULT("A1", "at: imu, kind: stuck, start_s: -1"), "start_s = -1"},
        BadUsage{TENON_QUADRUPED_FAULT("A1", "at: imu, kind: stuck, duration_s: -1"), "duration_s = -1"},
        BadUsage{TENON_QUADRUPED_FAULT("A1", "at: imu, kind: stuck, elements: [gyro]"),
                 "faults.0.at: at 'imu': the signal has no element 'gyro': it has "},
        BadUsage{TENON_QUADRUPED_FAULT("A1", "at: torque, kind: loss, size: 1, elements: [12]"),
                 "the signal has no element '12'"},
        BadUsage{TENON_QUADRUPED_FAULT("A1", "at: imu, kind: broken"),
                 "faults.0.at: at 'imu': kind 'broken' is not possible there"},
        BadUsage{TENON_QUADRUPED_FAULT("A1", "at: joint, kind: nan"),
                 "faults.0.at: at 'joint': kind 'nan' is not possible there: give stuck or broken"},
        BadUsage{TENON_QUADRUPED_FAULT("A1", "at: joint, kind: stuck, elements: [12]"),
                 "elements: there is no joint '12', give some of front_left_abduction, front_left_hip_pitch"},
        BadUsage{TENON_QUADRUPED_FAULT("A1", "at: encoders, kind: stuck"), "set walk.state to estimated"},
        BadUsage{
            TENON_QUADRUPED_FAULT("A1",
                                  "at: foot_force, kind: stuck") " --set sensors.foot_force.mounted=none",
            "the feet have no sensors; set sensors.foot_force.mounted to world or shank"},
        BadUsage{TENON_QUADRUPED_FAULT("A1", "at: obstacle, kind: stuck"), "it is there for tenon-guide-dog"},
        BadUsage{TENON_QUADRUPED_FAULT("stand", "at: imu, kind: stuck"),
                 "it is there for a robot that walks"},
        BadUsage{TENON_GUIDE_DOG " C1 --set 'faults=[{at: obstacle, kind: nan}]'",
                 "faults.0.at: at 'obstacle': there is no number in the signal"},
        BadUsage{TENON_CDPR_FAULT("D1", "at: reference, kind: stuck"), "pd…"},
        BadUsage{TENON_CDPR_FAULT("D1 --controller pd", "at: pose, kind: stuck"), "mpc_"},
        BadUsage{TENON_CDPR_FAULT("D1", "at: winch, kind: broken"), "give stuck"},
        BadUsage{TENON_CDPR_FAULT("D1", "at: cable, kind: stuck"), "give broken"},
        BadUsage{TENON_CDPR_FAULT("D1", "at: cable, kind: broken, elements: [4]"), "there is no cable '4'"},
        BadUsage{TENON_CDPR_FAULT("D1", "at: cable, kind: broken, duration_s: 1"), "duration_s"}));

}  // namespace
}  // namespace tenon::faults_test
