// Apps with blocks of a user's own, called as the main function of a user's program calls them.

#include <tenon/apps/cdpr/cdpr_app.h>
#include <tenon/apps/guide_dog/guide_dog_app.h>
#include <tenon/apps/quadruped/quadruped_app.h>
#include <tenon/plants/attached_bodies.h>
#include <tenon/tests/apps/run_app.h>

#include <nlohmann/json.hpp>

// The shipped examples, called by their main functions.
namespace tenon::customisation_test {
#define main Main
namespace observer {
#include "../../../docs/examples/tutorial/main.cc"
}
namespace planner {
#include "../../../docs/examples/own_block/own_planner_app.cc"
}
namespace supervisor {
#include "../../../docs/examples/own_block/own_supervisor_app.cc"
}
namespace controller {
#include "../../../docs/examples/own_block/own_controller_app.cc"
}
#undef main

using apps::CdprApp, apps::GuideDogApp, apps::Outputs, apps::QuadrupedApp, apps::Tally, ::testing::AllOf,
    ::testing::HasSubstr, ::testing::StartsWith;

struct Keys {
  double gain_per_s = 30;
  static FieldList Fields() { return {{"gain_per_s", &Keys::gain_per_s}}; }
  void Validate() const { Demand(gain_per_s > 0, "gain_per_s must be positive"); }
};

struct CustomisationTest : test::AppTest {
  /// Runs an app with the scenario and options, and returns its exit code.
  int RunIn(const std::string& name, const auto& app, const std::vector<std::string>& arguments) const {
    return CallIn(
        name, [&](int argc, char** argv) { return app.Run(argc, argv); }, arguments);
  }
  /// Runs a main function in this way.
  int CallIn(const std::string& name, const auto& main, std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "my_app");
    arguments.insert(arguments.end(), {"--out", (out / name).string()});
    std::vector<char*> words;
    for (std::string& argument : arguments) words.push_back(argument.data());
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const int code = main(static_cast<int>(words.size()), words.data());
    text_ = ::testing::internal::GetCapturedStdout() + ::testing::internal::GetCapturedStderr();
    return code;
  }
  nlohmann::json SummaryOf(const std::string& name) const {
    return nlohmann::json::parse(ReadText(out / name / "summary.json"));
  }
  mutable std::string text_;  // stdout and stderr of the last run
};

const std::vector<std::string> kShort{"A1", "--duration", "0.1", "--set", "walk.judged_from_s=0"};

std::vector<std::string> With(std::vector<std::string> arguments, const std::vector<std::string>& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST_F(CustomisationTest, TheShippedObserverThroughTheHookGivesTheSameRun) {
  QuadrupedApp same;
  same.Customise([](DiagramBuilder& builder, QuadrupedWalk& walk) {
    const ComObserverParams params = walk.observer.com->params;
    builder.Replace<ComObserver>(*walk.observer.com, params);
  });
  ASSERT_EQ(RunIn("same", same, kShort), 0) << text_;
  ASSERT_EQ(RunIn("shipped", QuadrupedApp(), kShort), 0) << text_;
  EXPECT_EQ(ReadText(out / "same/signals.csv"), ReadText(out / "shipped/signals.csv"));
  EXPECT_EQ(SummaryOf("same")["com_error_max_m"], SummaryOf("shipped")["com_error_max_m"]);
}

/// An app whose observer estimates a constant force of `gain_per_s` N, and shows it.
QuadrupedApp AppOfGain() {
  QuadrupedApp app;
  app.Customise<Keys>([](DiagramBuilder& builder, QuadrupedWalk& walk, const Keys& keys, Outputs& outputs) {
    auto& guess = builder.AddFunction({"guess", "N"}, Uses(builder.time),
                                      [gain = keys.gain_per_s](double time) { return gain * time; });
    auto& trunk = builder.AddFunction({"trunk", "m"}, Uses(walk.world.plant.state),
                                      [](const LeggedState& x) { return x.p_WB; });
    auto& up = builder.AddFunction({"up", "N"}, Uses(guess), [](double f) { return Vec<3>(0, 0, f); });
    outputs.Arrow("the guess", ShapeRole::kEstimate, trunk, up, 0.01);
    outputs.Plot("the guess", {&guess});
    outputs.Figure("guess_max_N", guess, &Tally::max);
    outputs.Figure("guess_late_min_N", guess, &Tally::min, 0.05);
  });
  return app;
}

TEST_F(CustomisationTest, HasKeysSignalsPlotsAndFiguresOfItsOwn) {
  ASSERT_EQ(RunIn("run", AppOfGain(), With(kShort, {"--set", "custom.gain_per_s=40"})), 0) << text_;
  EXPECT_NEAR(SummaryOf("run")["guess_max_N"], 4, 1e-9);
  EXPECT_NEAR(SummaryOf("run")["guess_late_min_N"], 2, 1e-9);
  EXPECT_NEAR(test::Column(out / "run", "guess.output [N]").back(), 4, 1e-9);
  EXPECT_THAT(ReadText(out / "run/report.html"),
              HasSubstrs("\"title\":\"the guess\"", "\"name\":\"the guess\""));
  EXPECT_THAT(ReadText(out / "run/scenario.yaml"), HasSubstr("gain_per_s: 40"));
  // The written scenario repeats the run, and has the defaults of the customisation filled in.
  ASSERT_EQ(RunIn("again", AppOfGain(), {(out / "run/scenario.yaml").string(), "--duration", "0.1"}), 0);
  EXPECT_EQ(ReadText(out / "again/signals.csv"), ReadText(out / "run/signals.csv"));
  ASSERT_EQ(RunIn("default", AppOfGain(), kShort), 0) << text_;
  EXPECT_THAT(ReadText(out / "default/scenario.yaml"), HasSubstr("gain_per_s: 30"));
}

TEST_F(CustomisationTest, ListsAndChecksItsKeys) {
  ASSERT_EQ(RunIn("keys", AppOfGain(), {"--keys"}), 0);
  EXPECT_THAT(text_, HasSubstrs("custom.gain_per_s", "1/s", "profile"));
  EXPECT_EQ(RunIn("no", AppOfGain(), With(kShort, {"--set", "custom.gain=1"})), 2);
  EXPECT_THAT(text_, HasSubstrs("my_app: ", "custom.gain", "gain_per_s"));
  EXPECT_EQ(RunIn("no", AppOfGain(), With(kShort, {"--set", "custom.gain_per_s=-1"})), 2);
  EXPECT_THAT(text_, HasSubstr("--set custom.gain_per_s=-1: custom.gain_per_s: "));
  const std::string file = Write("a.yaml", "extends: A1\ncase: a\ncustom:\n  gain_per_s: 3\n  gein: 4\n");
  EXPECT_EQ(RunIn("no", AppOfGain(), {file}), 2);
  EXPECT_THAT(text_, HasSubstr("a.yaml:5:3: custom.gein"));
  // Neither a shipped app nor a robot that stands has such keys.
  EXPECT_EQ(RunIn("no", QuadrupedApp(), With(kShort, {"--set", "custom.gain_per_s=1"})), 2);
  EXPECT_THAT(text_, HasSubstr("custom"));
  EXPECT_EQ(RunIn("no", AppOfGain(), {"stand"}), 2);
  EXPECT_THAT(text_, HasSubstr("walks"));
}

/// A supervisor that lets every command pass.
struct NoSupervisor final : LeafSystem<void> {
  InputPort<WalkCommand> command{this, {"command"}};
  OutputPort<GuideStatus> status{this, {"status"}, Uses(), [] { return GuideStatus(); }};
  OutputPort<WalkCommand> walk{this, {"walk"}, Uses(command), [](const WalkCommand& c) { return c; }};
};

TEST_F(CustomisationTest, ErrorsOfTheHookNameTheKeyCustom) {
  QuadrupedApp app;
  app.Customise([](DiagramBuilder& builder, QuadrupedWalk&) { builder.Add<NoSupervisor>("a.b"); });
  EXPECT_NE(RunIn("no", app, kShort), 0);
  EXPECT_THAT(text_, HasSubstr("a.b"));
}

TEST_F(CustomisationTest, IsComparedWithTheShippedOnes) {
  ASSERT_EQ(RunIn("all", AppOfGain(), With(kShort, {"--set", "compare=[none]", "--compare"})), 0) << text_;
  const nlohmann::json summary = SummaryOf("all");
  EXPECT_EQ(summary["none"]["observer"], "none");
  EXPECT_FALSE(summary["none"].contains("guess_max_N"));
  EXPECT_TRUE(summary["mine"].contains("guess_max_N"));
  EXPECT_THAT(ReadText(out / "all/summary.json"), StartsWith("{\n  \"mine\"")) << "the page opens with it";
  ASSERT_EQ(RunIn("cables", CdprApp().Customise([](DiagramBuilder&, CdprLoop&) {}),
                  {"D1", "--duration", "0.02", "--compare"}),
            0)
      << text_;
  EXPECT_TRUE(SummaryOf("cables").contains("mine"));
  EXPECT_THAT(ReadText(out / "cables/summary.json"), StartsWith("{\n  \"mine\""));
}

TEST_F(CustomisationTest, ReplacesTheSupervisorOfAGuideDogAndTheControllerOfACableRobot) {
  GuideDogApp dog;
  dog.Customise(
      [](DiagramBuilder& builder, GuideDog& dog) { builder.Replace<NoSupervisor>(dog.supervisor); });
  EXPECT_EQ(RunIn("dog", dog, {"C1", "--duration", "0.1", "--set", "walk.judged_from_s=0"}), 0) << text_;
  CdprApp cables;
  cables.Customise<Keys>([](DiagramBuilder& builder, CdprLoop& loop, const Keys& keys) {
    CablePdParams params = loop.control.pd->params;
    params.damping_N_s_per_m *= keys.gain_per_s / 30;
    builder.Replace<CablePd>(*loop.control.pd, params);
  });
  const std::vector<std::string> pd{"D1", "--duration", "0.1", "--set", "controller=pd"};
  ASSERT_EQ(RunIn("cables", cables, pd), 0) << text_;
  ASSERT_EQ(RunIn("shipped", CdprApp(), pd), 0) << text_;
  EXPECT_EQ(ReadText(out / "cables/signals.csv"), ReadText(out / "shipped/signals.csv"));
  ASSERT_EQ(RunIn("cables", cables, With(pd, {"--set", "custom.gain_per_s=60"})), 0) << text_;
  EXPECT_NE(ReadText(out / "cables/signals.csv"), ReadText(out / "shipped/signals.csv"));
}

/// A shipped example, the shipped app that it extends, and a fault at each place that its blocks read.
struct Example {
  const char* name;
  const char* program;
  int (*main)(int, char**);
  std::function<int(int, char**)> shipped;
  std::vector<std::string> scenario;
  std::vector<std::string> places;
  std::vector<std::string> parts;  ///< mechanical faults
  friend void PrintTo(const Example& example, std::ostream* out) { *out << example.name; }
};
std::vector<Example> Examples() {
  const auto walk = [](int argc, char** argv) { return QuadrupedApp().Run(argc, argv); };
  const auto dog = [](int argc, char** argv) { return GuideDogApp().Run(argc, argv); };
  const auto cables = [](int argc, char** argv) { return CdprApp().Run(argc, argv); };
  const std::vector<std::string> joint{"at: joint, kind: stuck, elements: [front_left_knee]"},
      of_cables{"at: winch, kind: stuck, elements: [0]"},
      all{"torque", "torque_sensor", "foot_force", "imu", "state", "wrench"};
  return {{"observer",
           MY_OBSERVER,
           observer::Main,
           walk,
           {"A1"},
           {"torque", "foot_force", "state", "wrench"},
           joint},
          {"estimated",
           MY_OBSERVER,
           observer::Main,
           walk,
           {"estimated"},
           {"torque", "foot_force", "encoders", "imu", "state", "wrench"},
           joint},
          {"planner", OWN_PLANNER_APP, planner::Main, walk, {"A1"}, all, joint},
          {"supervisor", OWN_SUPERVISOR_APP, supervisor::Main, dog, {"C1"}, all, joint},
          {"controller",
           OWN_CONTROLLER_APP,
           controller::Main,
           cables,
           {"D1", "--set", "controller=pd_offset_free"},
           {"command", "lengths", "reference", "pose", "imu", "estimate"},
           of_cables}};
}

struct ExampleTest : CustomisationTest, ::testing::WithParamInterface<Example> {
  std::vector<std::string> For(const std::vector<std::string>& faults, const char* duration) const {
    std::string list;
    for (const std::string& fault : faults) list += "{" + fault + ", start_s: 0.01}, ";
    std::vector<std::string> arguments =
        With(GetParam().scenario, {"--duration", duration, "--set", "faults=[" + list + "]"});
    if (GetParam().scenario[0] != "D1") arguments = With(arguments, {"--set", "walk.judged_from_s=0"});
    return arguments;
  }
  std::vector<std::string> AllFaults() const {
    std::vector<std::string> faults;
    for (const std::string& place : GetParam().places)
      faults.push_back("at: " + place + ", kind: late, samples: 2");
    return With(faults, GetParam().parts);
  }
};

// A live run is repeated by its recording, so both write the same file.
TEST_P(ExampleTest, MeetsAllFaultsAloneAndLive) {
  const Example& example = GetParam();
  ASSERT_EQ(CallIn("live", example.main, With(For(AllFaults(), "0.05"), {"--live"})), 0) << text_;
  ASSERT_EQ(CallIn("replay", example.main,
                   With(For(AllFaults(), "0.05"), {"--replay", (out / "live/live.jsonl").string()})),
            0)
      << text_;
  EXPECT_EQ(ReadText(out / "live/signals.csv"), ReadText(out / "replay/signals.csv"));
  for (std::size_t i = 0; i < AllFaults().size(); ++i)
    EXPECT_EQ(test::Column(out / "live", "fault_" + std::to_string(i) + ".acting").back(), 1) << i;
  // Nothing of the example acts on the shipped blocks.
  const std::vector<std::string> run = For({}, "0.02");
  ASSERT_EQ(CallIn("shipped", example.shipped, run), 0) << text_;
  ASSERT_EQ(CallIn("as_shipped", example.main, With(run, {"--set", "custom.blocks=shipped"})), 0) << text_;
  EXPECT_EQ(ReadText(out / "shipped/signals.csv"), ReadText(out / "as_shipped/signals.csv"));
  EXPECT_THAT(ReadText(out / "as_shipped/scenario.yaml"), HasSubstr("blocks: shipped"));
}
INSTANTIATE_TEST_SUITE_P(Examples, ExampleTest, ::testing::ValuesIn(Examples()),
                         [](const auto& info) { return std::string(info.param.name); });

// A campaign compares the program's blocks with the shipped ones, and refuses a key that does not act.
TEST_P(ExampleTest, IsComparedByACampaign) {
  const Example& example = GetParam();
  const bool walks = example.scenario[0] != "D1";
  const auto run = [&](const std::string& vary) {
    const std::string file = Write(
        "blocks.yaml",
        std::string("app: ") + example.program + "\nscenario: " + example.scenario[0] +
            "\nduration_s: 0.05\nset: {" + (walks ? "walk.judged_from_s: 0" : "controller: pd_offset_free") +
            ", faults: [{at: " + example.places[0] + ", kind: late, samples: 2}]}\nvary: {" + vary + "}\n");
    return test::RunCommand(std::string(TENON_CAMPAIGN) + " " + file + " --jobs 1 --out " +
                            (out / "runs").string());
  };
  if (example.main == observer::Main) {
    const test::Result refused = run("observer: {list: [legs, none]}");
    EXPECT_EQ(refused.exit_code, 2) << refused.text;
    EXPECT_THAT(refused.text, HasSubstrs("observer", "custom.blocks"));
  }
  const test::Result result = run("custom.blocks: {list: [shipped, mine]}");
  ASSERT_EQ(result.exit_code, 0) << result.text;
  const std::string table = ReadText(out / "runs/runs.csv");
  EXPECT_THAT(table, HasSubstrs("custom.blocks", "\n0,1,shipped,", "\n1,1,mine,"));
  if (example.main == observer::Main) EXPECT_THAT(table, HasSubstrs(",dogbot,hybrid,", ",dogbot,mine,"));
}

class LongExampleTest : public ExampleTest {};

// Each kind of fault at each place, which changes the run or ends it with a reason.
TEST_P(LongExampleTest, MeetsEachFault) {
  const Example& example = GetParam();
  CallIn("none", example.main, For({}, "0.3"));
  const std::string undisturbed = ReadText(out / "none/signals.csv");
  for (const std::string& place : example.places) {
    for (const char* kind :
         {"drop_out", "stuck", "loss, size: 0.5", "late, samples: 20", "lost, probability: 0.9"}) {
      const std::string fault = "at: " + place + ", kind: " + kind;
      const int code = CallIn("run", example.main, For({fault}, "0.3"));
      EXPECT_THAT(code, ::testing::AnyOf(0, 3, 4)) << fault << text_;
      EXPECT_NE(ReadText(out / "run/signals.csv"), undisturbed) << fault;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(Examples, LongExampleTest, ::testing::ValuesIn(Examples()),
                         [](const auto& info) { return std::string(info.param.name); });

TEST_F(CustomisationTest, AFaultThatNoBlockReadsNamesThePortAndTheRemedy) {
  for (const auto& [place, port] : {std::pair{"imu", "'loop.world.inertial' (ImuMeasurement)"},
                                    {"torque_sensor", "'loop.world.measured_torque'"}}) {
    EXPECT_EQ(CallIn("no", observer::Main,
                     {"A1", "--set", std::string("faults=[{at: ") + place + ", kind: stuck}]"}),
              2);
    EXPECT_THAT(text_, HasSubstrs("faults.0.at: ", port, "input of your block")) << place;
  }
}

TEST_F(CustomisationTest, InputsThatTheBlockLacksAreNamedOnce) {
  const test::Result result =
      test::RunCommand(std::string(MY_OBSERVER) + " A1 --compare --duration 0.02 --set compare=[none] " +
                       "--set walk.judged_from_s=0" + Out());
  EXPECT_EQ(result.exit_code, 0) << result.text;
  const std::size_t first = result.text.find("'loop.observer' has no input");
  ASSERT_NE(first, std::string::npos) << result.text;
  EXPECT_THAT(result.text.substr(first), HasSubstrs("'imu' (ImuMeasurement)", "'torque'"));
  EXPECT_EQ(result.text.find("has no input", first + 20), std::string::npos);
}

TEST_F(CustomisationTest, AnObserverThatActsNoLongerIsRefused) {
  for (const std::vector<std::string>& chosen :
       {std::vector<std::string>{"--observer", "legs"}, {"--set", "observer=none"}}) {
    EXPECT_EQ(CallIn("no", observer::Main, With({"A1"}, chosen)), 2);
    EXPECT_THAT(text_, HasSubstrs("observer", "'loop.observer'", "custom.blocks")) << chosen[1];
    EXPECT_EQ(CallIn("yes", observer::Main, With(With(kShort, chosen), {"--set", "custom.blocks=shipped"})),
              0)
        << text_;
  }
  EXPECT_EQ(SummaryOf("yes")["observer"], "none");
}

/// Plants of another class, whose parameters the apps do not know.
struct OtherRobot final : Subdiagram {
  InputPort<Vec<12>> torque{this, {"torque", "N m"}};
  InputPort<ExternalForces> external{this, {"external"}, ExternalForces{}};
  OutputPort<LeggedState> state{this, {"state"}};
  OutputPort<Vec<12>> joint_torque{this, {"joint_torque", "N m"}},
      external_torque{this, {"external_torque", "N m"}};
  OutputPort<LeggedAcceleration> acceleration{this, {"acceleration"}};
  OutputPort<FootForces> foot_forces{this, {"foot_forces"}};
  OutputPort<WrenchEstimate> added_wrench{this, {"added_wrench"}}, external_wrench{this, {"external_wrench"}};
  explicit OtherRobot(const QuadrupedPlantParams& params) {
    auto& plant = Add<QuadrupedPlant>("inner", params);
    Connect(torque, plant.torque);
    Connect(external, plant.external);
    Connect(plant.state, state);
    Connect(plant.joint_torque, joint_torque);
    Connect(plant.external_torque, external_torque);
    Connect(plant.acceleration, acceleration);
    Connect(plant.foot_forces, foot_forces);
    Connect(plant.added_wrench, added_wrench);
    Connect(plant.external_wrench, external_wrench);
  }
};

TEST_F(CustomisationTest, LimitsOfAPlantWithUnknownParametersAreNotJudged) {
  QuadrupedApp app;
  app.Customise([](DiagramBuilder& builder, QuadrupedWalk& walk) {
    builder.Replace<OtherRobot>(walk.world.plant, QuadrupedPlantParams(walk.world.plant.params));
  });
  ASSERT_EQ(RunIn("run", app, kShort), 0) << text_;
  EXPECT_THAT(text_, HasSubstrs("limits of your block 'loop.world.plant'", "not judged"));
  EXPECT_FALSE(SummaryOf("run").contains("torque_max_N_m"));
  EXPECT_TRUE(SummaryOf("run")["com_error_max_m"].is_number());
  ASSERT_EQ(RunIn("again", app, kShort), 0);
  EXPECT_THAT(text_, ::testing::Not(HasSubstr("not judged"))) << "it is said once";
  // Nor is it known which body a shape on the live page is.
  ASSERT_EQ(RunIn("live", app, With(kShort, {"--live", "--graph", (out / "live.dot").string()})), 0) << text_;
  EXPECT_THAT(ReadText(out / "live.dot"),
              AllOf(HasSubstr("live_pull"), ::testing::Not(HasSubstr("live_forces"))));
}

// The oracle of a plant with other parameters is a scenario with these parameters.
TEST_F(CustomisationTest, FiguresAndLimitsAreThoseOfThePlantThatRuns) {
  const std::string body =
      "attached=[{name: tail, position_m: [-0.3, 0, 0.1], mass_kg: 1.5, centre_m: [-0.1, 0, 0], radius_m: "
      "0.05}]";
  AttachedBody tail{.name = "tail",
                    .on = "",
                    .position = {-0.3, 0, 0.1},
                    .mass = 1.5,
                    .centre = {-0.1, 0, 0},
                    .radius = 0.05};
  const auto extend = [&](DiagramBuilder& builder, QuadrupedWalk& walk) {
    QuadrupedPlantParams params = walk.world.plant.params;
    params.extend = Attach({tail});
    builder.Replace<QuadrupedPlant>(walk.world.plant, params);
  };
  QuadrupedApp walk;
  walk.Customise(extend);
  GuideDogApp dog;
  dog.Customise(extend);
  CdprApp fly;
  fly.Customise([&](DiagramBuilder& builder, CdprLoop& loop) {
    CdprPlantParams params = loop.world.plant.params;
    params.extend = AttachToPlatform({tail});
    builder.Replace<CdprPlant>(loop.world.plant, params);
  });
  const auto figures = [&](const std::string& name) {
    nlohmann::json summary = SummaryOf(name);
    for (const char* wall : {"wall_s", "real_time_factor", "qp_time_median_us", "qp_time_p99_us",
                             "mpc_time_median_us", "mpc_time_p99_us"})
      summary.erase(wall);
    return summary;
  };
  const auto compare = [&](const auto& mine, const auto& shipped, const std::vector<std::string>& run) {
    ASSERT_EQ(RunIn("mine", mine, run), 0) << text_;
    ASSERT_EQ(RunIn("shipped", shipped, With(run, {"--set", body})), 0) << text_;
    EXPECT_EQ(figures("mine"), figures("shipped"));
    EXPECT_TRUE(figures("mine").dump().find("clearance_min_m") != std::string::npos);
    EXPECT_EQ(ReadText(out / "mine/signals.csv"), ReadText(out / "shipped/signals.csv"));
    ASSERT_EQ(RunIn("live", mine, With(run, {"--live"})), 0) << text_;
  };
  compare(walk, QuadrupedApp(), kShort);
  ASSERT_EQ(RunIn("dog", dog, {"C1", "--duration", "0.05", "--set", "walk.judged_from_s=0"}), 0) << text_;
  EXPECT_THAT(ReadText(out / "dog/signals.csv"), HasSubstr("added_wrench"));
  compare(fly, CdprApp(), {"D1", "--duration", "0.05"});
}

TEST_F(CustomisationTest, ABodyThatEntersTheGroundEndsTheVerdict) {
  const char* low =
      "attached=[{name: anvil, joint: weld, position_m: [0, 0, -0.6], mass_kg: 0.1, radius_m: 0.1}]";
  EXPECT_EQ(RunIn("run", QuadrupedApp(), With(kShort, {"--set", low})), 3);
  EXPECT_THAT(SummaryOf("run")["end_reason"].get<std::string>(), HasSubstrs("ground", "anvil"));
  EXPECT_LT(SummaryOf("run")["added_clearance_min_m"], -0.005);
  const char* deep =
      "attached=[{name: anvil, joint: weld, position_m: [0, 0, -5], mass_kg: 0.1, radius_m: 0.1}]";
  EXPECT_EQ(RunIn("run", CdprApp(), {"D1", "--duration", "0.02", "--set", deep}), 3);
  EXPECT_THAT(SummaryOf("run")["end_reason"].get<std::string>(), HasSubstrs("floor", "anvil"));
}

TEST_F(CustomisationTest, RopesThatCannotHoldTheRobotAreRefused) {
  const std::vector<std::string> weak{"E1", "--set", "ropes.0.tension_max_N=30", "--set",
                                      "ropes.1.tension_max_N=30"};
  EXPECT_EQ(RunIn("no", QuadrupedApp(), weak), 2);
  EXPECT_THAT(text_, HasSubstrs("ropes: ", "tension_max_N"));
  EXPECT_EQ(RunIn("no", QuadrupedApp(), With(weak, {"--set", "start_height_m=0.1"})), 2);
  EXPECT_THAT(text_, HasSubstr("hangs"));
}

// A run that ends before the event is due is not judged by it.
TEST_F(CustomisationTest, ACaseWhosePointDidNotHappenIsNotFinished) {
  struct Missed {
    std::string phase, why, key;
  };
  for (const Missed& missed :
       {Missed{"activity: follow, speed_m_per_s: 0.1", "the leash never tightened", "leash_tight_at_s"},
        Missed{"activity: pull, force_N: 5", "never gave a direction", "direction_given_at_s"}}) {
    const auto run = [&](const char* duration) {
      return RunIn("dog", GuideDogApp(),
                   {"C1", "--duration", duration, "--set", "walk.judged_from_s=0", "--set",
                    std::string("person.phases=[{duration_s: 0.03, ") + missed.phase + "}]"});
    };
    EXPECT_EQ(run("0.02"), 0) << text_;
    EXPECT_EQ(run("0.05"), 3) << text_;
    const nlohmann::json summary = SummaryOf("dog");
    EXPECT_FALSE(summary["finished"].get<bool>());
    EXPECT_THAT(summary["end_reason"].get<std::string>(), HasSubstrs(missed.why, "0.03 s"));
    EXPECT_TRUE(summary[missed.key].is_null());
  }
}

}  // namespace tenon::customisation_test
