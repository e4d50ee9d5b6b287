#include <tenon/plants/cdpr/cable_fault.h>
#include <tenon/plants/cdpr/cdpr_monitor.h>
#include <tenon/systems/primitives/constant.h>
#include <tenon/tests/plants/cdpr/cdpr_plant_test_robot.h>
#include <tenon/tests/testing/block_test.h>

namespace tenon::cdpr_monitor_test {

using test::FourCableRobot, test::Hanging, ::testing::HasSubstr;
using Kind = CableFaultKind;

/// Holds four cables, 800 N at most, with 100 N each, 2 m above the floor.
struct Rig : TestRig<CdprMonitor> {
  explicit Rig(const CdprMonitorParams& params = {.robot = test::FourCableRobot()}) : TestRig(params) {
    SetTension(100);
    SetPlatform(2);
  }
  void SetTension(double of_cable_2) {
    CableSignals cables = CableSignals::Zero(4);
    cables.tension.setConstant(100);
    cables.tension[2] = of_cable_2;
    Fix(system().cables, cables);
  }
  void SetPlatform(double height, double roll = 0) {
    PlatformState platform;
    platform.p_WB[2] = height;
    platform.q_WB = QuaternionFromRotationVector({roll, 0, 0});
    Fix(system().platform, platform);
  }
  RunStatus RunOn() { return simulator().AdvanceTo(context().time() + 0.5); }
};

TEST(CdprMonitorTest, EndsTheRunWhenACableIsSlack) {
  Rig rig;
  rig.SetTension(0.1);
  EXPECT_FALSE(rig.RunOn().ended);
  rig.SetTension(0);
  EXPECT_THAT(rig.RunOn().reason, HasSubstr("cable 2"));
}

TEST(CdprMonitorTest, ACableThatPullsNoHarderThanItsWeightIsSlack) {
  CdprMonitorParams params{.robot = test::FourCableRobot()};
  params.robot.cable.mass_per_length = 0.1;
  Rig rig(params);
  CableSignals cables = CableSignals::Zero(4);
  cables.rest_length.setConstant(5);
  cables.tension.setConstant(4.91);  // 0.1 kg/m of 5 m weigh 4.905 N
  rig.Fix(rig->cables, cables);
  EXPECT_FALSE(rig.RunOn().ended);
  cables.tension[1] = 4.9;
  rig.Fix(rig->cables, cables);
  EXPECT_THAT(rig.RunOn().reason, HasSubstr("cable 1"));
}

TEST(CdprMonitorTest, ACableHasALimitOfItsOwn) {
  CdprMonitorParams params{.robot = test::FourCableRobot()};
  params.robot.cables[2].tension_max = 300;
  Rig rig(params);
  rig.SetTension(329);
  EXPECT_FALSE(rig.RunOn().ended);
  rig.SetTension(331);
  EXPECT_THAT(rig.RunOn().reason, HasSubstrs("cable 2", "330 N"));
}

TEST(CdprMonitorTest, SlackMayBeAllowed) {
  Rig rig;
  rig.SetTension(0);
  rig.Set(rig->forbid_slack, false);
  EXPECT_FALSE(rig.RunOn().ended);
  rig.Set(rig->forbid_slack, true);
  EXPECT_TRUE(rig.RunOn().ended);
}

TEST(CdprMonitorTest, EndsTheRunWhenAWinchIsOverpowered) {
  Rig rig;
  rig.SetTension(879);
  EXPECT_FALSE(rig.RunOn().ended);
  rig.SetTension(881);
  EXPECT_THAT(rig.RunOn().reason, HasSubstrs("cable 2", "881 N"));
}

// The platform's box is drawn with half edges of 0.075, 0.075 and 0.093 m.
TEST(CdprMonitorTest, EndsTheRunWhenTheBoxReachesBelowTheFloor) {
  Rig rig;
  rig.SetPlatform(0.094);
  EXPECT_FALSE(rig.RunOn().ended);
  rig.SetPlatform(0.083);
  EXPECT_THAT(rig.RunOn().reason, HasSubstrs("block.place", "0.01 m"));
  const double on_edge = (0.075 + 0.093) / std::sqrt(2);
  Rig tilted;
  tilted.SetPlatform(on_edge + 0.001, M_PI / 4);
  EXPECT_FALSE(tilted.RunOn().ended);
  tilted.SetPlatform(on_edge - 0.001, M_PI / 4);
  EXPECT_TRUE(tilted.RunOn().ended);
  CdprMonitorParams deep{.robot = test::FourCableRobot()};
  deep.robot.floor = -1;
  Rig low(deep);
  low.SetPlatform(-0.9);
  EXPECT_FALSE(low.RunOn().ended);
  low.SetPlatform(-0.92);
  EXPECT_THAT(low.RunOn().reason, HasSubstr("below the floor at -1 m"));
}

// The anchors are sqrt(3.5² + 4.5²) = 5.701 m from their middle, which is 4 m high.
TEST(CdprMonitorTest, EndsTheRunFarFromTheAnchors) {
  Rig rig;
  rig.SetPlatform(15.4);
  EXPECT_FALSE(rig.RunOn().ended);
  rig.SetPlatform(1e30);
  EXPECT_THAT(rig.RunOn().reason, HasSubstrs("block.place", "11.4 m"));
}

TEST(CableFaultTest, OutputsTheFaultsOfItsSchedule) {
  TestRig<CableFault> rig({.num_cables = 3, .cables = {1}, .schedule = {.start = 0.001, .duration = 0.001}});
  EXPECT_TRUE(rig.Tick()[rig->faults].stuck.isZero(0));
  EXPECT_THAT(rig.Tick()[rig->faults].stuck, IsNear(Eigen::Vector3d(0, 1, 0), 0));
  EXPECT_TRUE(rig[rig->faults].broken.isZero(0));
  EXPECT_TRUE(rig.Tick()[rig->faults].stuck.isZero(0));

  CableFaults others{CableVector::Zero(3), CableVector::Zero(3)};
  others.broken[2] = 1;
  rig.Fix(rig->others, others).Tick();
  EXPECT_THAT(rig[rig->faults].broken, IsNear(Eigen::Vector3d(0, 0, 1), 0));
}

TEST(CableFaultTest, ABrokenCableStaysBroken) {
  TestRig<CableFault> rig({.kind = Kind::kBroken, .num_cables = 2});
  EXPECT_TRUE(rig.Fix(rig->active, false).Tick()[rig->faults].broken.isZero(0));
  EXPECT_TRUE(rig.Fix(rig->active, true).Tick()[rig->faults].broken.isOnes(0));
  EXPECT_TRUE(rig.Fix(rig->active, false).Tick()[rig->faults].broken.isOnes(0));
}

TEST(CableFaultTest, RefusesNonsense) {
  EXPECT_TRUE(Refuses<CableFault>({}, "num_cables"));
  EXPECT_TRUE(Refuses<CableFault>({.num_cables = 4, .cables = {4}}, "cable 4"));
  EXPECT_TRUE(
      Refuses<CableFault>({.kind = Kind::kBroken, .num_cables = 4, .schedule = {.duration = 1}}, "broke"));
}

/// A robot that hangs from four cables under its equilibrium's command, times `factor` for cable 0.
struct Robot {
  Robot(CdprPlantParams params, const CableFaultParams& fault_params, double factor) {
    DiagramBuilder builder;
    plant = &builder.Add<CdprPlant>("plant", params);
    fault = &builder.Add<CableFault>("fault", fault_params);
    CableVector command = params.initial_tension;
    command[0] *= factor;
    auto& winches = builder.Add<ConstantSource<CableVector>>(
        "winches", ConstantParams<CableVector>{.value = command, .unit = "N"});
    builder.Connect(winches.y, plant->command);
    builder.Connect(fault->faults, plant->faults);
    simulator.emplace(builder.Build(), SimulatorOptions{.rtol = 1e-7, .atol = 1e-9});
  }
  const CableSignals& CablesAt(double t) {
    simulator->RunTo(t);
    return simulator->context().Eval(plant->cables);
  }
  CdprPlant* plant;
  CableFault* fault;
  std::optional<Simulator> simulator;
};

CdprPlantParams InMode(WinchMode mode) {
  CdprDescription robot = FourCableRobot();
  robot.winch.mode = mode;
  if (mode == WinchMode::kTorque && !(robot.winch.effective_mass > 0)) robot.winch.effective_mass = 2;
  return Hanging(robot);
}

class WinchTest : public ::testing::TestWithParam<WinchMode> {};
INSTANTIATE_TEST_SUITE_P(Modes, WinchTest, ::testing::Values(WinchMode::kTension, WinchMode::kTorque),
                         [](const auto& info) { return std::string(EnumName(info.param)); });

// A stuck winch pays out nothing, whatever the command: its cable is a spring and damper of constant rest
// length.
TEST_P(WinchTest, AStuckOneKeepsTheRestLength) {
  const CdprPlantParams params = InMode(GetParam());
  Robot robot(params, {.num_cables = 4, .cables = {0}, .schedule = {.start = 0.05, .duration = 0.1}}, 1.5);
  const double free_before = robot.CablesAt(0.0).rest_length[0];
  const double stuck = robot.CablesAt(0.05).rest_length[0];
  EXPECT_GT(std::abs(stuck - free_before), 1e-6) << "the winch turns before";
  const CableProperties& cable = params.robot.cable;
  for (const double t : {0.06, 0.1, 0.1499}) {
    const CableSignals& cables = robot.CablesAt(t);
    EXPECT_NEAR(cables.rest_length[0], stuck, 1e-12);
    const double strain = cable.axial_stiffness / stuck * (cables.length[0] - stuck) +
                          cable.axial_damping / stuck * cables.length_rate[0];
    EXPECT_NEAR(cables.tension[0], std::max(0.0, strain), 1e-6);
  }
  EXPECT_GT(std::abs(robot.CablesAt(0.2).rest_length[0] - stuck), 1e-6) << "the winch turns again";
}

// After a cable breaks, the platform accelerates as the lost tension requires.
TEST_P(WinchTest, ABrokenCableDoesNotPull) {
  const CdprPlantParams params = InMode(GetParam());
  Robot robot(params, {.kind = Kind::kBroken, .num_cables = 4, .cables = {0}, .schedule = {.start = 0.01}},
              1);
  EXPECT_NEAR(robot.CablesAt(0.0099).tension[0], params.initial_tension[0], 1e-3);
  const Vec<3> span = params.robot.cables[0].anchor_W - params.p_WB - params.robot.cables[0].attachment_B;
  const double rest = robot.CablesAt(0.01).rest_length[0];
  EXPECT_THAT(robot.simulator->context().Eval(robot.plant->acceleration).a_W,
              IsNear(-params.initial_tension[0] / params.robot.mass * span.normalized(), 1e-3));
  for (const double t : {0.01, 0.1, 0.3}) {
    const CableSignals& cables = robot.CablesAt(t);
    EXPECT_EQ(cables.tension[0], 0);
    EXPECT_NEAR(cables.rest_length[0], rest, 1e-12);
  }
  EXPECT_LT(robot.simulator->context().Eval(robot.plant->platform).p_WB[2], params.p_WB[2] - 0.01);
}

TEST(CableFaultTest, ThePlantWantsOneEntryPerCable) {
  TestRig<CdprPlant> rig(Hanging());
  rig.Fix(rig->command, CableVector::Zero(4)).Fix(rig->faults, {CableVector::Zero(3), CableVector::Zero(3)});
  EXPECT_TRUE(Throws<RunError>([&] { rig.RunTo(0.01); }, "faults", "3", "4"));
}

}  // namespace tenon::cdpr_monitor_test
