// Every shipped case with every fault that is possible there: the run goes on or ends with a reason, and the
// files that it writes are complete.

#include <tenon/tests/apps/run_app.h>

#include <nlohmann/json.hpp>

namespace tenon::faults_test {

using test::Column, test::Result, test::RunCommand, ::testing::AnyOf, ::testing::Contains,
    ::testing::HasSubstr;

const std::string kQuadruped = TENON_QUADRUPED, kGuideDog = TENON_GUIDE_DOG, kCdpr = TENON_CDPR;

struct FaultyCase {
  std::string app, scenario;
  std::vector<std::string> places;  ///< signals that can fail
  std::string mechanical;           ///< faults of mechanical parts
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

/// Every kind of fault with its parameters. Sizes are in the unit of the signal.
const std::vector<std::string> kKinds{"kind: drop_out",
                                      "kind: stuck",
                                      "kind: spike, size: 20, period_s: 0.005",
                                      "kind: offset, size: 0.5",
                                      "kind: loss, size: 0.5",
                                      "kind: late, samples: 5",
                                      "kind: lost, probability: 0.5"};

struct FaultsTest : test::AppTest, ::testing::WithParamInterface<FaultyCase> {
  /// Runs 0.2 s of a case with faults and returns its summary.
  nlohmann::json Run(const FaultyCase& faulty, const std::string& faults, const std::string& more = "") {
    const Result result = RunCommand(faulty.app + " " + faulty.scenario + " --duration 0.2 --set 'faults=[" +
                                     faults + "]' " + more + Out());
    exit_code = result.exit_code;
    EXPECT_THAT(exit_code, AnyOf(0, 3, 4)) << faulty.scenario << ", " << faults << ": " << result.text;
    const auto summary = nlohmann::json::parse(Summary());
    EXPECT_EQ(summary.at("finished").get<bool>(), exit_code == 0);
    EXPECT_NE(summary.at("end_reason"), "");
    EXPECT_EQ(summary.at("end_reason") == "end of the run", exit_code == 0) << summary.at("end_reason");
    EXPECT_THAT(ReadText(out / "report.html"), HasSubstr("</html>"));
    ExpectWholeRows(exit_code == 0 ? 0.2 : summary.at("simulated_s").get<double>());
    return summary;
  }
  void ExpectWholeRows(double end) const {
    const std::string text = Signals();
    ASSERT_TRUE(text.ends_with("\n"));
    std::istringstream file(text);
    std::string line;
    std::getline(file, line);
    const auto commas = std::count(line.begin(), line.end(), ',');
    double last = -1;
    for (; std::getline(file, line); last = std::stod(line))
      ASSERT_EQ(std::count(line.begin(), line.end(), ','), commas) << line;
    EXPECT_NEAR(last, end, 0.0101);  // signals are logged at 100 Hz or faster
  }

  int exit_code = -1;
};

// The kinds act one after the other, for 20 ms each. If one ends the run, another run takes the rest.
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
      if (end > 0.03) {  // the log has a row during the fault
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

// The error names the fault that made the NaN, not a block that reads it.
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

// Without sensors in the feet their forces are estimated from the torques, so contacts are lost with these.
TEST_F(FaultTest, ATorqueFaultChangesTheEstimatedFootForces) {
  Run({kQuadruped, "A1", {}, ""}, "{at: torque_sensor, kind: loss, size: 1, start_s: 0.1}",
      "--set sensors.foot_force.mounted=none");
  const std::vector<double> state = Column(out, "loop.locomotion.schedule.legs.front_left.state");
  EXPECT_EQ(state.front(), 0) << "stance";
  EXPECT_EQ(state.back(), 3) << "searching";
}

// Only the estimate of the pose uses the lengths.
TEST_F(FaultTest, ALengthFaultChangesTheCommand) {
  const auto command = [&](const std::string& faults) {
    Run({kCdpr, "D1", {}, ""}, faults);
    return Column(out, "loop.command.0 [N]").back();
  };
  EXPECT_NE(
      command("{at: lengths, kind: spike, size: 0.02, period_s: 0.05, elements: [length], start_s: 0.1}"),
      command(""));
}

// The log shows the signal behind the fault, as its kind says; the other elements are unchanged.
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

TEST_F(FaultTest, FaultsAtOnePlaceActInTheirOrder) {
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

TEST_F(FaultTest, ABrokenJointHasNoTorque) {
  Run({kQuadruped, "A1", {}, ""},
      "{at: joint, kind: broken, elements: [front_right_hip_pitch]}, "
      "{at: torque, kind: offset, size: 5, elements: [front_right_hip_pitch]}");
  const std::vector<double> torque = Column(out, "loop.world.plant.joint_torque.front_right_hip_pitch [N m]");
  for (std::size_t i = 1; i < torque.size(); ++i) EXPECT_EQ(torque[i], 0);
}

TEST_F(FaultTest, IsRepeatedFromTheWrittenScenario) {
  Run({kQuadruped, "A1", {}, ""},
      "{at: torque, kind: lost, probability: 0.3, start_s: 0.05}, "
      "{at: joint, kind: stuck, elements: [front_right_abduction]}");
  const std::string signals = Signals();
  const std::string scenario = Write("again.yaml", ReadText(out / "scenario.yaml"));
  EXPECT_EQ(RunCommand(kQuadruped + " " + scenario + Out()).exit_code, exit_code);
  EXPECT_EQ(Signals(), signals);
}

TEST_F(FaultTest, RefusesFaultsThatAreImpossible) {
  struct Bad {
    std::string app, scenario, fault, place;
  };
  for (const auto& [robot, scenario, fault, place] : std::vector<Bad>{
           {kQuadruped, "A1", "at: knee, kind: nan", "faults.0.at: "},
           {kQuadruped, "A1", "at: imu, kind: odd", "faults.0.kind: "},
           {kQuadruped, "A1", "at: imu, kind: offset", "faults.0: "},
           {kQuadruped, "A1", "at: imu, kind: stuck, size: 1", "faults.0.size: "},
           {kQuadruped, "A1", "at: imu, kind: lost, probability: 2", "faults.0.probability: "},
           {kQuadruped, "A1", "at: imu, kind: offset, size: 1, period_s: 1", "faults.0.period_s: "},
           {kQuadruped, "A1", "at: imu, kind: spike, size: 1, period_s: 1e-5",
            "faults.0.at: fault_0 at 'imu': period_s"},
           {kQuadruped, "A1", "at: imu, kind: stuck, elements: [gyro]", "faults.0.at: fault_0 at 'imu': "},
           {kQuadruped, "A1", "at: joint, kind: stuck, elements: [12]",
            "faults.0.at: fault_0 at 'joint': elements: "},
           {kQuadruped, "A1", "at: encoders, kind: stuck", "walk.state"},
           {kQuadruped, "A1 --set sensors.foot_force.mounted=none", "at: foot_force, kind: stuck",
            "sensors.foot_force.mounted"},
           {kQuadruped, "A1", "at: obstacle, kind: stuck", "guide dog"},
           {kQuadruped, "stand", "at: imu, kind: stuck", "torque, joint or encoders"},
           {kGuideDog, "C1", "at: obstacle, kind: nan", "faults.0.at: fault_0 at 'obstacle': "},
           {kCdpr, "D1", "at: reference, kind: stuck",
            "command, winch, cable, lengths, pose, imu or estimate"},
           {kCdpr, "D1 --controller pd", "at: pose, kind: stuck",
            "command, winch, cable, lengths or reference"},
           {kCdpr, "D1", "at: cable, kind: broken, duration_s: 1",
            "faults.0.at: fault_0 at 'cable': duration_s: "}}) {
    const Result result = RunCommand(robot + " " + scenario + " --set 'faults=[{" + fault + "}]'" + Out());
    EXPECT_EQ(result.exit_code, 2) << fault;
    EXPECT_THAT(result.text, HasSubstr(place)) << fault;
  }
}

}  // namespace tenon::faults_test
